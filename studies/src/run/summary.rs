//! The figures of a run, as programs read them.

use feeler_control::{GainPart, Law};
use feeler_engine::{EnergyBalance, Event, EventKind, RunEnd, Scenario, Trace};
use feeler_plant::assembly::{Assembly, Drive};
use feeler_plant::description::{Quantity, SignalName};
use feeler_plant::motion::Switch;
use serde::Serialize;

use crate::run::measure::chatter::{Oscillation, oscillation};
use crate::run::measure::contact::ContactRun;
use crate::run::measure::controlled::Controlled;
use crate::run::measure::energy::EnergyTable;
use crate::run::measure::force_loop::{ForceLoop, sensor_noise_n};
use crate::run::measure::saturation::{self, Limits};
use crate::run::measure::settling::{
    Answer, Ending, ForceResponse, RESTS_OVER, SETTLING_BAND, last_change_s,
};
use crate::run::measure::standing::{self, Standing};
use crate::run::measure::stiction;
use crate::run::measure::turns::turns;
use crate::run::measure::winding::{Command, commands_all};
use crate::run::record::event::EventRecord;
use crate::run::verdict::{Evidence, MOST_EXTENSION, Outcome, RunVerdict, Undecided};

/// Largest number of rows of the tail for its spectrum.
pub(super) const SPECTRUM_ROWS: usize = 1 << 16;
/// Number of turns, of eight cycles, that the last rows must have for a spectrum of them alone.
const LEAST_SPECTRUM_TURNS: usize = 16;

/// Results of a run. Forces in N and lengths in m; on a rotational axis read N m and rad.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the scenario.
    pub name: String,
    /// Class of the run, by its name.
    pub outcome: Outcome,
    /// Largest force of any contact, in magnitude.
    pub peak_force_n: f64,
    /// Peak force over the final reference less one, of the force-controlled contact; `None` without one.
    pub overshoot: Option<f64>,
    /// Time from the first touch or the last change of the reference (the later) until the force stays in its
    /// band. That is 2 % of the reference, or the sensor's uncertainty. `None` if it does not stay there.
    pub settling_time_s: Option<f64>,
    /// Lift-offs of the main contact.
    pub bounces: usize,
    /// Time in contact of the main contact.
    pub contact_time_s: f64,
    /// Time in contact as a share of the run.
    pub contact_share: f64,
    /// The oscillation of the main contact's force, if it lasts to the end.
    pub oscillation: Option<Oscillation>,
    /// Share of the controller samples at which a drive or controller was at its limit.
    pub saturation_share: f64,
    /// The response of the force-controlled contact to its reference; `None` without one.
    pub response: Option<ForceResponse>,
    /// Peak, first touch, lift-offs and time of each contact.
    pub contacts: Vec<ContactSummary>,
    /// Index of the contact of the outcome: the force-controlled one, else the one with the largest force.
    #[serde(skip)]
    pub main_contact: Option<usize>,
    /// How the outcome was judged.
    pub verdict: RunVerdict,
    /// The motion that decided the outcome; absent if a force did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controlled: Option<String>,
    /// Frequency of that motion if it does not come to rest but its oscillation is not known to last, Hz.
    #[serde(skip)]
    pub oscillation_hz: Option<f64>,
    /// Time, kind and place of each event, in order.
    pub events: Vec<EventRecord>,
    /// Supplied, dissipated and stored energy, J; `None` without a ledger.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyTable>,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Steps taken: intervals between instants and their parts, or fixed steps.
    pub steps: u64,
    /// Time for preparation, run and measures, s.
    pub wall_s: f64,
}

/// Number of points over the last fifth of a run at which motion of a surface is checked.
const LOOKS: u32 = 16;

/// A contact in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSummary {
    /// Name of the contact.
    pub name: String,
    /// Largest total force, in magnitude.
    pub peak_force_n: f64,
    /// Whether that is a pull, as a clamped contact may have.
    pub peak_is_pull: bool,
    /// Time of the largest force.
    pub peak_at_s: f64,
    /// First touch; `None` if it never touches.
    pub first_contact_s: Option<f64>,
    /// Number of lift-offs.
    pub bounces: usize,
    /// Time in contact.
    pub contact_time_s: f64,
    /// Time in contact as a share of the run.
    pub contact_share: f64,
}

