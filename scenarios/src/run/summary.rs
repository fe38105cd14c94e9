//! The figures of a run, as programs read them.

use feeler_engine::{EnergyBalance, EventKind, RunEnd, Scenario, Trace};
use feeler_plant::assembly::Assembly;
use feeler_plant::description::{Quantity, SignalName};
use serde::Serialize;

use super::chatter::{Oscillation, oscillation};
use super::contact::ContactRun;
use super::energy::EnergyTable;
use super::force_loop::ForceLoop;
use super::outcome::{Evidence, Outcome, Verdict};
use super::saturation::{self, Limits};
use super::settling::{self, Answer, Response};

/// What a run came to. Forces in N and lengths in m; on a rotational axis read N m and rad.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the scenario.
    pub name: String,
    /// What became of the run.
    pub outcome: Outcome,
    /// Largest force of any contact.
    pub peak_force_n: f64,
    /// Peak force over the final reference less one, of the force-controlled contact.
    pub overshoot: Option<f64>,
    /// From the first touch or the last change of the reference (the later) until the force stays within 2 % of the reference (or what the sensor
    /// resolves); none where it does not.
    pub settling_time_s: Option<f64>,
    /// Lift-offs of all contacts.
    pub bounces: usize,
    /// Time in contact of the main contact.
    pub contact_time_s: f64,
    /// The same as a share of the run.
    pub contact_share: f64,
    /// The oscillation of the main contact's force, where it lasts to the end.
    pub oscillation: Option<Oscillation>,
    /// Share of the controller samples at which a drive or controller was at its limit.
    pub saturation_share: f64,
    /// The answer of the force-controlled contact to its reference.
    pub response: Option<Response>,
    /// Each contact.
    pub contacts: Vec<ContactSummary>,
    /// Index of the contact that the outcome refers to: the force-controlled one, else the one that pushed hardest.
    #[serde(skip)]
    pub main_contact: Option<usize>,
    /// How the outcome was judged.
    pub verdict: Verdict,
    /// Everything that happened, in order.
    pub events: Vec<EventRecord>,
    /// Where the energy came from and went, J.
    pub energy: EnergyTable,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Steps taken: intervals between instants and their parts, or fixed steps.
    pub steps: u64,
    /// Time that preparing, running and measuring took, s.
    pub wall_s: f64,
}

/// A contact in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactSummary {
    /// Its name.
    pub name: String,
    /// Largest total force.
    pub peak_force_n: f64,
    /// When.
    pub peak_at_s: f64,
    /// First touch; none where it never touches.
    pub first_contact_s: Option<f64>,
    /// Lift-offs.
    pub bounces: usize,
    /// Time in contact.
    pub contact_time_s: f64,
    /// The same as a share of the run.
    pub contact_share: f64,
}

/// An event in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventRecord {
    /// When.
    pub t_s: f64,
    /// `touch`, `lift`, `stick`, `slip`, `limit`, `release`.
    pub what: &'static str,
    /// The element.
    pub on: String,
}

/// How a simulation ended.
#[derive(Clone, Debug)]
pub(super) struct Ended {
    pub(super) end: RunEnd,
    pub(super) t_s: f64,
    pub(super) steps: u64,
    pub(super) energy: EnergyBalance,
}

pub(super) fn summarise(
    scenario: &Scenario,
    assembly: &Assembly,
    record: &Trace,
    contacts: &[ContactRun],
    force_loop: Option<&ForceLoop>,
    limits: &Limits,
    ended: &Ended,
) -> Summary {
    let end_s = match ended.end {
        RunEnd::Diverged { t_s } | RunEnd::EventStorm { t_s } => t_s,
        _ => ended.t_s,
    };
    let main = force_loop.map(|found| found.contact).or_else(|| hardest(contacts));
    let response = force_loop.and_then(|found| response(scenario, record, contacts, found));
    let verdict = verdict(scenario, record, main.map(|i| &contacts[i]), force_loop, response.as_ref(), &limits.saturated, ended, end_s);
    let sustained = main.filter(|_| verdict.outcome.is_sustained());
    let share = |time_s: f64| if end_s > 0.0 { time_s / end_s } else { 0.0 };
    let contact_time_s = main.map_or(0.0, |i| contacts[i].contact_time_s());
    let contact = |contact: &ContactRun| ContactSummary {
        name: contact.name.clone(),
        peak_force_n: contact.peak_force_n,
        peak_at_s: contact.peak_at_s,
        first_contact_s: contact.first_contact_s(),
        bounces: contact.lifts_s.len(),
        contact_time_s: contact.contact_time_s(),
        contact_share: share(contact.contact_time_s()),
    };
    Summary {
        name: scenario.machine.name.clone(),
        outcome: verdict.outcome,
        peak_force_n: contacts.iter().map(|contact| contact.peak_force_n).fold(0.0, f64::max),
        overshoot: response.and_then(|response| response.overshoot),
        settling_time_s: response.and_then(|response| response.settling_time_s),
        bounces: contacts.iter().map(|contact| contact.lifts_s.len()).sum(),
        contact_time_s,
        contact_share: share(contact_time_s),
        oscillation: sustained.map(|i| tail_oscillation(record, &contacts[i], &verdict)),
        saturation_share: saturation::share(&limits.saturated),
        response,
        contacts: contacts.iter().map(contact).collect(),
        main_contact: main,
        verdict,
        events: events(assembly, record, limits),
        energy: EnergyTable::new(&ended.energy),
        simulated_s: end_s,
        steps: ended.steps,
        wall_s: 0.0,
    }
}

