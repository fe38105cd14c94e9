//! The element of a trial effect, and features of the records.

use std::f64::consts::TAU;

use feeler_catalogue::Key;
use feeler_plant::assembly::{Assembly, assemble};
use feeler_plant::description::{ActuatorKind, Body, Contact, ElementKind, Machine, Site, Spring};
use feeler_plant::effects::{EffectUse, Host};
use indexmap::IndexMap;

use crate::tolerance;

/// An element of the believed machine with a trial effect.
pub(crate) struct Element<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) host: Host,
    /// Key of the element in the file, such as `springs.guide`.
    pub(crate) key: String,
    /// Tolerances stated in the file, by key; `None` if the element's values are known exactly.
    tolerance: Option<&'a IndexMap<String, f64>>,
}

/// The library's host for an element.
pub(crate) fn host_of(site: Site) -> Host {
    match site.table {
        // Node 0 is the ground.
        ElementKind::Bodies => Host::Body(site.index + 1),
        ElementKind::Springs => Host::Spring(site.index),
        ElementKind::Contacts => Host::Contact(site.index),
        ElementKind::Actuators => Host::Actuator(site.index),
        ElementKind::Sensors => Host::Sensor(site.index),
    }
}

impl<'a> Element<'a> {
    /// The element of a machine at a site, with the tolerances stated in its file.
    pub(crate) fn at(site: Site, machine: &'a Machine, tolerance: &'a IndexMap<String, f64>) -> Self {
        Element { machine, host: host_of(site), key: site.key(machine), tolerance: Some(tolerance) }
    }

    /// The element without tolerances.
    pub(crate) fn known_exactly(&self) -> Self {
        Element { key: self.key.clone(), tolerance: None, ..*self }
    }

    pub(crate) fn body(&self) -> Option<&Body> {
        let Host::Body(node) = self.host else { return None };
        self.machine.bodies.get_index(node.checked_sub(1)?).map(|(_, body)| body)
    }

    pub(crate) fn spring(&self) -> Option<&Spring> {
        let Host::Spring(i) = self.host else { return None };
        self.machine.springs.get_index(i).map(|(_, spring)| spring)
    }

    pub(crate) fn contact(&self) -> Option<&Contact> {
        let Host::Contact(i) = self.host else { return None };
        self.machine.contacts.get_index(i).map(|(_, contact)| contact)
    }

    /// Whether the element is a drive with its own position loop.
    pub(crate) fn is_servo(&self) -> bool {
        let Host::Actuator(i) = self.host else { return false };
        let drive = self.machine.actuators.get_index(i);
        drive.is_some_and(|(_, drive)| matches!(drive.kind, ActuatorKind::PositionServo(_)))
    }

    /// Travel of the driven body per turn of the element's motor, m or rad; `None` if the element has none.
    pub(crate) fn motor_turn(&self) -> Option<f64> {
        let Host::Actuator(i) = self.host else { return None };
        match &self.machine.actuators.get_index(i)?.1.kind {
            ActuatorKind::DcMotor(motor) => Some(TAU / motor.gear_ratio),
            _ => None,
        }
    }

    /// The assembled machine.
    pub(crate) fn assembly(&self) -> Option<Assembly> {
        assemble(self.machine).ok()
    }

    /// The tolerance of a value of the element, as a fraction.
    pub(crate) fn tolerance(&self, value: &Key, default: f64) -> f64 {
        let Some(stated) = self.tolerance else { return 0.0 };
        stated.get(&format!("{}.{}", self.key, value.name)).copied().unwrap_or(default)
    }

    /// The believed effects of the element's spring.
    pub(crate) fn laws(&self) -> &[EffectUse] {
        self.spring().map_or(&[], |spring| spring.effects.as_slice())
    }

    /// Whether the tolerance of a believed law of friction includes these first values.
    pub(crate) fn is_within(&self, law: &EffectUse, values: &[f64]) -> bool {
        let rows = values.iter().zip(&law.values).zip(law.definition.parameters);
        rows.map(|((own, believed), parameter)| ((own / believed).ln().abs(), parameter.name))
            .all(|(off, name)| off <= self.tolerance_of_friction(law, name).ln_1p())
    }

    /// The tolerance of a parameter of a believed law of friction, as a fraction.
    fn tolerance_of_friction(&self, law: &EffectUse, parameter: &str) -> f64 {
        let Some(stated) = self.tolerance else { return 0.0 };
        let key = format!("{}.effects.{}.{parameter}", self.key, law.definition.kind);
        stated.get(&key).copied().unwrap_or(tolerance::DAMPING)
    }
}

