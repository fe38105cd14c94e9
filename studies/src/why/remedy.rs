//! Remedies with their numbers, and their cost in bandwidth.

use feeler_engine::Scenario;
use feeler_plant::effects::Trait;

use super::applied::{
    add_damping, add_lead, fade, quicken_drives, raise_limits, refine_steps, scale_springs, shorten_delays,
    stop_windup,
};
use super::change::{
    ChatterCause, Counterfactual, SLOWER, affords, arriving_later, sample_faster, servos, slow_down,
};
use super::explanation::{CheckedRemedy, Explanation, Size};
use super::linear::{bandwidth_hz, gain_margin, scale_errors};
use super::roles::Roles;
use super::size::{Changed, Written, at_rest, mildest};
use crate::numbers::{plain, with_unit};
use crate::run::Measured;

/// Share of the largest stable gain that a loop uses.
const GAIN_SHARE: f64 = 0.5;
/// Factor on stiffness, damping or drive speed in a remedy with a lower gain.
const MORE: f64 = 4.0;
/// Trial sizes of a change with the gain kept, from mild to strong.
const TIMES: [f64; 3] = [2.0, 4.0, 16.0];
/// Trial sizes for quantities that can be reduced much further.
const MANY_TIMES: [f64; 6] = [2.0, 4.0, 16.0, 64.0, 256.0, 1024.0];
/// Trial values of joint damping, as shares of critical damping.
const SHARES: [f64; 5] = [0.03, 0.1, 0.25, 0.5, 1.0];

/// Applies a change of a size to a scenario.
type Apply<'a> = Box<dyn Fn(&mut Scenario, f64) + Sync + 'a>;

/// A family of changes, each with its factor or share.
struct Way<'a> {
    /// The change in words, for a size.
    what: Box<dyn Fn(f64) -> String + 'a>,
    apply: Apply<'a>,
    sizes: &'static [f64],
    /// The counterfactual whose size it gives.
    of: Option<Counterfactual>,
}

/// Remedies against these causes that settle in simulation, largest bandwidth first, and the sufficient
/// sizes of changes.
pub(super) fn remedies(
    scenario: &Scenario,
    found: &Explanation,
    baseline: &Measured,
) -> (Vec<CheckedRemedy>, Vec<Size>) {
    let wanted_hz = bandwidth_hz(scenario);
    let written = Written::new(scenario);
    let (mut remedies, mut sizes) = (Vec::new(), Vec::new());
    // If only the integrator makes the motion, a change of the machine would cure nothing real.
    let is_artefact = found.causes == [ChatterCause::NumericalArtefact];
    let ways = if is_artefact { against_errors(found) } else { ways(scenario, found, baseline) };
    for way in ways.into_iter().filter(|way| way.changes(scenario)) {
        let enough = mildest(&written, way.sizes, &way.apply);
        if let (Some(of), Some((times, changed))) = (way.of, &enough) {
            sizes.push(Size { of, what: (way.what)(*times), times: *times, settings: changed.words() });
        }
        if let Some((times, changed)) = enough {
            remedies.push(remedy(&written, &(way.what)(times), &changed, 1.0, wanted_hz));
        } else {
            let size = way.sizes.iter().copied().find(|size| *size >= MORE);
            let size = size.unwrap_or(way.sizes[way.sizes.len() - 1]);
            remedies.extend(lowered(&written, &(way.what)(size), &|s| (way.apply)(s, size), wanted_hz));
        }
    }
    if !is_artefact {
        let what = "a lower gain";
        // If linear theory allows the whole gain, a nonlinear property sets the limit. A guide that sticks
        // hunts at any gain of an integrator, only more slowly.
        let mut lower = lowered(&written, what, &|_| {}, wanted_hz);
        if lower.is_none() && !found.has(ChatterCause::StictionOrQuantiser) {
            let found = mildest(&written, &MANY_TIMES, |s, times| *s = with_gain(s, 1.0 / times));
            lower = found.map(|(times, changed)| remedy(&written, what, &changed, 1.0 / times, wanted_hz));
        }
        remedies.extend(lower);
    }
    remedies.sort_by(|a, b| a.cost.unwrap_or(f64::INFINITY).total_cmp(&b.cost.unwrap_or(f64::INFINITY)));
    (remedies, sizes)
}

fn cost(wanted_hz: Option<f64>, bandwidth_hz: Option<f64>) -> Option<f64> {
    wanted_hz.zip(bandwidth_hz).map(|(wanted, found)| 1.0 - found / wanted)
}

