//! The equations of motion of one mode: forces and derivatives at a state, and its distance from leaving the
//! mode.

use feeler_arm::{Arm, Posture};
use feeler_geometry::Pair;
use feeler_plant::assembly::{ForceLaw, SensorPart, Source};
use feeler_plant::description::Quantity;
use feeler_plant::motion::{ContactState, FrictionState, NonlinearLaw, NonlinearTerm, StopSide, SwitchState};
use nalgebra::{DVector, Vector3};

use crate::bodies::numbers;
use crate::joint::JointPart;
use crate::mode::{CellMode, SwitchChange, index_of};
use crate::state::{CellLayout, filtered};

/// The whole arm and its workpiece.
#[derive(Clone, Debug)]
pub(crate) struct Plant {
    pub(crate) arm: Arm,
    pub(crate) joints: Vec<JointPart>,
    pub(crate) pair: Pair,
    pub(crate) law: ForceLaw,
    /// Additional distance of the surface beyond its shape, m.
    pub(crate) gap_m: f64,
    pub(crate) sensors: Vec<SensorPart>,
    pub(crate) layout: CellLayout,
    /// From the tool into the workpiece.
    pub(crate) normal: Vector3<f64>,
}

/// Relative position of tip and workpiece.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    /// Depth, m, and its rate, m/s; negative when apart.
    pub(crate) depth: f64,
    pub(crate) rate: f64,
    pub(crate) point_m: [f64; 3],
    pub(crate) normal: Vector3<f64>,
    /// Depth per joint motion.
    along: DVector<f64>,
}

/// Forces and torques at a state.
pub(crate) struct Evaluation<'a> {
    pub(crate) posture: Posture<'a>,
    pub(crate) touch: Option<Touch>,
    /// Force of the contact's law, active or not, N.
    law_n: f64,
    /// Force between tip and workpiece and its elastic part, N.
    pub(crate) force_n: f64,
    pub(crate) spring_n: f64,
    /// Torque of each drive, after its lags and with the heat of its winding.
    pub(crate) drive: Vec<f64>,
    gear: Vec<f64>,
    /// Torque on each motor without its dry friction.
    net: Vec<f64>,
}

