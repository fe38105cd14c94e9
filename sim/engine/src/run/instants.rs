//! What happens at an instant: delayed readings are taken, controllers sample, commands arrive, signals are
//! recorded. In this order.

use feeler_lanes::{Lane, LaneMask};
use feeler_plant::motion::ContactState;

use crate::error::EngineError;
use crate::observe::observer::Observer;
use crate::run::program::{Recorded, Tapped};
use crate::run::simulation::{Simulation, put_lane, take_lane};
use crate::sample::clock::{SAME_INSTANT_S, due};

impl<L: Lane> Simulation<L> {
    #[inline(always)]
    pub(crate) fn next_instant_s(&self) -> f64 {
        let earliest = |next: f64, other: f64| if other < next { other } else { next };
        let mut next = self.next_record_s;
        for control in &self.loops {
            next = earliest(next, control.next_sample_s);
        }
        if self.any_late {
            next = self.loops.iter().fold(next, |next, control| earliest(next, control.next_arrival_s()));
            next = self.drives.iter().fold(next, |next, drive| earliest(next, drive.next_arrival_s()));
        }
        next = self.taps.iter().fold(next, |next, tap| earliest(next, tap.next_s));
        self.gaps.iter().fold(next, |next, gap| earliest(next, gap.next_s()))
    }

    /// Serves every instant that is due.
    #[inline(always)]
    pub(crate) fn serve(&mut self, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        if !self.gaps.is_empty() {
            self.move_gaps();
        }
        self.refresh_signals();
        if !self.taps.is_empty() {
            self.take_taps();
        }
        for i in 0..self.loops.len() {
            while due(self.loops[i].next_sample_s, self.t_s) {
                self.sample(i)?;
            }
        }
        let recorded = due(self.next_record_s, self.t_s);
        if recorded {
            self.record_plant();
        }
        if self.any_late {
            self.arrivals()?;
        }
        if recorded {
            self.record_commands();
            observer.record(self.t_s, &self.record);
            self.records += 1;
            self.next_record_s = self.records as f64 / self.record_rate_hz;
        }
        Ok(())
    }

    /// Gaps whose pieces end now go on with the next.
    fn move_gaps(&mut self) {
        let t_s = self.t_s;
        let mut moved = false;
        for gap in &mut self.gaps {
            while due(gap.next_s(), t_s) {
                gap.next += 1;
                moved = true;
            }
        }
        if moved {
            for l in 0..L::WIDTH {
                take_lane(&self.xi, l, &mut self.scratch);
                // A little later than now: an instant may come before its time by less than that, and the
                // piece must be the next one.
                self.lanes[l].motion.set_gaps(t_s + SAME_INSTANT_S, &mut self.scratch);
                put_lane(&mut self.xi, l, &self.scratch);
            }
        }
    }

    fn take_taps(&mut self) {
        let t = self.t_s;
        for (i, control) in self.loops.iter().enumerate() {
            let clock = &self.programs[0].wiring[i].clock;
            for tap in [control.reading, control.motion].into_iter().flatten().filter_map(|(_, tap)| tap) {
                let value = self.signals[self.taps[tap].signal];
                self.taps[tap].take(t, value, |k| clock.sample_time_s(k));
            }
        }
        let rate_hz = self.record_rate_hz;
        for &tap in self.record_taps.iter().flatten() {
            let value = self.signals[self.taps[tap].signal];
            self.taps[tap].take(t, value, |k| k as f64 / rate_hz);
        }
    }

    #[inline(always)]
    fn read(&mut self, tapped: Tapped, tap: Option<usize>) -> L {
        let signal = tap.map_or(self.signals[tapped.signal], |tap| self.taps[tap].pop());
        self.sensors[tapped.sensor].read(self.t_s, signal)
    }

    #[inline(always)]
    fn sample(&mut self, i: usize) -> Result<(), EngineError> {
        let reading = self.loops[i].reading.map(|(tapped, tap)| self.read(tapped, tap));
        let motion = self.loops[i].motion.map(|(tapped, tap)| self.read(tapped, tap));
        let control = &mut self.loops[i];
        let (sample_s, output) = control.sample(i, &self.programs, reading, motion);
        if control.delay_s > 0.0 {
            control.pending.push_back((sample_s + control.delay_s, output));
            return Ok(());
        }
        self.apply(i, output)
    }

    /// Outputs and delayed commands that arrive now.
    #[inline(always)]
    fn arrivals(&mut self) -> Result<(), EngineError> {
        for i in 0..self.loops.len() {
            while due(self.loops[i].next_arrival_s(), self.t_s) {
                let Some((_, output)) = self.loops[i].pending.pop_front() else { break };
                self.apply(i, output)?;
            }
        }
        for i in 0..self.drives.len() {
            while due(self.drives[i].next_arrival_s(), self.t_s) {
                if let Some(input) = self.drives[i].arrive() {
                    self.set_input(i, input)?;
                }
            }
        }
        Ok(())
    }