/// A change that settles, with a factor on the gain.
fn remedy(
    written: &Written,
    what: &str,
    changed: &Changed,
    gain_factor: f64,
    wanted_hz: Option<f64>,
) -> CheckedRemedy {
    let run_s = changed.scenario.run.duration_s;
    let over = if run_s > written.scenario.run.duration_s {
        format!(", over {}", with_unit(run_s, "s"))
    } else {
        String::new()
    };
    let bandwidth_hz = bandwidth_hz(&changed.scenario);
    CheckedRemedy {
        what: format!("{what}{over}"),
        settings: changed.words(),
        gain_factor,
        bandwidth_hz,
        cost: cost(wanted_hz, bandwidth_hz),
        settles: true,
    }
}

/// A change with as much of the gain as linear theory allows; `None` if nothing changes or settles.
fn lowered(
    written: &Written,
    what: &str,
    change: &dyn Fn(&mut Scenario),
    wanted_hz: Option<f64>,
) -> Option<CheckedRemedy> {
    let mut changed = written.scenario.clone();
    change(&mut changed);
    let gain_factor = gain_margin(&changed).map_or(1.0, |margin| (GAIN_SHARE * margin).min(1.0)).max(1e-3);
    let scaled = at_rest(written, |scenario| {
        change(scenario);
        *scenario = with_gain(scenario, gain_factor);
    })?;
    Some(remedy(written, what, &scaled, gain_factor, wanted_hz))
}

/// The scenario with the gains on errors scaled; damping stays.
fn with_gain(scenario: &Scenario, factor: f64) -> Scenario {
    let mut scaled = scenario.clone();
    scaled.controllers.values_mut().for_each(|used| scale_errors(&mut used.spec.law, factor));
    // The loop of a sampled servo is one of those; that of a continuous one belongs to the machine.
    for servo in servos(&mut scaled).filter(|servo| servo.period_s.is_some()) {
        (servo.kp, servo.ki) = (factor * servo.kp, factor * servo.ki);
    }
    scaled
}

/// Possible changes against each cause, and against any cause.
fn ways<'a>(scenario: &'a Scenario, found: &Explanation, baseline: &'a Measured) -> Vec<Way<'a>> {
    let mut ways = against_errors(found);
    ways.extend(of_delays(found));
    ways.extend(of_structure(scenario, found));
    ways.extend(of_limits(scenario, found, baseline));
    ways.extend(of_any(scenario));
    ways
}

impl<'a> Way<'a> {
    fn new(
        of: Option<Counterfactual>,
        sizes: &'static [f64],
        what: fn(f64) -> String,
        apply: impl Fn(&mut Scenario, f64) + Sync + 'a,
    ) -> Self {
        Self { what: Box::new(what), apply: Box::new(apply), sizes, of }
    }

    /// Whether the way changes more than the length of the run. For example, it cannot shorten a delay of
    /// zero.
    fn changes(&self, scenario: &Scenario) -> bool {
        let mut changed = scenario.clone();
        (self.apply)(&mut changed, self.sizes[self.sizes.len() - 1]);
        changed.run.duration_s = scenario.run.duration_s;
        changed != *scenario
    }
}

impl Explanation {
    fn has(&self, cause: ChatterCause) -> bool {
        self.causes.contains(&cause)
    }

    fn lifts_by(&self, change: Counterfactual) -> bool {
        self.lift.as_ref().is_some_and(|lift| lift.change == change)
    }
}

/// Changes against a wrong sign and the integrator.
fn against_errors(found: &Explanation) -> Vec<Way<'static>> {
    let mut ways = Vec::new();
    if found.wrong_sign {
        let what = |_: f64| String::from("the gains with the other sign");
        ways.push(Way::new(None, &[1.0], what, |s, _| *s = with_gain(s, -1.0)));
    }
    if found.has(ChatterCause::NumericalArtefact) {
        let what = |_: f64| String::from("integrate exactly");
        ways.push(Way::new(None, &[1.0], what, |s, _| s.run.integrator = feeler_engine::Integrator::Exact));
    }
    ways
}

/// Changes against delays and sampling.
fn of_delays(found: &Explanation) -> Vec<Way<'static>> {
    let mut ways = Vec::new();
    if found.has(ChatterCause::SamplingAndDelay)
        || found.lifts_by(Counterfactual::NoDelay)
        || found.lifts_by(Counterfactual::ContinuousController)
    {
        let what = |times: f64| format!("delays shorter and filters faster by a factor of {}", plain(times));
        ways.push(Way::new(Some(Counterfactual::NoDelay), &MANY_TIMES, what, shorten_delays));
        let what = |times: f64| format!("sampling {} times as fast", plain(times));
        ways.push(Way::new(Some(Counterfactual::ContinuousController), &TIMES, what, sample_faster));
    }
    ways
}

