//! The motion between two instants: lanes together by exponentials or fixed steps, and one by one through
//! events.

use feeler_lanes::{Lane, LaneMask};

use crate::carry::lane::LaneCore;
use crate::carry::peaks::{Abreast, Crest};
use crate::carry::transition::Transition;
use crate::error::{EngineError, RunEnd};
use crate::run::simulation::{Simulation, put_lane, take_lane};

/// Spans whose exponentials are kept; a span is worth one from its second appearance on.
const SPANS_KEPT: usize = 32;
/// Femtoseconds per second: spans are rounded to this grid, so that equal intervals share an exponential
/// whatever the rounding of their ends.
const FEMTOSECONDS: f64 = 1e15;

impl<L: Lane> Simulation<L> {
    /// Carries every lane over `span_s`.
    #[inline(always)]
    pub(crate) fn propagate(&mut self, span_s: f64) -> Result<(), EngineError> {
        if self.fixed.is_some() {
            return self.fixed_steps(span_s);
        }
        if self.lanes[0].ledger.is_some() {
            let strokes = self.strokes();
            self.go_alone(span_s)?;
            self.charge_controllers(&strokes);
            return Ok(());
        }
        // Mostly the same as the last, which is cheaper to see than to round.
        if let Some(last) = self.transitions.get(self.last_transition)
            && last.is_over(span_s)
        {
            return self.travel(self.last_transition);
        }
        let span_fs = (span_s * FEMTOSECONDS).round() as u64;
        let known = self.transitions.iter().position(|transition| transition.span_fs == span_fs);
        match known.or_else(|| self.learn(span_fs)) {
            Some(index) => {
                self.last_transition = index;
                self.travel(index)
            }
            None => self.go_alone(span_s),
        }
    }

    /// Makes a transition for a span that has been seen before, and remembers one that has not.
    #[cold]
    fn learn(&mut self, span_fs: u64) -> Option<usize> {
        if span_fs == 0 || self.transitions.len() == SPANS_KEPT {
            return None;
        }
        if !self.seen_spans.contains(&span_fs) {
            self.seen_spans.push_back(span_fs);
            if self.seen_spans.len() > SPANS_KEPT {
                self.seen_spans.pop_front();
            }
            return None;
        }
        self.transitions.push(Transition::new(span_fs, &self.lanes));
        Some(self.transitions.len() - 1)
    }

    /// All lanes together, by the exponential of the span; those that meet an event go on alone.
    #[inline(always)]
    fn travel(&mut self, index: usize) -> Result<(), EngineError> {
        self.transitions[index].refresh(self.formation.number, &mut self.lanes)?;
        let travelling = self.formation.travelling;
        if !travelling.all() {
            self.leave_behind(index, !travelling)?;
        }
        let mut together = travelling;
        let most_parts = self.transitions[index].most_parts;
        self.product.resize(self.transitions[index].padded_rows(), L::zero());
        for part in 0..most_parts {
            let transition = &self.transitions[index];
            let here = if most_parts == 1 {
                together
            } else {
                together & L::Mask::from_fn(|l| part < transition.parts[l])
            };
            if !here.any() {
                break;
            }
            self.steps += 1;
            let stopped = transition.look(here, &self.xi, &mut self.product);
            let moved = here & !stopped;
            if !self.peaks.is_empty() {
                let crests = transition.pass(moved, &self.product, part, self.t_s, &mut self.peaks);
                if crests.any() {
                    self.look_at_crests(index, part, crests)?;
                }
            }
            self.transitions[index].go(moved, &mut self.xi, &mut self.signals, &self.product);
            if stopped.any() {
                self.meet_events(index, part, stopped)?;
                together = together & !stopped;
            }
        }
        self.told = together;
        self.settle(together);
        Ok(())
    }

