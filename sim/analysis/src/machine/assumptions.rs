//! Nonlinear properties of a machine, and what linear theory assumes instead.

use feeler_catalogue::Tabled;
use feeler_control::ControllerSpec;
use feeler_plant::assembly::{Drive, Link, PositionForce};
use feeler_plant::description::{Actuator, Body, Contact, Engagement, Sensor, Spring};
use feeler_plant::effects::Kind;
use serde::Serialize;

use crate::loops::control_loop::ControlLoop;
use crate::machine::prepare::{FrictionView, PlayView, View};

/// One nonlinear property and its linear replacement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Assumption {
    /// Key of the element, such as `springs.transmission`.
    pub of: String,
    /// The property, such as `backlash`.
    pub property: &'static str,
    /// The assumption of the linear model.
    pub taken: String,
}

impl Assumption {
    /// Whether it is a spring that rounding loses beside far stiffer ones.
    pub(crate) fn is_of_lost_spring(&self) -> bool {
        self.taken == LOST
    }
}

impl ControlLoop {
    /// Every nonlinear property of machine and controllers with effects applied, and its linear replacement
    /// under `view`.
    pub fn assumptions(&self, view: &View) -> Vec<Assumption> {
        let mut found = Found(Vec::new());
        self.of_springs(view, &mut found);
        self.of_contacts(view, &mut found);
        self.assembly().drives.iter().for_each(|drive| of_drive(drive, &mut found));
        for weight in &self.assembly().weights {
            let is_of_spring = self.assembly().links.iter().any(|link| link.name == weight.name);
            let table = if is_of_spring { Spring::TABLE } else { Body::TABLE };
            let kind = match weight.course {
                PositionForce::Pull(_) => Kind::Gravity,
                PositionForce::Table(_) => Kind::ForceTable,
            };
            found.when(true, &format!("{table}.{}", weight.name), kind.name(), TANGENT);
        }
        for sensor in &self.assembly().sensors {
            let of = Sensor::place(&sensor.name);
            found.when(
                sensor.resolutions.iter().any(|q| *q > 0.0),
                &of,
                "quantisation",
                "left out: readings are continuous",
            );
            found.when(
                sensor.noise > 0.0,
                &of,
                "noise",
                "left out: it disturbs the loop and does not change it",
            );
        }
        for controller in self.controllers() {
            let (of, spec) = (ControllerSpec::place(&controller.name), &controller.spec);
            found.when(
                spec.jitter_s > 0.0,
                &of,
                "timing jitter",
                "left out: samples are exactly a period apart",
            );
            found.when(
                spec.output_resolution.is_some_and(|q| q > 0.0),
                &of,
                "quantisation",
                "left out: the output is continuous",
            );
            found.when(spec.output_limit.is_some(), &of, "output limit", NOT_REACHED);
            found.when(
                spec.approach.is_some(),
                &of,
                "approach",
                "left out: the law that follows it acts all the time",
            );
        }
        found.0
    }

    fn of_springs(&self, view: &View, found: &mut Found) {
        for link in &self.assembly().links {
            let of = Spring::place(&link.name);
            let play = match view.play {
                PlayView::Closed => {
                    "taken as closed: one flank bears, stiffness and damping act in full; a motion that \
                     crosses the gap meets less"
                }
                PlayView::Open => "taken as open: neither stiffness nor damping acts",
            };
            found.when(link.play > 0.0, &of, Kind::Backlash.name(), play);
            let friction = match view.friction {
                FrictionView::Ignored => {
                    "taken as sliding one way: a constant force, which neither damps nor holds; at rest it \
                     sticks instead"
                }
                FrictionView::Stuck if link.presliding.is_some() => {
                    "taken as sticking: a spring and a damper, as it yields"
                }
                FrictionView::Stuck => "taken as sticking: both bodies move as one",
            };
            found.when(link.friction.acts(), &of, "dry friction", friction);
            let lugre = "taken as not sliding: a spring and a damper, its bristles at rest";
            found.when(link.bristle.is_some(), &of, Kind::LugreFriction.name(), lugre);
            let mean = "taken as the mean of both directions";
            found.when(link.asymmetry != 0.0, &of, Kind::DirectionalDamping.name(), mean);
            let no_slope = "left out: at rest it has no slope; about a speed v it damps by 2 drag v";
            found.when(link.drag != 0.0, &of, Kind::QuadraticDrag.name(), no_slope);
            let at_rest = "taken as its slope at rest: a damping";
            found.when(link.over_speed.is_some(), &of, Kind::SpeedTable.name(), at_rest);
            found.when(link.stop.is_some(), &of, Kind::HardStop.name(), NOT_REACHED);
            let is_lost = !link.rigid && link.stiffness > 0.0 && self.is_lost(link);
            found.when(is_lost, &of, "stiffness", LOST);
            found.when(
                !link.rigid && link.cubic != 0.0,
                &of,
                "hardening",
                "taken as its tangent at the operating point",
            );
        }
    }

