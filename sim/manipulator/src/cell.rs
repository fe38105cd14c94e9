//! What is to be simulated.

use feeler_arm::{Arm, Chain, Others, Reduction, Target, inverse_kinematics};
use feeler_catalogue::{Bound, Dimension, Field, Record, Unit, field, number};
use feeler_engine::Scenario;
use feeler_geometry::{Pair, Place, Shape};
use nalgebra::Vector3;

use crate::bodies::{self, BodyShapes, numbers};
use crate::error::ManipulatorError;
use crate::joint::JointPart;

/// A joint overlaps with itself by rounding, m.
const TOUCHING: f64 = 1e-9;
/// A free way along the normal is followed as far as this many times the arm's length.
const REACHES: f64 = 2.0;

/// An arm of few joints goes along the normal on an arc: so far beside it, over its way, it may get.
const ON_AN_ARC: f64 = 0.1;

/// A shape where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The shape.
    pub shape: Shape,
    /// Where it is: of a tip in the tool's frame, of a workpiece in the base's.
    pub place: Place,
}

/// How the arm begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Joint positions, rad or m; gears relaxed.
    pub pose: Vec<f64>,
    /// From the tool into the workpiece, in the base's frame: the direction in which force is controlled.
    pub normal: [f64; 3],
    /// Speed of the tool along the normal, m/s; nothing bends at first.
    pub speed_m_per_s: f64,
}

/// Position control of the tool's other directions.
///
/// With five joints or fewer only its position is held, and with one nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Natural frequency, Hz; zero for no position control at all.
    pub bandwidth_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

impl Record for Hold {
    const FIELDS: &'static [Field<Self>] = &[
        field!(
            Hold: bandwidth_hz,
            number(
                "bandwidth",
                Unit::Of(Dimension::FREQUENCY),
                Bound::NotNegative,
                5.0,
                "natural frequency; 0 for no position control",
            )
        ),
        field!(
            Hold: damping_ratio,
            number("damping_ratio", Unit::Of(Dimension::NONE), Bound::Positive, 1.0, "damping ratio")
        ),
    ];

    fn blank() -> Option<Self> {
        Some(Self { bandwidth_hz: 5.0, damping_ratio: 1.0 })
    }
}

/// An arm, a tool, a workpiece and a controller.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Links and joints.
    pub arm: Arm,
    /// One per joint, effects applied.
    pub joints: Vec<JointPart>,
    /// The space that base and links take up, the base first.
    pub bodies: Vec<BodyShapes>,
    /// How it begins.
    pub start: Start,
    /// What touches the workpiece.
    pub tip: Part,
    /// What is touched; it stands still.
    pub workpiece: Part,
    /// Position control of the other directions.
    pub hold: Hold,
    /// The axis along the normal: its one contact is that of tip and workpiece, its one controller drives the
    /// force along the normal, and its sensors read the contact's force or the way of the body that the
    /// controller drives: the tool's way along the normal, as the joints' encoders tell it.
    pub scenario: Scenario,
    /// Longest step, s; from the fastest mode where absent.
    pub step_s: Option<f64>,
}

impl Cell {
    /// What holds the other directions when the arm is seen as an axis.
    pub fn others(&self) -> Others {
        if self.hold.bandwidth_hz > 0.0 { Others::Held } else { Others::Free }
    }

    /// The axis that the arm is along the normal at the start.
    ///
    /// # Errors
    /// Those of [`Arm::reduce`].
    pub fn reduction(&self) -> Result<Reduction, ManipulatorError> {
        Ok(self.arm.reduce(&self.start.pose, self.start.normal, self.others())?)
    }

    /// Tip and workpiece.
    pub(crate) fn pair(&self) -> Result<Pair, ManipulatorError> {
        Ok(Pair::new(&self.tip.shape, &self.tip.place, &self.workpiece.shape, &self.workpiece.place)?)
    }

    /// The normal, of length one.
    pub(crate) fn unit_normal(&self) -> Vector3<f64> {
        Vector3::from(self.start.normal).normalize()
    }

    /// Checks that the arm does not run into itself at the start, that the tip does not stand in the
    /// workpiece, and that it can reach it along the normal.
    ///
    /// # Errors
    /// [`ManipulatorError::SelfIntersects`], [`ManipulatorError::Penetrates`],
    /// [`ManipulatorError::NeverMeets`], [`ManipulatorError::OutOfReach`].
    pub fn check_start(&self) -> Result<(), ManipulatorError> {
        let chain = self.arm.chain();
        chain.check_pose(&self.start.pose)?;
        if let Some((a, b, depth_m)) = bodies::overlap(chain, &self.bodies, &self.start.pose)? {
            return Err(ManipulatorError::SelfIntersects { a, b, depth_m });
        }
        let pair = self.pair()?;
        let tool = chain.tool_place(&self.start.pose);
        let (position, turn) = numbers(&tool);
        let gap_m = self.scenario.machine.contacts.values().next().map_or(0.0, |contact| contact.gap_m);
        let nearest = pair.nearest(position, turn)?;
        if let Some(nearest) = nearest.filter(|nearest| nearest.distance_m + gap_m < -TOUCHING) {
            return Err(ManipulatorError::Penetrates { depth_m: -nearest.distance_m - gap_m });
        }
        if let Some(depth_m) = pair.buried_m(position, turn) {
            return Err(ManipulatorError::Penetrates { depth_m });
        }
        let normal = self.unit_normal();
        let reach_m = farthest_m(chain);
        let touching = nearest.is_some_and(|nearest| {
            nearest.distance_m.abs() <= TOUCHING && Vector3::from(nearest.normal).dot(&normal) > 0.0
        });
        let travel_m = match pair.travel_m(position, turn, normal.into(), reach_m)? {
            _ if touching => 0.0,
            Some(travel_m) => travel_m,
            None => return Err(ManipulatorError::NeverMeets),
        };
        let place = tool.translation.vector + normal * travel_m;
        let target = Target::Position(place);
        match inverse_kinematics(chain, &target, std::slice::from_ref(&self.start.pose)) {
            Ok(_) => Ok(()),
            Err(feeler_arm::ArmError::Unreachable { left_m, .. }) if left_m <= ON_AN_ARC * travel_m => Ok(()),
            Err(feeler_arm::ArmError::Unreachable { left_m, .. }) => {
                Err(ManipulatorError::OutOfReach { travel_m, place_m: place.into(), left_m })
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// How far a way along the normal is followed, m.
pub(crate) fn farthest_m(chain: &Chain) -> f64 {
    let places = chain.joints.iter().map(|joint| &joint.place).chain([&chain.tool]);
    REACHES * places.map(|place| place.translation.vector.norm()).sum::<f64>()
}
