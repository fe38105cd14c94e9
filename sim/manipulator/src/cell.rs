//! Description of a whole arm's simulation.

use feeler_arm::{Arm, Chain, Others, Reduction, Target, inverse_kinematics};
use feeler_catalogue::{Bound, Dimension, Field, Keyed, Unit, field, number};
use feeler_engine::Scenario;
use feeler_geometry::Pair;
use nalgebra::Vector3;

use crate::bodies::{self, BodyShapes, numbers};
use crate::error::ManipulatorError;
use crate::joint::JointPart;
use crate::start::{Part, Start};

/// Overlap of a joint with itself by rounding, m.
const TOUCHING: f64 = 1e-9;
/// Largest free path along the normal, as a multiple of the arm's length.
const REACHES: f64 = 2.0;

/// An arm with few joints follows an arc along the normal: its largest lateral deviation over its path.
const ON_AN_ARC: f64 = 0.1;

/// Position control of the tool's other directions.
///
/// With five joints or fewer only the position is held, and with one joint nothing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Natural frequency, Hz; zero without position control.
    pub bandwidth_hz: f64,
    pub damping_ratio: f64,
}

impl Keyed for Hold {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Hold: bandwidth_hz,
            number("bandwidth", Unit::Of(Dimension::FREQUENCY), Bound::NotNegative, 5.0,
                "natural frequency; 0 for no position control")),
        field!(Hold: damping_ratio,
            number("damping_ratio", Unit::Of(Dimension::NONE), Bound::Positive, 1.0, "damping ratio")),
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
    /// Shapes of base and links, the base first.
    pub bodies: Vec<BodyShapes>,
    pub start: Start,
    /// The part that touches the workpiece.
    pub tip: Part,
    /// The workpiece, which does not move.
    pub workpiece: Part,
    /// Position control of the other directions.
    pub hold: Hold,
    /// The axis along the normal. It has one contact, between tip and workpiece, and one controller, which
    /// drives the force along the normal. Its sensors read the contact's force or the displacement of the
    /// driven body: the tool's displacement along the normal, from the joints' encoders.
    pub scenario: Scenario,
    /// Longest step, s; by default from the fastest mode.
    pub step_s: Option<f64>,
}

impl Cell {
    /// How the other directions are held in the reduction to an axis.
    pub fn others(&self) -> Others {
        if self.hold.bandwidth_hz > 0.0 { Others::Held } else { Others::Free }
    }

    /// The axis that represents the arm along the normal at the start.
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

    /// Checks the start. The arm must not collide with itself. The tip must be outside the workpiece and must
    /// be able to reach it along the normal.
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

/// Largest path along the normal, m.
pub(crate) fn farthest_m(chain: &Chain) -> f64 {
    let places = chain.joints.iter().map(|joint| &joint.place).chain([&chain.tool]);
    REACHES * places.map(|place| place.translation.vector.norm()).sum::<f64>()
}