/// A finished run, for the summary.
#[derive(Clone, Debug)]
pub(super) struct FinishedRun<'a> {
    pub(super) scenario: &'a Scenario,
    pub(super) assembly: &'a Assembly,
    pub(super) record: &'a Trace,
    pub(super) contacts: &'a [ContactRun],
    pub(super) force_loop: Option<&'a ForceLoop>,
    pub(super) limits: &'a Limits,
    pub(super) end: Option<RunEnd>,
    /// Simulated time reached, s.
    pub(super) end_s: f64,
    /// Whether no further extension is possible.
    pub(super) is_longest: bool,
    /// Whether this run is the last, without a longer one after it.
    pub(super) is_last: bool,
    /// Motion that had not ended at the end.
    pub(super) standing: &'a Standing,
    pub(super) steps: u64,
    pub(super) energy: Option<EnergyBalance>,
}

impl<'a> FinishedRun<'a> {
    pub(super) fn summary(&self) -> Summary {
        let main_contact = self.force_loop.map(|found| found.contact).or_else(|| self.hardest());
        let main = main_contact.map(|i| &self.contacts[i]);
        let answer = self.answer();
        let mut response = answer.map(|answer| answer.response());
        let verdict = self.verdict(main, response.as_ref());
        let follows = matches!(verdict.outcome, Outcome::Driven | Outcome::FollowsSurface);
        if let (true, Some(answer), Some(response)) = (follows, answer, response.as_mut()) {
            response.tracking = answer.tracking(verdict.tail_s[0]);
        }
        // A force that is within the band at the end by chance has not settled.
        if let Some(response) = response
            .as_mut()
            .filter(|_| !matches!(verdict.outcome, Outcome::Settled | Outcome::BouncesThenSettles))
        {
            response.settling_time_s = None;
        }
        let contact_time_s = main.map_or(0.0, ContactRun::contact_time_s);
        Summary {
            name: self.scenario.machine.name.clone(),
            outcome: verdict.outcome,
            peak_force_n: self.contacts.iter().map(|contact| contact.largest().force_n).fold(0.0, f64::max),
            overshoot: response.and_then(|response| response.overshoot),
            settling_time_s: response.and_then(|response| response.settling_time_s),
            bounces: main.map_or(0, |contact| contact.lifts_s.len()),
            contact_time_s,
            contact_share: self.share(contact_time_s),
            oscillation: verdict.outcome.is_sustained().then(|| self.oscillation(main, &verdict)),
            saturation_share: saturation::share(&self.limits.saturated),
            response,
            contacts: self.contacts.iter().map(|contact| self.contact(contact)).collect(),
            main_contact,
            verdict,
            controlled: self.controlled().map(|(found, ..)| found.signal.to_string()),
            oscillation_hz: self.oscillation_hz(main, &verdict),
            events: self.events(),
            energy: self.energy.as_ref().map(EnergyTable::new),
            simulated_s: self.end_s,
            steps: self.steps,
            wall_s: 0.0,
        }
    }

    fn share(&self, time_s: f64) -> f64 {
        if self.end_s > 0.0 { time_s / self.end_s } else { 0.0 }
    }

    fn contact(&self, contact: &ContactRun) -> ContactSummary {
        let largest = contact.largest();
        ContactSummary {
            name: contact.name.clone(),
            peak_force_n: largest.force_n,
            peak_is_pull: contact.pull.is_some(),
            peak_at_s: largest.t_s,
            first_contact_s: contact.first_contact_s(),
            bounces: contact.lifts_s.len(),
            contact_time_s: contact.contact_time_s(),
            contact_share: self.share(contact.contact_time_s()),
        }
    }

    fn hardest(&self) -> Option<usize> {
        let peak = |i: usize| self.contacts[i].largest().force_n;
        (0..self.contacts.len()).max_by(|&i, &j| peak(i).total_cmp(&peak(j)).then(j.cmp(&i)))
    }

