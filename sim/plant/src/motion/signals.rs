//! Signals of the plant as rows, and the filters of sensors.

use std::f64::consts::TAU;

use super::layout::{add, difference, scaled};
use super::{Equations, Mode, Motion, Row};
use crate::assembly::{GROUND_NODE, NodeId, SensorPart, Source};
use crate::description::{LowPass, Quantity};

impl Motion {
    /// Names of the states, in the order of [`super::Layout`]. Positions and velocities come first, as
    /// signals are named. Then come `<spring>.bristle`, `<drive>.ramp`, `<drive>.lag1`, `<drive>.force`,
    /// `<drive>.heat`, `<sensor>.filter1` and so on, and the four states of a moving gap. A second-order
    /// filter has its output, and the rate of the output over its angular corner frequency.
    pub fn state_names(&self) -> Vec<String> {
        let mut names = vec![String::new(); self.layout.states()];
        for g in 0..self.coordinates.count() {
            let lead = &self.assembly.nodes[self.coordinates.lead(g)].name;
            names[self.layout.q(g)] = format!("{lead}.position");
            names[self.layout.v(g)] = format!("{lead}.velocity");
        }
        for (drive, states) in self.assembly.drives.iter().zip(&self.layout.drives) {
            let mut name = |state: usize, what: &str| names[state] = format!("{}.{what}", drive.name);
            states.ramp.into_iter().for_each(|state| name(state, "ramp"));
            states.pace.into_iter().for_each(|state| name(state, "ramp_rate"));
            states.lags.iter().enumerate().for_each(|(i, state)| name(*state, &format!("lag{}", i + 1)));
            states.force.into_iter().for_each(|state| name(state, "force"));
            states.integral.into_iter().for_each(|state| name(state, "integral"));
            states.heat.into_iter().for_each(|state| name(state, "heat"));
            if let Some(first) = states.imposed {
                name(first, "acceleration");
                name(first + 1, "jerk");
            }
        }
        for (sensor, firsts) in self.assembly.sensors.iter().zip(&self.layout.filters) {
            for (i, (filter, &first)) in sensor.filters.iter().zip(firsts).enumerate() {
                names[first] = format!("{}.filter{}", sensor.name, i + 1);
                if let LowPass::SecondOrder { .. } = filter {
                    names[first + 1] = format!("{}.filter{}_rate", sensor.name, i + 1);
                }
            }
        }
        for (i, contact) in self.assembly.contacts.iter().enumerate() {
            let Some(first) = self.layout.moving_gap(i) else { continue };
            for (k, what) in ["gap_offset", "gap_rate", "gap_curvature", "gap_jerk"].into_iter().enumerate() {
                names[first + k] = format!("{}.{what}", contact.name);
            }
        }
        for (i, link) in self.assembly.links.iter().enumerate() {
            self.layout
                .bristle(i)
                .into_iter()
                .for_each(|state| names[state] = format!("{}.bristle", link.name));
        }
        names
    }

    /// A signal of the plant as a row of the extended vector. `None` for signals without a row: whether and
    /// where a contact touches, and the command of a drive before delay and limits. A sensor's row ends with
    /// its filters; gain, bias, noise and quantisation follow later.
    pub fn signal(&self, equations: &Equations, source: Source) -> Option<Row> {
        Some(match source {
            Source::Node(node, Quantity::Acceleration) => self.acceleration(&equations.derivative, node),
            Source::Node(node, quantity) => self.motion_row(node, quantity),
            Source::Contact(i, Quantity::Force) => equations.contact_force[i].clone(),
            Source::Contact(i, Quantity::SpringForce) => equations.contact_spring_force[i].clone(),
            Source::Contact(i, Quantity::Compression) => equations.compression[i][0].clone(),
            Source::Contact(i, Quantity::Gap) => scaled(-1.0, &equations.compression[i][0]),
            Source::Contact(i, Quantity::GapRate) => scaled(-1.0, &equations.compression[i][1]),
            Source::Link(i, Quantity::Force) => self.borne_force(equations, i),
            Source::Link(i, Quantity::SpringForce) => equations.link_spring_force[i].clone(),
            Source::Drive(i, Quantity::Force) => equations.drive_force[i].clone(),
            Source::Drive(i, quantity) => self.of_drive(i, quantity, equations.mode, &equations.stroke[i])?,
            Source::Sensor(i) => {
                let sensor = &self.assembly.sensors[i];
                match self.layout.filters[i].last() {
                    Some(&state) => self.layout.unit(state),
                    None => self.unfiltered(sensor, equations)?,
                }
            }
            _ => return None,
        })
    }