    /// Whether rounding hides the stiffness of a spring, because the other springs at both its ends are far
    /// stiffer.
    fn is_lost(&self, link: &Link) -> bool {
        let plant = self.plant();
        let (motion, layout) = (plant.motion(), plant.motion().layout());
        let held = |node: usize| {
            let g = motion.coordinates().of(node)?;
            Some(motion.coordinates().mass_kg(g) * plant.a()[(layout.v(g), layout.q(g))].abs())
        };
        let least = [link.a, link.b].into_iter().filter_map(held).fold(f64::INFINITY, f64::min);
        link.stiffness <= f64::EPSILON * layout.states() as f64 * least && least.is_finite()
    }

    fn of_contacts(&self, view: &View, found: &mut Found) {
        // The linearised contacts, in the order of those in the file.
        let taken = &self.plant().motion().assembly().contacts;
        for (contact, taken) in self.assembly().contacts.iter().zip(taken) {
            if taken.engagement == Engagement::Free {
                continue;
            }
            let of = Contact::place(&contact.name);
            let one_sided = "taken as never leaving: it pulls as well as it pushes";
            found.when(contact.engagement == Engagement::Unilateral, &of, "one-sided contact", one_sided);
            let preload_n = view.preload_n();
            let tangent = if preload_n > 0.0 {
                format!("taken as its tangent at {preload_n} N")
            } else {
                "taken as its tangent without force".into()
            };
            found.when(!contact.law.is_linear(), &of, "nonlinear contact law", &tangent);
            found.when(
                contact.profile.is_some(),
                &of,
                "surface",
                "taken as flat: it disturbs the loop and does not change it",
            );
        }
    }
}

/// Text for every force that depends on position.
const TANGENT: &str = "taken as its tangent where the machine rests: a stiffness";
/// Text for a spring between far stiffer ones.
const LOST: &str = "lost in rounding beside the stiffness of its neighbours: its slow modes are not \
     determined; join the stiffly held bodies rigidly";
/// Text for every limit.
const NOT_REACHED: &str =
    "taken as never reached; a separate check says whether the file's reference reaches it";

fn of_drive(drive: &Drive, found: &mut Found) {
    let of = Actuator::place(&drive.name);
    found.when(drive.limit.is_finite(), &of, "force limit", NOT_REACHED);
    found.when(drive.command_limit.is_finite(), &of, "supply voltage", NOT_REACHED);
    found.when(drive.line.is_some(), &of, "torque-speed line", NOT_REACHED);
    found.when(
        drive.warming.is_some(),
        &of,
        "thermal derating",
        "taken as cold: a warm drive gives less force for the same command",
    );
    found.when(drive.rate_limit.is_finite(), &of, "rate limit", NOT_REACHED);
    let target = drive.sampling().map(|sampling| sampling.target);
    found.when(
        drive.interval > 0.0 || target.is_some_and(|target| target.interval > 0.0),
        &of,
        "command interpolation",
        "taken as a delay of half its interval, and where commands come faster as a lag of it",
    );
    found.when(
        target.is_some_and(|target| target.error_deadband > 0.0),
        &of,
        "error deadband",
        "taken as crossed: the loop answers the whole error",
    );
    found.when(
        drive.imposed.is_some(),
        &of,
        "imposed motion",
        "taken as standing still: it disturbs the loop and does not change it",
    );
    found.when(
        drive.deadband > 0.0,
        &of,
        "deadband",
        "taken as crossed: the drive answers in full; a command inside it moves nothing",
    );
    found.when(drive.ripples.iter().any(|r| r.amplitude > 0.0), &of, "force ripple", TANGENT);
    found.when(drive.noise > 0.0, &of, "noise", "left out: it disturbs the loop and does not change it");
}

/// The assumptions found so far.
struct Found(Vec<Assumption>);

impl Found {
    fn when(&mut self, has: bool, of: &str, property: &'static str, taken: &str) {
        if has {
            self.0.push(Assumption { of: of.into(), property, taken: taken.into() });
        }
    }
}