/// Whether the reference of some controller moves to the end.
fn is_driven(scenario: &Scenario, record: &Trace) -> bool {
    let column = |name: &String| record.column(&SignalName::new(name, Quantity::Reference).to_string());
    scenario.controllers.keys().filter_map(column).any(|reference_n| settling::moves_to_the_end(&record.t_s, reference_n))
}

/// What the engine located and what the record shows, in order.
fn events(assembly: &Assembly, record: &Trace, limits: &Limits) -> Vec<EventRecord> {
    let located = record.events.iter().map(|e| EventRecord { t_s: e.t_s, what: e.kind.name(), on: e.element(assembly).to_owned() });
    let mut events: Vec<EventRecord> = located.chain(limits.events.iter().cloned()).collect();
    events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    events
}

fn hardest(contacts: &[ContactRun]) -> Option<usize> {
    (0..contacts.len()).max_by(|&i, &j| contacts[i].peak_force_n.total_cmp(&contacts[j].peak_force_n).then(j.cmp(&i)))
}

fn response(scenario: &Scenario, record: &Trace, contacts: &[ContactRun], force_loop: &ForceLoop) -> Option<Response> {
    let contact = &contacts[force_loop.contact];
    let answer = Answer {
        t_s: &record.t_s,
        force_n: record.column(&contact.force_signal())?,
        reference_n: record.column(&force_loop.reference_signal())?,
        peak_force_n: contact.peak_force_n,
        first_contact_s: contact.first_contact_s()?,
        unresolved_n: force_loop.unresolved_n(scenario),
    };
    Some(answer.response())
}

fn verdict(
    scenario: &Scenario,
    record: &Trace,
    contact: Option<&ContactRun>,
    force_loop: Option<&ForceLoop>,
    response: Option<&Response>,
    saturated: &[bool],
    ended: &Ended,
    end_s: f64,
) -> Verdict {
    let force_n = contact.and_then(|contact| record.column(&contact.force_signal()));
    let still = vec![0.0; record.t_s.len()];
    let moves = response.is_some_and(|response| response.final_reference_n.is_none());
    let reference_n = force_loop.filter(|_| moves).and_then(|found| record.column(&found.reference_signal()));
    let sticks_s: Vec<f64> = record.events.iter().filter(|e| matches!(e.kind, EventKind::Stick | EventKind::Slip)).map(|e| e.t_s).collect();
    let first_contact_s = contact.and_then(ContactRun::first_contact_s);
    let starts_at_s = response.map(|response| response.starts_at_s).or(first_contact_s);
    let impacts: Vec<(f64, f64)> = contact.map_or_else(Vec::new, |contact| {
        let peaks = contact.intervals.iter().zip(&contact.interval_peaks_n).map(|(interval, peak)| (interval.start_s, *peak));
        peaks.filter(|(start, _)| starts_at_s.is_none_or(|from| *start >= from)).collect()
    });
    let evidence = Evidence {
        end: ended.end,
        t_s: &record.t_s,
        force_n: force_n.unwrap_or(&still),
        driven: moves || (response.is_none() && is_driven(scenario, record)),
        moving_reference_n: reference_n,
        starts_at_s,
        lost_at_s: contact.filter(|contact| !contact.ends_in_contact(end_s)).and_then(|contact| contact.lifts_s.last().copied()),
        impacts: &impacts,
        lifts_s: contact.map_or(&[], |contact| &contact.lifts_s),
        saturated,
        sticks_s: &sticks_s,
        band_n: response.map(|response| response.band_n).filter(|_| !moves),
    };
    evidence.verdict()
}

fn tail_oscillation(record: &Trace, contact: &ContactRun, verdict: &Verdict) -> Oscillation {
    let first = record.t_s.partition_point(|&t| t < verdict.tail_s[0]).max(record.t_s.len().saturating_sub(super::SPECTRUM_ROWS));
    let force_n = record.column(&contact.force_signal()).and_then(|column| column.get(first..)).unwrap_or_default();
    let rows = record.t_s.len().saturating_sub(first + 1).max(1) as f64;
    let from_s = record.t_s.get(first).copied().unwrap_or(0.0);
    let to_s = record.t_s.last().copied().unwrap_or(0.0);
    oscillation(contact, force_n, (to_s - from_s) / rows, [from_s, to_s])
}
