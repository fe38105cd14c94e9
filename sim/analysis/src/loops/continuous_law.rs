//! Control laws in continuous time, without filters of readings, as they are written on paper.

use std::f64::consts::TAU;

use feeler_control::{AdmittanceGains, ControllerSpec, ForceGains, Law, LeadSpec, PositionGains};
use nalgebra::{DMatrix, RowDVector};

/// Inputs of a [`ContinuousLaw`], in this order.
pub(crate) const READING: usize = 0;
/// Derivative of the reading.
pub(crate) const READING_RATE: usize = 1;
/// Position of the driven body.
pub(crate) const POSITION: usize = 2;
/// Velocity of the driven body.
pub(crate) const VELOCITY: usize = 3;
pub(crate) const INPUTS: usize = 4;

/// `x' = A x + B in`, `u = C x + D in`, `in = [reading, its rate, position, velocity]`, for a reference at
/// rest.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContinuousLaw {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: RowDVector<f64>,
    pub(crate) d: RowDVector<f64>,
}

impl ContinuousLaw {
    pub(crate) fn new(spec: &ControllerSpec) -> Self {
        match &spec.law {
            Law::ExplicitForce(g) => Self::explicit_force(g),
            Law::Position(g) => Self::position(g),
            Law::Impedance(g) => {
                // f_d = -(K x + B v), u = f_d + g (f_d - f).
                let more = 1.0 + g.force_gain;
                Self::memoryless([-g.force_gain, 0.0, -more * g.stiffness, -more * g.damping])
            }
            Law::Admittance(g) => Self::admittance(g),
            Law::OpenLoop => Self::memoryless([0.0; INPUTS]),
        }
    }

    /// Whether the output depends on an input.
    pub(crate) fn uses(&self, input: usize) -> bool {
        self.d[input] != 0.0 || self.b.column(input).amax() > 0.0
    }

    fn memoryless(d: [f64; INPUTS]) -> Self {
        Self {
            a: DMatrix::zeros(0, 0),
            b: DMatrix::zeros(0, INPUTS),
            c: RowDVector::zeros(0),
            d: RowDVector::from_row_slice(&d),
        }
    }

    /// `u = -(kp + ki / s + kd s / (tau s + 1)) reading`.
    fn pid(kp: f64, ki: f64, kd: f64, tau: f64) -> Self {
        let mut law = Self::memoryless([-kp, 0.0, 0.0, 0.0]);
        if ki != 0.0 {
            law = law.with_state([0.0, 1.0, 0.0], -ki);
        }
        if kd != 0.0 && tau > 0.0 {
            // x' = (reading - x) / tau, derivative (reading - x) / tau.
            law = law.with_state([-1.0 / tau, 1.0 / tau, 0.0], kd / tau);
            law.d[READING] -= kd / tau;
        } else {
            law.d[READING_RATE] -= kd;
        }
        law
    }

    /// Adds a state `x' = a x + b reading + c rate` that enters the output with `factor`.
    fn with_state(self, [pole, reading, rate]: [f64; 3], factor: f64) -> Self {
        let n = self.a.nrows();
        let mut a = self.a.resize(n + 1, n + 1, 0.0);
        a[(n, n)] = pole;
        let mut b = self.b.resize(n + 1, INPUTS, 0.0);
        b[(n, READING)] = reading;
        b[(n, READING_RATE)] = rate;
        let mut c = self.c.resize_horizontally(n + 1, 0.0);
        c[n] = factor;
        Self { a, b, c, d: self.d }
    }

    /// The law followed by a lead `(1 + s / w_z) / (1 + s / w_p)`. Its share `r = w_p / w_z` acts at once,
    /// and the rest through a lag.
    fn with_lead(self, lead: &LeadSpec) -> Self {
        let r = lead.pole_hz / lead.zero_hz;
        let w = TAU * lead.pole_hz;
        let n = self.a.nrows();
        let mut a = self.a.resize(n + 1, n + 1, 0.0);
        a.view_mut((n, 0), (1, n)).copy_from(&(&self.c * w));
        a[(n, n)] = -w;
        let mut b = self.b.resize(n + 1, INPUTS, 0.0);
        b.row_mut(n).copy_from(&(&self.d * w));
        let mut c = (self.c * r).resize_horizontally(n + 1, 0.0);
        c[n] = 1.0 - r;
        Self { a, b, c, d: self.d * r }
    }

    fn explicit_force(g: &ForceGains) -> Self {
        let mut law = Self::pid(g.kp, g.ki, g.kd, g.derivative_filter_s);
        if let Some(lead) = &g.lead {
            law = law.with_lead(lead);
        }
        law.d[VELOCITY] -= g.damping;
        law
    }

    fn position(g: &PositionGains) -> Self {
        let mut law = Self::pid(g.kp, g.ki, g.kd, g.derivative_filter_s);
        law.d[READING_RATE] -= g.damping;
        law
    }

    /// `mass a_v + damping v_v + stiffness x_v = -reading`, `u = kp (x_v - x) + kd (v_v - v) + ff v_v`.
    fn admittance(g: &AdmittanceGains) -> Self {
        let with_v = g.kd + g.velocity_feed_forward;
        let mut d = RowDVector::from_row_slice(&[0.0, 0.0, -g.kp, -g.kd]);
        if g.mass > 0.0 {
            let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -g.stiffness / g.mass, -g.damping / g.mass]);
            let mut b = DMatrix::zeros(2, INPUTS);
            b[(1, READING)] = -1.0 / g.mass;
            return Self { a, b, c: RowDVector::from_row_slice(&[g.kp, with_v]), d };
        }
        let mut b = DMatrix::zeros(1, INPUTS);
        b[(0, READING)] = -1.0 / g.damping;
        d[READING] = -with_v / g.damping;
        let a = DMatrix::from_element(1, 1, -g.stiffness / g.damping);
        Self { a, b, c: RowDVector::from_element(1, g.kp - with_v * g.stiffness / g.damping), d }
    }
}