    /// Events from the engine and from the record, in order.
    fn events(&self) -> Vec<EventRecord> {
        let of = |event: &Event| EventRecord {
            t_s: event.t_s,
            what: event.kind.name(),
            on: event.element(self.assembly).to_owned(),
        };
        let mut events: Vec<EventRecord> =
            self.record.events.iter().map(of).chain(self.limits.events.iter().cloned()).collect();
        events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        events
    }

    fn reference_n(&self, controller: &str) -> Option<&'a [f64]> {
        self.record.column(&SignalName::new(controller, Quantity::Reference).to_string())
    }

    fn answer(&self) -> Option<Answer<'a>> {
        let force_loop = self.force_loop?;
        let contact = &self.contacts[force_loop.contact];
        Some(Answer {
            t_s: &self.record.t_s,
            force_n: self.record.column(&contact.force_signal())?,
            reference_n: self.reference_n(&force_loop.name)?,
            peak_force_n: contact.peak_force_n,
            first_contact_s: contact.first_contact_s()?,
            unresolved_n: force_loop.unresolved_n(self.scenario),
        })
    }

    /// Amplitude that counts as rest, N. A force may rest anywhere within a step of its sensor. But an
    /// oscillation within that step is not rest.
    fn rest_n(&self, response: &ForceResponse) -> Option<f64> {
        let hidden_n = self.force_loop?.hidden_by_noise_n(self.scenario);
        response.final_reference_n.map(|_| response.share_n.max(hidden_n))
    }

    /// Behaviour of all controllers' references at the end.
    fn endings(&self) -> Vec<Ending> {
        let references = self.scenario.controllers.keys().filter_map(|name| self.reference_n(name));
        references.map(|reference_n| Ending::of(&self.record.t_s, reference_n)).collect()
    }

    fn verdict(&self, contact: Option<&ContactRun>, response: Option<&ForceResponse>) -> RunVerdict {
        let still = vec![0.0; self.record.t_s.len()];
        let (controlled, wanted) = self.controlled().map(|(found, _, wanted)| (found, wanted)).unzip();
        let force_n = self.judged_force_n(contact);
        let moves = response.is_some_and(|response| response.final_reference_n.is_none());
        let moved_s = wanted.as_deref().map(|wanted| last_change_s(&self.record.t_s, wanted));
        let starts_at_s = moved_s
            .or(response.map(|response| response.starts_at_s))
            .or(contact.and_then(ContactRun::first_contact_s));
        let sticks = self
            .record
            .events
            .iter()
            .filter(|event| matches!(event.kind, EventKind::Stick | EventKind::Slip));
        let sticks_s: Vec<f64> = sticks.map(|event| event.t_s).chain(self.bristles_s(starts_at_s)).collect();
        let plays = self.record.events.iter().filter(|event| matches!(event.switch, Switch::Stop(..)));
        let plays_s: Vec<f64> = plays.map(|event| event.t_s).collect();
        let horizon_s = MOST_EXTENSION * self.scenario.run.duration_s - self.end_s;
        let commands = self.commands();
        let endings = self.endings();
        let impacts: Vec<(f64, f64)> = contact.map_or_else(Vec::new, |contact| {
            let peaks = contact
                .intervals
                .iter()
                .zip(&contact.interval_peaks_n)
                .map(|(interval, peak)| (interval.start_s, *peak));
            peaks.filter(|(start, _)| starts_at_s.is_none_or(|from| *start >= from)).collect()
        });
        let lost = contact.filter(|contact| !contact.ends_in_contact(self.end_s));
        let evidence = Evidence {
            end: self.end,
            is_longest: self.is_longest,
            is_last: self.is_last,
            is_approaching: self.standing.is_approaching,
            is_on_its_way: self.standing.is_on_its_way(self.contacts, horizon_s),
            is_rendered: self.is_rendered(),
            wanted: wanted.as_deref(),
            surface_moves: self.surface_moves(contact),
            t_s: &self.record.t_s,
            force_n: force_n.unwrap_or(&still),
            driven: moves || (response.is_none() && endings.contains(&Ending::Moves)),
            has_just_moved: endings.contains(&Ending::JustMoved),
            moving_reference_n: self
                .force_loop
                .filter(|_| moves)
                .and_then(|found| self.reference_n(&found.name)),
            starts_at_s,
            lost_at_s: lost.and_then(|contact| contact.lifts_s.last().copied()),
            impacts: &impacts,
            lifts_s: contact.map_or(&[], |contact| &contact.lifts_s),
            saturated: &self.limits.saturated,
            sticks_s: &sticks_s,
            plays_s: &plays_s,
            commands: &commands,
            can_wind_up: self.can_wind_up(),
            band_n: match &wanted {
                Some(wanted) => Self::rest_of_motion(wanted, force_n),
                None => response.and_then(|response| self.rest_n(response)),
            },
            noise_n: controlled.map_or_else(|| sensor_noise_n(self.scenario), |found| found.noise),
        };
        let verdict = evidence.verdict();
        let approaches = verdict.undecided == Some(Undecided::StillApproaching);
        let touches_in_s = approaches.then(|| self.standing.touches_in_s(self.contacts)).flatten();
        RunVerdict { touches_at_s: touches_in_s.map(|in_s| self.end_s + in_s), ..verdict }
    }

    /// Whether nothing can touch although controllers act: a wall is then one that they render.
    fn is_rendered(&self) -> bool {
        !self.scenario.controllers.is_empty()
            && self
                .contacts
                .iter()
                .all(|contact| !standing::can_touch(contact) && contact.intervals.is_empty())
    }

    /// Without contact: the motion under control, its signal, and its reference.
    fn controlled(&self) -> Option<(Controlled, &'a [f64], Vec<f64>)> {
        let found = self.is_rendered().then(|| Controlled::find(self.scenario)).flatten()?;
        let values = self.record.column(&found.signal.to_string())?;
        let wanted = found.wanted(self.reference_n(&found.controller)?);
        Some((found, values, wanted))
    }

    /// Amplitude of a motion that counts as rest: a share of its reference, else of its largest value.
    fn rest_of_motion(wanted: &[f64], motion: Option<&[f64]>) -> Option<f64> {
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let last = wanted.last().map_or(0.0, |last| last.abs());
        let scale = [last, size(wanted), motion.map_or(0.0, size)].into_iter().find(|scale| *scale > 0.0);
        scale.map(|scale| SETTLING_BAND * scale)
    }

    /// Whether the surface moves to the end: a moving profile, or a body under the tool that a series of
    /// commands drives.
    fn surface_moves(&self, contact: Option<&ContactRun>) -> bool {
        let Some(contact) = contact else { return false };
        let profile = self.scenario.machine.profiles.get(&contact.name);
        let (from_s, to_s) = ((1.0 - RESTS_OVER) * self.end_s, self.end_s);
        let travels = profile.is_some_and(|profile| {
            let at = |share: f64| profile.at(from_s + share * (to_s - from_s)).0;
            (1..=LOOKS).any(|i| (at(f64::from(i) / f64::from(LOOKS)) - at(0.0)).abs() > 0.0)
        });
        let Some(touched) = self.scenario.machine.contacts.get(&contact.name) else { return travels };
        let driven = self.scenario.controllers.iter().any(|(name, used)| {
            let drive = self.scenario.machine.actuators.get(&used.drives);
            matches!(used.spec.law, Law::OpenLoop)
                && drive.is_some_and(|drive| drive.on == touched.between[1])
                && self
                    .reference_n(name)
                    .is_some_and(|values| Ending::of(&self.record.t_s, values) == Ending::Moves)
        });
        travels || driven
    }

    /// The force that decides the outcome: that of the contact. Without contact it is the controlled motion,
    /// else the force of the first drive.
    fn judged_force_n(&self, contact: Option<&ContactRun>) -> Option<&'a [f64]> {
        if let Some((_, values, _)) = self.controlled() {
            return Some(values);
        }
        if self.is_rendered() {
            return self.assembly.drives.iter().find_map(|drive| self.driven_n(drive));
        }
        self.record.column(&contact?.force_signal())
    }

    /// The recorded signal of a drive that shows its force.
    fn driven_n(&self, drive: &Drive) -> Option<&'a [f64]> {
        let quantity = if commands_all(drive) { Quantity::Command } else { Quantity::Force };
        self.record.column(&SignalName::new(&drive.name, quantity).to_string())
    }

    /// The drives that hold the force: that of the force loop, or all.
    fn holding(&self) -> impl Iterator<Item = &'a Drive> {
        let of_loop = self.force_loop.map(|found| &self.scenario.controllers[found.controller].drives);
        self.assembly.drives.iter().filter(move |drive| of_loop.is_none_or(|name| *name == drive.name))
    }

    /// The commands that hold the force.
    fn commands(&self) -> Vec<Command<'a>> {
        self.holding().filter_map(|drive| Some(Command::of(drive, self.driven_n(drive)?))).collect()
    }

    /// Whether something can stick while an integrator winds up the command.
    fn can_wind_up(&self) -> bool {
        let winds_up = |drive: &Drive| {
            let mut own = self.scenario.controllers.values().filter(|used| used.drives == drive.name);
            own.any(|used| integrates(&used.spec.law)) || drive.servo.is_some_and(|servo| servo.ki != 0.0)
        };
        self.assembly.links.iter().any(|link| link.friction.acts() || link.bristle.is_some())
            && self.holding().any(winds_up)
    }

    /// Instants in the tail at which a guide on bristles begins to rest or breaks loose, s. The last change
    /// before the tail is at `starts_at_s`.
    fn bristles_s(&self, starts_at_s: Option<f64>) -> Vec<f64> {
        let tail_s = 0.5 * (starts_at_s.unwrap_or(0.0) + self.end_s);
        let bristled = self.assembly.links.iter().filter_map(|link| {
            let spring = self.scenario.machine.springs.get(&link.name)?;
            Some(stiction::changes_s(self.record, &spring.between, &link.bristle?, tail_s))
        });
        bristled.flatten().collect()
    }

    fn oscillation_hz(&self, contact: Option<&ContactRun>, verdict: &RunVerdict) -> Option<f64> {
        let is_open = matches!(verdict.outcome, Outcome::Unstable | Outcome::Undecided);
        let is_moving = is_open && self.controlled().is_some() && verdict.amplitudes_n[2] > 0.0;
        let found = is_moving.then(|| self.oscillation(contact, verdict).frequency_hz);
        found.filter(|frequency_hz| *frequency_hz > 0.0)
    }

    fn oscillation(&self, contact: Option<&ContactRun>, verdict: &RunVerdict) -> Oscillation {
        let t_s = &self.record.t_s;
        let tail = t_s.partition_point(|&t| t < verdict.tail_s[0]);
        let column = self.judged_force_n(contact).unwrap_or_default();
        let rows = |first: usize| column.get(first..).unwrap_or_default();
        let mut first = tail.max(t_s.len().saturating_sub(SPECTRUM_ROWS));
        let mut spacing = 1;
        // A slow oscillation, such as hunting, needs the whole tail, and fewer of its rows.
        if first > tail && turns(rows(first)) < LEAST_SPECTRUM_TURNS {
            (first, spacing) = (tail, (t_s.len() - tail).div_ceil(SPECTRUM_ROWS));
        }
        let force_n: Vec<f64> = rows(first).iter().step_by(spacing).copied().collect();
        let steps = t_s.len().saturating_sub(first + 1).max(1) as f64;
        let from_s = t_s.get(first).copied().unwrap_or(0.0);
        let to_s = t_s.last().copied().unwrap_or(0.0);
        let (touches_s, spans) =
            contact.map_or((&[][..], &[][..]), |contact| (&contact.touches_s, &contact.intervals));
        oscillation(touches_s, spans, &force_n, spacing as f64 * (to_s - from_s) / steps, [from_s, to_s])
    }
}

/// Whether the output of a law moves on as long as an error lasts.
fn integrates(law: &Law) -> bool {
    let integral = law.gain(GainPart::Integral).and_then(|gain| gain.number(law));
    integral.is_some_and(|ki| ki != 0.0)
        // A virtual body without a spring moves on.
        || matches!(law, Law::Admittance(gains) if gains.stiffness == 0.0)
}