/// Changes against modes: stiffness and damping where they bend.
fn of_structure(scenario: &Scenario, found: &Explanation) -> Vec<Way<'static>> {
    let roles = Roles::of(&scenario.machine);
    let mut ways = Vec::new();
    if found.has(ChatterCause::NoncolocatedMode) {
        let springs = roles.transmissions.clone();
        let same = springs.clone();
        ways.push(Way::new(
            Some(Counterfactual::RigidTransmission),
            &TIMES,
            |times| format!("a transmission {} times as stiff", plain(times)),
            move |s, times| scale_springs(s, &springs, times, 1.0),
        ));
        ways.push(Way::new(
            None,
            &TIMES,
            |times| format!("a transmission with {} times the damping", plain(times)),
            move |s, times| scale_springs(s, &same, 1.0, times),
        ));
    }
    if found.has(ChatterCause::ColocatedMode) {
        let springs = [roles.mounts, roles.fixtures].concat();
        let same = springs.clone();
        ways.push(Way::new(
            None,
            &TIMES,
            |times| format!("{} times the damping of base and fixture", plain(times)),
            move |s, times| scale_springs(s, &springs, 1.0, times),
        ));
        ways.push(Way::new(
            None,
            &TIMES,
            |times| format!("base and fixture {} times as stiff", plain(times)),
            move |s, times| scale_springs(s, &same, times, 1.0),
        ));
    }
    ways
}

/// Changes against limits of drives, sensors and guides, and against the loss of contact.
fn of_limits<'a>(scenario: &Scenario, found: &Explanation, baseline: &'a Measured) -> Vec<Way<'a>> {
    let mut ways = Vec::new();
    if found.has(ChatterCause::ActuatorLag) || found.lifts_by(Counterfactual::IdealActuator) {
        let what = |times: f64| format!("a drive {} times as fast", plain(times));
        ways.push(Way::new(Some(Counterfactual::IdealActuator), &MANY_TIMES, what, quicken_drives));
    }
    if found.has(ChatterCause::Saturation) {
        let what = |times: f64| format!("limits {} times as high", plain(times));
        ways.push(Way::new(Some(Counterfactual::NoSaturation), &MANY_TIMES, what, raise_limits));
        let what = |_: f64| String::from("an integral that stops at the drive's limit");
        ways.push(Way::new(None, &[1.0], what, |s, _| stop_windup(s)));
    }
    if found.has(ChatterCause::StictionOrQuantiser) {
        ways.push(Way::new(
            Some(Counterfactual::NoFriction),
            &MANY_TIMES,
            |times| format!("friction {} times as small, by compensation or another guide", plain(times)),
            |s, times| fade(s, times, |effect| effect.has(Trait::DryFriction)),
        ));
        let what = |times: f64| format!("sensors and outputs {} times as fine", plain(times));
        ways.push(Way::new(Some(Counterfactual::NoQuantiser), &MANY_TIMES, what, refine_steps));
    }
    if found.has(ChatterCause::FreePlay) {
        let what = |times: f64| format!("free play {} times as small", plain(times));
        let apply = |s: &mut Scenario, times| fade(s, times, |effect| effect.has(Trait::FreePlay));
        ways.push(Way::new(Some(Counterfactual::NoFreePlay), &MANY_TIMES, what, apply));
    }
    if found.has(ChatterCause::SensorNoise) {
        ways.push(Way::new(
            Some(Counterfactual::NoNoise),
            &TIMES,
            |times| format!("sensors with {} times less noise", plain(times)),
            |s, times| s.machine.sensors.values_mut().for_each(|sensor| sensor.noise /= times),
        ));
    }
    if found.has(ChatterCause::LossOfContact) {
        let apply = move |s: &mut Scenario, times: f64| {
            slow_down(s, times);
            *s = arriving_later(s, baseline, times);
        };
        let what = |times: f64| format!("an approach {} times as slow", plain(times));
        let affordable =
            MANY_TIMES.partition_point(|&times| times <= SLOWER || affords(times, scenario, baseline));
        ways.push(Way::new(Some(Counterfactual::SlowerApproach), &MANY_TIMES[..affordable], what, apply));
    }
    ways
}

/// Changes against any cause.
fn of_any(scenario: &Scenario) -> Vec<Way<'static>> {
    let damping = |share: f64| format!("joint damping of {:.0} % of critical", 100.0 * share);
    let mut ways = vec![
        Way::new(None, &SHARES, damping, add_damping),
        Way::new(
            None,
            &TIMES,
            |times| format!("a pad on the tool, {} times as soft", plain(times)),
            |s, times| s.machine.contacts.values_mut().for_each(|contact| contact.stiffness /= times),
        ),
    ];
    // From the bandwidth of the loop upwards.
    ways.extend(bandwidth_hz(scenario).map(|zero_hz| Way {
        what: Box::new(move |times| {
            let [zero, pole] = [zero_hz, times * zero_hz].map(|frequency_hz| with_unit(frequency_hz, "Hz"));
            format!("a lead with its zero at {zero} and its pole at {pole}")
        }),
        apply: Box::new(move |s, times| add_lead(s, zero_hz, times)),
        sizes: &[MORE],
        of: None,
    }));
    ways
}