    /// Force of a link, with the friction that its bristles carry.
    fn borne_force(&self, equations: &Equations, i: usize) -> Row {
        let mut force = equations.link_force[i].clone();
        for (link, own) in self.assembly.links.iter().zip(&equations.link_force) {
            if link.bears == Some(i) {
                add(&mut force, 1.0, own);
            }
        }
        force
    }

    /// Sets the filters of all sensors to rest at the signals of a state `xi`, so that a run starts without
    /// their transient.
    pub fn settle_filters(&self, equations: &Equations, xi: &mut [f64]) {
        for (i, sensor) in self.assembly.sensors.iter().enumerate() {
            let Some(row) = self.unfiltered(sensor, equations) else { continue };
            let value = row.iter().zip(xi.iter()).map(|(r, x)| r * x).sum();
            for &state in &self.layout.filters[i] {
                xi[state] = value;
            }
        }
    }

    /// Signals of a drive besides its force: its stroke, and the current of a motor.
    fn of_drive(&self, i: usize, quantity: Quantity, mode: Mode, stroke: &[Row; 2]) -> Option<Row> {
        match quantity {
            Quantity::Position => Some(stroke[0].clone()),
            Quantity::Velocity => Some(stroke[1].clone()),
            Quantity::Current => {
                let motor = self.assembly.drives[i].motor?;
                Some(scaled(1.0 / motor.force_per_current, &self.path(i, mode, stroke).given))
            }
            _ => None,
        }
    }

    fn motion_row(&self, node: NodeId, quantity: Quantity) -> Row {
        if quantity == Quantity::Position {
            self.layout.position(&self.assembly, &self.coordinates, node)
        } else {
            self.layout.velocity(&self.coordinates, node)
        }
    }

    fn acceleration(&self, derivative: &[Row], node: NodeId) -> Row {
        self.coordinates.of(node).map_or_else(|| self.layout.zero(), |g| derivative[self.layout.v(g)].clone())
    }

    /// Input of the filters of a sensor.
    fn unfiltered(&self, sensor: &SensorPart, equations: &Equations) -> Option<Row> {
        let mut row = self.signal(equations, sensor.source)?;
        if let Source::Node(_, quantity) = sensor.source
            && sensor.relative_to != GROUND_NODE
        {
            row = difference(&row, &self.signal(equations, Source::Node(sensor.relative_to, quantity))?);
        }
        let (mass, node) = sensor.tool_inertia;
        if mass != 0.0 {
            add(&mut row, mass, &self.acceleration(&equations.derivative, node));
        }
        Some(row)
    }

    /// Writes the derivatives of the filters' states, which follow from all other rows.
    pub(super) fn filter_derivatives(&self, equations: &mut Equations) {
        for (i, sensor) in self.assembly.sensors.iter().enumerate() {
            if sensor.filters.is_empty() {
                continue;
            }
            let Some(mut input) = self.unfiltered(sensor, equations) else { continue };
            for (filter, &first) in sensor.filters.iter().zip(&self.layout.filters[i]) {
                input = self.filter(filter, first, &input, &mut equations.derivative);
            }
        }
    }

    /// Writes the derivatives of one filter and returns its output.
    fn filter(&self, filter: &LowPass, first: usize, input: &Row, derivative: &mut [Row]) -> Row {
        match *filter {
            LowPass::FirstOrder { corner_hz } => {
                let mut row = input.clone();
                row[first] -= 1.0;
                row = scaled(TAU * corner_hz, &row);
                derivative[first] = row;
            }
            LowPass::SecondOrder { corner_hz, damping_ratio } => {
                // States: the output, and its rate over omega, so that both have the size of the signal.
                let omega = TAU * corner_hz;
                let rate = first + 1;
                derivative[first] = self.layout.unit(rate);
                derivative[first][rate] = omega;
                let mut row = input.clone();
                row[first] -= 1.0;
                row[rate] -= 2.0 * damping_ratio;
                row = scaled(omega, &row);
                derivative[rate] = row;
            }
        }
        self.layout.unit(first)
    }
}