impl Plant {
    /// Forces at a state; `inputs` are the commands on which the drives act.
    pub(crate) fn evaluate(&self, x: &DVector<f64>, mode: &CellMode, inputs: &[f64]) -> Evaluation<'_> {
        let layout = &self.layout;
        let posture = self.arm.chain().posture(layout.links(x));
        let touch = self.touch(&posture, layout.link_speeds(x));
        let (law_n, elastic) = touch.as_ref().map_or((0.0, 0.0), |touch| self.law_of(touch));
        let (force_n, spring_n) = if mode.touches() { (law_n, elastic) } else { (0.0, 0.0) };
        let n = layout.joints;
        let (motors, motor_speeds) = (layout.motors(x), layout.motor_speeds(x));
        let [mut drive, mut gear, mut net] = [const { Vec::new() }; 3].map(|mut values: Vec<f64>| {
            values.reserve(n);
            values
        });
        for (i, joint) in self.joints.iter().enumerate() {
            let [torque, _] = self.torque(x, i, inputs);
            let between = joint.gear_torque(self.twist(x, i), mode.flanks[i]);
            net.push(
                torque + joint.ripple(motors[i]) + joint.guide.load
                    - joint.guide.damping * motor_speeds[i]
                    - between,
            );
            drive.push(torque);
            gear.push(between);
        }
        Evaluation { posture, touch, law_n, force_n, spring_n, drive, gear, net }
    }

    /// Torque of a drive after its lags, and the rate of its winding's heat.
    fn torque(&self, x: &DVector<f64>, joint: usize, inputs: &[f64]) -> [f64; 2] {
        let (layout, part) = (&self.layout, &self.joints[joint]);
        let lags = part.drive.lags.len();
        let cold = if lags == 0 { inputs[joint] } else { x[layout.lags[joint] + lags - 1] };
        part.warmed(cold, layout.heats[joint].map_or(0.0, |heat| x[heat]))
    }

    /// Depth, normal and Jacobian of the contact; `None` if tip and workpiece are far apart.
    fn touch(&self, posture: &Posture<'_>, speeds: &[f64]) -> Option<Touch> {
        let tool = posture.tool();
        let (position, turn) = numbers(&tool);
        // Shapes without a distance algorithm have been rejected before.
        let nearest = self.pair.nearest(position, turn).ok()??;
        let normal = Vector3::from(nearest.normal);
        let arm = Vector3::from(nearest.point_m) - tool.translation.vector;
        let jacobian = posture.jacobian();
        // The speed of the tip's point along the normal.
        let along =
            jacobian.rows(0, 3).transpose() * normal + jacobian.rows(3, 3).transpose() * arm.cross(&normal);
        let rate = along.iter().zip(speeds).map(|(a, v)| a * v).sum();
        Some(Touch { depth: -nearest.distance_m - self.gap_m, rate, point_m: nearest.point_m, normal, along })
    }

    /// The contact's force and its elastic part when it acts, N.
    fn law_of(&self, touch: &Touch) -> (f64, f64) {
        let law = self.law;
        let whole = NonlinearTerm { law: NonlinearLaw::Contact { contact: 0, law, unilateral: true } };
        let elastic = NonlinearTerm { law: NonlinearLaw::Elastic { contact: 0, law, unilateral: true } };
        (whole.value(touch.depth, touch.rate), elastic.value(touch.depth, touch.rate))
    }

    /// Signal of a sensor before its filters, as a function of the state.
    pub(crate) fn source(&self, sensor: &SensorPart, now: &Evaluation<'_>) -> f64 {
        match sensor.source {
            // A wrist sensor measures the component of the force against the controlled direction.
            Source::Contact(_, Quantity::SpringForce) => now.spring_n * self.cosine(now),
            _ => now.force_n * self.cosine(now),
        }
    }

    fn cosine(&self, now: &Evaluation<'_>) -> f64 {
        now.touch.as_ref().map_or(1.0, |touch| touch.normal.dot(&self.normal))
    }

    /// Derivatives of the state; `None` if the mass matrix is not positive definite.
    pub(crate) fn slope(&self, x: &DVector<f64>, mode: &CellMode, inputs: &[f64]) -> Option<DVector<f64>> {
        let layout = &self.layout;
        let n = layout.joints;
        let now = self.evaluate(x, mode, inputs);
        let mut slope = DVector::zeros(layout.length);
        slope.rows_mut(0, 2 * n).copy_from(&x.rows(2 * n, 2 * n));
        for (i, joint) in self.joints.iter().enumerate() {
            let slides = |sign: f64| (now.net[i] - sign * joint.friction(x[2 * n + i], sign)) / joint.inertia;
            slope[2 * n + i] = match mode.slides[i] {
                Some(FrictionState::Stick) => 0.0,
                Some(FrictionState::Forward) => slides(1.0),
                Some(FrictionState::Backward) => slides(-1.0),
                None => now.net[i] / joint.inertia,
            };
            let mut command = inputs[i];
            for (k, tau) in joint.drive.lags.iter().enumerate() {
                let own = layout.lags[i] + k;
                slope[own] = (command - x[own]) / tau;
                command = x[own];
            }
            if let Some(heat) = layout.heats[i] {
                [_, slope[heat]] = self.torque(x, i, inputs);
            }
        }
        let speeds = layout.link_speeds(x);
        let mut efforts = DVector::from_column_slice(&now.gear) - now.posture.coriolis_efforts(speeds);
        for (i, (position, speed)) in layout.links(x).iter().zip(speeds).enumerate() {
            efforts[i] += self.stop(i, *position, *speed);
        }
        if let Some(touch) = now.touch.as_ref().filter(|_| mode.touches()) {
            efforts.axpy(-now.force_n, &touch.along, 1.0);
        }
        let accelerations = now.posture.mass_matrix().cholesky()?.solve(&efforts);
        slope.rows_mut(3 * n, n).copy_from(&accelerations);
        for (sensor, &first) in self.sensors.iter().zip(&layout.filters) {
            if !sensor.filters.is_empty() && matches!(sensor.source, Source::Contact(..)) {
                let signal = self.source(sensor, &now);
                filtered(&sensor.filters, first, x, signal, Some(&mut slope));
            }
        }
        Some(slope)
    }

    /// Links beyond their position limits: -1 the lower, 1 the upper, 0 none.
    pub(crate) fn beyond(&self, x: &DVector<f64>) -> Vec<i8> {
        let side = |(position, [lower, upper]): (&f64, [f64; 2])| {
            i8::from(*position > upper) - i8::from(*position < lower)
        };
        self.layout
            .links(x)
            .iter()
            .zip(self.arm.chain().joints.iter().map(|joint| joint.limits))
            .map(side)
            .collect()
    }

    /// Torque of the stop at the end of a joint's travel on its link. The stop is a buffer with the stiffness
    /// and damping of the joint's gear, which only pushes back.
    fn stop(&self, joint: usize, position: f64, speed: f64) -> f64 {
        let ([lower, upper], gear) = (self.arm.chain().joints[joint].limits, &self.joints[joint].gear);
        let push = |depth: f64, rate: f64| {
            if depth > 0.0 { (gear.stiffness * depth + gear.damping * rate).max(0.0) } else { 0.0 }
        };
        push(lower - position, -speed) - push(position - upper, speed)
    }

    /// Depth of the contact, m (negative when apart), its rate, m/s, and its acceleration, m/s2, without the
    /// rotation of normal and arm. `None` if the two are far apart.
    pub(crate) fn compression(&self, x: &DVector<f64>, mode: &CellMode, inputs: &[f64]) -> Option<[f64; 3]> {
        let touch = self.evaluate(x, mode, inputs).touch?;
        let n = self.layout.joints;
        let slope = self.slope(x, mode, inputs)?;
        Some([touch.depth, touch.rate, touch.along.dot(&slope.rows(3 * n, n))])
    }

    /// Distances of a state from leaving its mode, one for each possible change, in N, N m or rad/s. They are
    /// zero or positive within the mode.
    pub(crate) fn margins(
        &self,
        x: &DVector<f64>,
        mode: &CellMode,
        now: &Evaluation<'_>,
    ) -> Vec<(SwitchChange, f64)> {
        let mut margins = Vec::with_capacity(1 + 3 * self.layout.joints);
        let contact = self.contact_rules(mode.contact, now);
        margins.extend(contact.into_iter().map(|(left, to)| (SwitchChange::Contact(to), left)));
        for (i, joint) in self.joints.iter().enumerate() {
            let sides = [StopSide::Lower, StopSide::Upper].into_iter().filter(|_| joint.gear.play > 0.0);
            for side in sides {
                let [linear, law] = joint.pressed(self.twist(x, i), side);
                let next = ContactState::after_flank(joint.gear.damping);
                let rules = mode.flanks[i][index_of(side)].guards(&linear, || vec![(law, next)]);
                margins.extend(rules.into_iter().map(|(left, to)| (SwitchChange::Flank(i, side, to), left)));
            }
            if let Some(slide) = mode.slides[i] {
                let rules = slide.guards(&self.layout.motor_speeds(x)[i], || joint.room(now.net[i]));
                margins.extend(rules.into_iter().map(|(left, to)| (SwitchChange::Slide(i, to), left)));
            }
        }
        margins
    }

    fn contact_rules(&self, state: ContactState, now: &Evaluation<'_>) -> Vec<(f64, ContactState)> {
        // Far apart, the distance from touching is that from being measured.
        let Some(touch) = &now.touch else {
            return state.guards(&-1.0, || vec![(-1.0, ContactState::Open)]);
        };
        let depth = self.law.stiffness * touch.depth;
        let factor = || {
            let released = NonlinearTerm { law: NonlinearLaw::Release { contact: 0, law: self.law } };
            if self.law.cubic > 0.0 && self.law.stiffness > 0.0 {
                released.value(touch.depth, touch.rate)
            } else {
                1.0 + self.law.alpha * touch.rate
            }
        };
        state.guards(&depth, || ContactState::while_pushing(&self.law, &depth, || now.law_n, factor))
    }

    /// Twist of a gear (motor before link) and its rate.
    fn twist(&self, x: &DVector<f64>, joint: usize) -> [f64; 2] {
        let layout = &self.layout;
        [
            layout.motors(x)[joint] - layout.links(x)[joint],
            layout.motor_speeds(x)[joint] - layout.link_speeds(x)[joint],
        ]
    }

    /// Applies a change of mode at a state; returns the old and new state of the switch.
    pub(crate) fn change(
        &self,
        change: SwitchChange,
        x: &mut DVector<f64>,
        mode: &mut CellMode,
        net: &[f64],
    ) -> [SwitchState; 2] {
        match change {
            SwitchChange::Contact(to) => {
                [std::mem::replace(&mut mode.contact, to), to].map(SwitchState::from)
            }
            SwitchChange::Flank(i, side, to) => {
                [std::mem::replace(&mut mode.flanks[i][index_of(side)], to), to].map(SwitchState::from)
            }
            SwitchChange::Slide(i, to) => {
                x[2 * self.layout.joints + i] = 0.0;
                let to = to.unwrap_or_else(|| FrictionState::after_rest(self.joints[i].room(net[i])));
                [mode.slides[i].replace(to).unwrap_or_default(), to].map(SwitchState::from)
            }
        }
    }

    /// The mode of an initial state, with all surfaces apart until their margins are evaluated.
    pub(crate) fn first_mode(&self, x: &DVector<f64>, inputs: &[f64]) -> CellMode {
        let n = self.layout.joints;
        let mut mode = CellMode::open(n);
        let net = self.evaluate(x, &mode, inputs).net;
        for (i, joint) in self.joints.iter().enumerate().filter(|(_, joint)| joint.guide.friction.acts()) {
            mode.slides[i] = Some(match FrictionState::at(x[2 * n + i]) {
                FrictionState::Stick => FrictionState::after_rest(joint.room(net[i])),
                slides => slides,
            });
        }
        mode
    }
}

impl Evaluation<'_> {
    pub(crate) fn net(&self) -> &[f64] {
        &self.net
    }
}