/// Delay of a command that is not a finding, rows. A held command acts half a row after its row; fits are off
/// by some hundredths.
pub(crate) const LATE_ROWS: f64 = 0.55;
/// Smaller delays are no sure finding, rows: the timing of a held command is known to half a row only.
pub(crate) const SURELY_LATE_ROWS: f64 = 1.0;

/// Share of the largest speed below which a guide practically sticks.
const AS_GOOD_AS_STUCK: f64 = 0.01;

/// The range that the records cover.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// The least and the largest position, m.
    pub(crate) ends_m: [f64; 2],
    /// The largest command, N.
    pub(crate) command_n: f64,
    /// The fastest motion, m/s.
    pub(crate) speed_m_per_s: f64,
    /// The finest step of an encoder if only encoders measure the motion, m; zero otherwise.
    pub(crate) step_m: f64,
    /// Uncertainty of the instant at which a command acts, s: one row without a stated hold, otherwise zero.
    pub(crate) instant_s: f64,
}

impl Seen {
    /// Range of the positions, m.
    pub(crate) fn stroke_m(self) -> f64 {
        let [low, high] = self.ends_m;
        (high - low).max(0.0)
    }

    /// The range for a drive whose commands act this many rows late; `None` if their instants are known. A
    /// total delay above [`LATE_ROWS`] is a finding.
    pub(crate) fn beside(self, late_rows: Option<f64>) -> Self {
        Self { instant_s: late_rows.map_or(0.0, |rows| self.instant_s * (LATE_ROWS - rows)), ..self }
    }

    /// Whether a command with this delay is within the uncertainty of timing.
    pub(crate) fn is_in_time(&self, late_s: f64) -> bool {
        late_s < self.instant_s
    }

    /// Whether a guide practically sticks below this speed. A level that falls within these speeds cannot be
    /// distinguished from presliding.
    pub(crate) fn is_stuck_below(&self, speed_m_per_s: f64) -> bool {
        speed_m_per_s < AS_GOOD_AS_STUCK * self.speed_m_per_s
    }

    /// Whether a motion of this size is below the resolution of the encoders.
    pub(crate) fn is_lost(&self, size_m: f64) -> bool {
        size_m < self.step_m
    }
}

/// Features of the records from which fits start.
#[derive(Clone, Debug, Default)]
pub(crate) struct Glance {
    /// Largest force command, or force of the first drive if its command is not a force, N.
    pub(crate) command: f64,
    /// Largest command, in its unit.
    pub(crate) asked: f64,
    /// Largest change of a command between rows, in its unit.
    pub(crate) command_change: f64,
    /// Row spacing, s.
    pub(crate) spacing_s: f64,
    /// Length of the longest record, with the previous records on its clock, s.
    pub(crate) duration_s: f64,
    /// Largest contact force measured, N.
    pub(crate) force: f64,
    /// Fastest motion, m/s.
    pub(crate) speed: f64,
    /// Quantisation steps of channels, by sensor.
    pub(crate) quanta: Vec<(usize, f64)>,
    /// Missing force over position, `(x, F)`.
    pub(crate) missing: Vec<(f64, f64)>,
    /// Apparent offset of each contact's surface, from the positions of the bodies when a force is measured.
    pub(crate) surfaces: Vec<(usize, f64)>,
    /// Range of the measured elongation of each spring with position sensors on both bodies.
    pub(crate) elongations: Vec<(usize, f64)>,
}

impl Glance {
    /// Range of the measured elongation of a spring; `None` if it is not measured.
    pub(crate) fn elongation(&self, host: Host) -> Option<f64> {
        self.elongations.iter().find(|(spring, _)| host == Host::Spring(*spring)).map(|(_, range)| *range)
    }

    /// The least and the largest position that the fitted records cover, m; both zero without any.
    pub(crate) fn ends(&self) -> [f64; 2] {
        let ends = (self.missing.iter())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (x, _)| [low.min(*x), high.max(*x)]);
        if self.missing.is_empty() { [0.0; 2] } else { ends }
    }

    /// Range of the positions, m.
    pub(crate) fn stroke(&self) -> f64 {
        let [low, high] = self.ends();
        (high - low).max(0.0)
    }
}

/// A machine whose guide is believed to have dry friction of 2 N, and the site of that guide.
#[cfg(test)]
pub(super) fn guide_with_friction() -> (Machine, Site) {
    use feeler_plant::description::GROUND;
    use feeler_plant::effects::CoulombFriction;

    let mut guide = Spring::new(GROUND, "motor", 0.0, 5.0);
    guide.effects.push(EffectUse::of(CoulombFriction { level: 2.0 }));
    let mut machine = Machine::default();
    machine.springs.insert("guide".into(), guide);
    (machine, Site { table: ElementKind::Springs, index: 0 })
}