    /// Looks where within one part the forces of lanes crest; their motion is not touched.
    #[cold]
    fn look_at_crests(&mut self, index: usize, part: u64, lanes: L::Mask) -> Result<(), EngineError> {
        let transition = &self.transitions[index];
        for (l, lane) in self.lanes.iter_mut().enumerate().filter(|(l, _)| lanes.test(*l)) {
            for i in 0..self.peaks.len() {
                let Some(span) = transition.span(l, i, &self.product) else { continue };
                let from_s = self.t_s + part as f64 * span.length_s;
                match span.crest() {
                    Crest::None => {}
                    Crest::At { s, force_n } => self.peaks[i].rise_to(l, from_s + s, force_n),
                    Crest::Unclear => {
                        take_lane(&self.xi, l, &mut self.scratch);
                        let part_fs = transition.span_fs / transition.parts[l];
                        lane.exchange_peaks(&mut self.peaks, l, |lane| {
                            lane.crest(&mut self.scratch, from_s, part_fs)
                        })?;
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Lanes that cannot travel by exponentials go through the span alone.
    #[cold]
    fn leave_behind(&mut self, index: usize, lanes: L::Mask) -> Result<(), EngineError> {
        self.advance_lanes(lanes, self.transitions[index].span_fs as f64 / FEMTOSECONDS, |_| 0.0)
    }

    /// Lanes that may have met an event in one part of a span go through the rest of it alone.
    #[cold]
    fn meet_events(&mut self, index: usize, part: u64, lanes: L::Mask) -> Result<(), EngineError> {
        let span_s = self.transitions[index].span_fs as f64 / FEMTOSECONDS;
        let parts = self.transitions[index].parts.clone();
        self.advance_lanes(lanes, span_s, |l| span_s * part as f64 / parts[l] as f64)
    }

    /// Moves lanes alone to the end of a span, of which `gone_s` is behind them.
    fn advance_lanes(
        &mut self,
        lanes: L::Mask,
        span_s: f64,
        gone_s: impl Fn(usize) -> f64,
    ) -> Result<(), EngineError> {
        self.told = self.told & !lanes;
        let mut changed = false;
        for l in 0..L::WIDTH {
            if !lanes.test(l) || self.lanes[l].has_ended() {
                continue;
            }
            take_lane(&self.xi, l, &mut self.scratch);
            let gone_s = gone_s(l);
            let lane = &mut self.lanes[l];
            let mode = lane.current;
            let (xi, t_s) = (&mut self.scratch, self.t_s + gone_s);
            lane.exchange_peaks(&mut self.peaks, l, |lane| lane.advance(xi, t_s, span_s - gone_s))?;
            self.news |= !lane.events.is_empty();
            changed |= lane.current != mode || lane.has_ended();
            put_lane(&mut self.xi, l, &self.scratch);
        }
        if changed {
            self.formation.form(&self.lanes);
        }
        Ok(())
    }

    /// After a shared step: joins what sticks together, and ends lanes whose state has left all bounds.
    #[inline(always)]
    fn settle(&mut self, travelled: L::Mask) {
        let states = self.programs[0].motion.layout().states();
        let mut size = L::zero();
        for x in &self.xi[..states] {
            size += x.abs();
        }
        let fine = size.lt(L::splat(LaneCore::BOUND));
        if (travelled & !fine).any() {
            self.diverge(travelled & !fine);
        }
        if self.formation.any_joined {
            self.join(travelled);
        }
    }

    #[cold]
    fn diverge(&mut self, lanes: L::Mask) {
        for l in (0..L::WIDTH).filter(|&l| lanes.test(l)) {
            self.lanes[l].end = Some(RunEnd::Diverged { t_s: self.t_s });
        }
        self.formation.form(&self.lanes);
    }

    fn join(&mut self, lanes: L::Mask) {
        for l in (0..L::WIDTH).filter(|&l| lanes.test(l) && self.lanes[l].joins_bodies()) {
            take_lane(&self.xi, l, &mut self.scratch);
            self.lanes[l].join(&mut self.scratch);
            put_lane(&mut self.xi, l, &self.scratch);
        }
        self.told = self.told & L::Mask::from_fn(|l| !self.lanes[l].joins_bodies());
    }

    #[cold]
    fn go_alone(&mut self, span_s: f64) -> Result<(), EngineError> {
        self.steps += 1;
        self.advance_lanes(L::Mask::splat(true), span_s, |_| 0.0)
    }

    fn fixed_steps(&mut self, span_s: f64) -> Result<(), EngineError> {
        let Some(mut fixed) = self.fixed.take() else { return Ok(()) };
        let strokes = if self.lanes[0].ledger.is_some() { self.strokes() } else { Vec::new() };
        let result = fixed.run(&mut self.lanes, &mut self.formation, &mut self.xi, self.t_s, span_s);
        self.fixed = Some(fixed);
        self.steps += result?;
        self.news |= self.lanes.iter().any(|lane| !lane.events.is_empty());
        self.charge_controllers(&strokes);
        Ok(())
    }

    /// Strokes of all drives of all lanes.
    fn strokes(&self) -> Vec<Vec<f64>> {
        self.lanes.iter().enumerate().map(|(l, lane)| lane.strokes(&self.xi, l)).collect()
    }

    /// Charges each controller with its command times the stroke of the interval.
    fn charge_controllers(&mut self, before: &[Vec<f64>]) {
        for (l, before) in before.iter().enumerate() {
            let after = self.lanes[l].strokes(&self.xi, l);
            let assembly = self.programs[0].motion.assembly();
            let works = self.loops.iter().map(|control| {
                let is_force = assembly.drives[control.drive].velocity_source.is_none();
                if is_force {
                    control.output.lane(l) * (after[control.drive] - before[control.drive])
                } else {
                    0.0
                }
            });
            if let Some(ledger) = &mut self.lanes[l].ledger {
                ledger.charge_controllers(works);
            }
        }
    }
}

impl LaneCore {
    /// Lets a lane go on with the peaks that it found in company, and takes back what it finds.
    pub(crate) fn exchange_peaks<L: Lane, R>(
        &mut self,
        abreast: &mut [Abreast<L>],
        l: usize,
        go: impl FnOnce(&mut Self) -> R,
    ) -> R {
        if let Some(peaks) = &mut self.peaks {
            abreast.iter().enumerate().for_each(|(i, present)| present.give(peaks, i, l));
        }
        let result = go(self);
        if let Some(peaks) = &self.peaks {
            abreast.iter_mut().enumerate().for_each(|(i, present)| present.take(peaks, i, l));
        }
        result
    }

    /// Whether guides stick bodies to each other (a body that sticks to ground is at rest by its own
    /// equations).
    pub(crate) fn joins_bodies(&self) -> bool {
        self.flow().equations.joined.iter().any(|(_, lead)| lead.is_some())
    }

    fn strokes<L: Lane>(&self, xi: &[L], l: usize) -> Vec<f64> {
        let stroke = |row: &Vec<f64>| row.iter().zip(xi).map(|(r, x)| r * x.lane(l)).sum();
        self.flow().equations.stroke.iter().map(|rows| stroke(&rows[0])).collect()
    }
}