    /// Output of controller `i` takes effect; controllers on one drive add.
    #[inline(always)]
    fn apply(&mut self, i: usize, output: L) -> Result<(), EngineError> {
        self.loops[i].output = output;
        let drive = self.loops[i].drive;
        let command = if self.loops.len() == 1 { output } else { self.command(drive) };
        match self.drives[drive].issue(self.t_s, command) {
            Some(input) => self.set_input(drive, input),
            None => Ok(()),
        }
    }

    /// What all controllers of a drive ask for.
    fn command(&self, drive: usize) -> L {
        let mut command = L::zero();
        for control in self.loops.iter().filter(|control| control.drive == drive) {
            command += control.output;
        }
        command
    }

    #[inline(always)]
    fn set_input(&mut self, drive: usize, input: L) -> Result<(), EngineError> {
        let layout = self.programs[0].motion.layout();
        if layout.ramp(drive).is_some() {
            return self.ramp_to(drive, input);
        }
        self.xi[layout.input(drive)] = input;
        Ok(())
    }

    /// A new input of a drive whose rate is limited: it starts to ramp there, which is another mode.
    #[cold]
    fn ramp_to(&mut self, drive: usize, input: L) -> Result<(), EngineError> {
        for l in 0..L::WIDTH {
            take_lane(&self.xi, l, &mut self.scratch);
            self.lanes[l].set_input(drive, input.lane(l), &mut self.scratch)?;
            put_lane(&mut self.xi, l, &self.scratch);
        }
        self.formation.form(&self.lanes);
        Ok(())
    }

    /// Brings the wanted signals up to date.
    #[inline(always)]
    fn refresh_signals(&mut self) {
        if !self.formation.all_linear {
            self.refresh_terms();
        }
        if !self.told.all() {
            self.look_up_signals();
        }
        // What follows at this instant changes inputs, and with them signals.
        self.told = L::Mask::splat(false);
    }

    #[inline(always)]
    fn look_up_signals(&mut self) {
        if self.signal_rows_at != self.formation.number {
            self.refresh_signal_rows();
        }
        self.signal_rows.apply(&self.xi, &mut self.looked_up);
        for (signal, &looked_up) in self.signals.iter_mut().zip(&self.looked_up) {
            *signal = L::select(self.told, *signal, looked_up);
        }
    }

    #[cold]
    fn refresh_terms(&mut self) {
        for (l, lane) in self.lanes.iter().enumerate().filter(|(_, lane)| !lane.flow().linear) {
            take_lane(&self.xi, l, &mut self.scratch);
            lane.motion.fill_terms(&lane.flow().equations, &mut self.scratch);
            put_lane(&mut self.xi, l, &self.scratch);
        }
    }

    #[cold]
    fn refresh_signal_rows(&mut self) {
        self.signal_rows_at = self.formation.number;
        for (l, lane) in self.lanes.iter().enumerate() {
            if self.signal_rows_for[l] != lane.current {
                self.signal_rows_for[l] = lane.current;
                for (i, row) in lane.flow().signals.iter().enumerate() {
                    self.signal_rows.set_row(l, i, row.as_deref().unwrap_or_default());
                }
            }
        }
    }

    fn record_plant(&mut self) {
        for i in 0..self.record.len() {
            self.record[i] = match self.programs[0].recorded[i] {
                Recorded::Plant(signal) => self.signals[signal],
                Recorded::Reading(sensor, signal) => {
                    self.read(Tapped { sensor, signal }, self.record_taps[i])
                }
                Recorded::Touch(contact, which) => L::from_fn(|l| {
                    let profile = self.lanes[l].motion.assembly().contacts[contact].profile.as_ref();
                    profile
                        .and_then(|profile| profile.touch_at(self.t_s))
                        .map_or(f64::NAN, |touch| touch[which])
                }),
                Recorded::Touching(contact) => L::from_fn(|l| {
                    f64::from(u8::from({
                        let lane = &self.lanes[l];
                        lane.motion.contact_state(lane.flow().equations.mode, contact)
                            == ContactState::Pushing
                    }))
                }),
                Recorded::Command(_) | Recorded::Output(_) | Recorded::Reference(_) => L::zero(),
            };
        }
    }

    fn record_commands(&mut self) {
        for (value, recorded) in self.record.iter_mut().zip(&self.programs[0].recorded) {
            match *recorded {
                Recorded::Command(i) => *value = self.drives[i].command,
                Recorded::Output(i) => *value = self.loops[i].output,
                Recorded::Reference(i) => *value = self.loops[i].reference,
                _ => {}
            }
        }
        if !self.formation.travelling.all() {
            for (l, _) in self.lanes.iter().enumerate().filter(|(_, lane)| lane.has_ended()) {
                self.record.iter_mut().for_each(|value| value.set_lane(l, f64::NAN));
            }
        }
    }
}
