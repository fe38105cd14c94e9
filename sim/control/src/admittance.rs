//! The admittance law.

use feeler_lanes::Lane;

use crate::law::AdmittanceGains;
use crate::listing::Listing;

/// The virtual body `M a + B v + K x = e`, with `e = r - f` held over a period, and the inner loop that
/// follows it.
///
/// The body is discretised exactly: with `s = [x, v]`, `s[n+1] = A s[n] + b e[n]`, where `A = exp(F T)` and
/// `b` is the integral of `exp(F t) g` over one period (`F`, `g` the continuous system). The target of the
/// inner loop is `s[n+1]`, the state at the end of the interval over which its command is held. The integral
/// of the PID law includes the error of its own sample in the same way. A pure virtual damper is then an
/// integral force loop without delay.
#[derive(Clone, Copy)]
pub(crate) struct AdmittanceConfig<L> {
    a: [[L; 2]; 2],
    b: [L; 2],
    kp: L,
    kd: L,
    velocity_feed_forward: L,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct AdmittanceState<L> {
    /// Position at which the law started.
    origin: L,
    position: L,
    velocity: L,
}

impl<L: Lane> AdmittanceState<L> {
    /// A virtual body whose law started at position zero.
    pub(crate) fn from_array([position, velocity]: [L; 2]) -> Self {
        Self { origin: L::zero(), position, velocity }
    }

    pub(crate) fn to_array(self) -> [L; 2] {
        [self.position, self.velocity]
    }
}

impl<L: Lane> AdmittanceConfig<L> {
    pub(crate) fn new(period_s: f64, gains: impl Fn(usize) -> AdmittanceGains) -> Self {
        let body = |i| virtual_body(&gains(i), period_s);
        Self {
            a: std::array::from_fn(|r| std::array::from_fn(|c| L::from_fn(|i| body(i).0[r][c]))),
            b: std::array::from_fn(|r| L::from_fn(|i| body(i).1[r])),
            kp: L::from_fn(|i| gains(i).kp),
            kd: L::from_fn(|i| gains(i).kd),
            velocity_feed_forward: L::from_fn(|i| gains(i).velocity_feed_forward),
        }
    }

    /// The output before its limit; the virtual body of lanes in `fresh` starts at rest at the axis position.
    #[inline(always)]
    pub(crate) fn update(&self, state: &mut AdmittanceState<L>, r: L, f: L, x: L, v: L, fresh: L::Mask) -> L {
        let zero = L::zero();
        let e = r - f;
        let origin = L::select(fresh, x, state.origin);
        let (x0, v0) = (L::select(fresh, zero, state.position), L::select(fresh, zero, state.velocity));
        let x_v = self.a[0][0] * x0 + self.a[0][1] * v0 + self.b[0] * e;
        let v_v = self.a[1][0] * x0 + self.a[1][1] * v0 + self.b[1] * e;
        *state = AdmittanceState { origin, position: x_v, velocity: v_v };
        self.kp * (origin + x_v - x) + self.kd * (v_v - v) + self.velocity_feed_forward * v_v
    }
}

impl AdmittanceConfig<f64> {
    /// [`Self::update`] as lines of a program; gives the name of the output.
    pub(crate) fn list(&self, l: &mut Listing, f: &str, x: &str, v: &str, fresh: &str) -> String {
        for (name, value) in [
            ("A_XX", self.a[0][0]),
            ("A_XV", self.a[0][1]),
            ("B_X", self.b[0]),
            ("A_VX", self.a[1][0]),
            ("A_VV", self.a[1][1]),
            ("B_V", self.b[1]),
            ("KP", self.kp),
            ("KD", self.kd),
            ("VELOCITY_FEED_FORWARD", self.velocity_feed_forward),
        ] {
            l.constant(name, value);
        }
        for state in ["law_origin", "law_position", "law_velocity"] {
            l.number_state(state);
        }
        l.number("error", &format!("reference - {f}"));
        l.choice("law_origin", fresh, x, "s.law_origin");
        l.choice("last_position", fresh, "0.0", "s.law_position");
        l.choice("last_velocity", fresh, "0.0", "s.law_velocity");
        l.number("law_position", "A_XX * last_position + A_XV * last_velocity + B_X * error");
        l.number("law_velocity", "A_VX * last_position + A_VV * last_velocity + B_V * error");
        for state in ["law_origin", "law_position", "law_velocity"] {
            l.set(state, state);
        }
        let follows = format!("KP * (law_origin + law_position - {x}) + KD * (law_velocity - {v})");
        l.number("u", &format!("{follows} + VELOCITY_FEED_FORWARD * law_velocity"));
        "u".into()
    }
}

/// `A` and `b` of the virtual body for a period `T`.
fn virtual_body(gains: &AdmittanceGains, period_s: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    let (m, b, k, t) = (gains.mass, gains.damping, gains.stiffness, period_s);
    if m > 0.0 {
        return second_order_step(k / m, b / m, 1.0 / m, t);
    }
    // Without mass the body is first order: B v = e - K x, and its velocity follows from its next position.
    let decay = (-k / b * t).exp();
    let gain = if k > 0.0 { -(-k / b * t).exp_m1() / k } else { t / b };
    ([[decay, 0.0], [-k * decay / b, 0.0]], [gain, (1.0 - k * gain) / b])
}

/// The exact step of `x'' + c x' + w2 x = g e` over `t`, by scaling and squaring of the exponential's Taylor
/// series. Source: Moler and Van Loan, "Nineteen dubious ways to compute the exponential of a matrix", SIAM
/// Review 2003, method 3.
fn second_order_step(w2: f64, c: f64, g: f64, t: f64) -> ([[f64; 2]; 2], [f64; 2]) {
    type Matrix = [[f64; 3]; 3];
    fn product(p: &Matrix, q: &Matrix) -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| p[i][k] * q[k][j]).sum()))
    }
    // The held input is a constant third state. Time is scaled so that both rates are of order one in the
    // series.
    let norm = t * (w2.sqrt() + c) + t;
    let halvings = norm.max(f64::MIN_POSITIVE).log2().ceil().max(0.0) as i32 + 4;
    let h = t / 2_f64.powi(halvings);
    let f: Matrix = [[0.0, h, 0.0], [-w2 * h, -c * h, g * h], [0.0, 0.0, 0.0]];
    let identity: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut exponential = identity;
    for order in (1..=TAYLOR_ORDER).rev() {
        // Horner: I + (F / order) (...).
        let scaled = f.map(|row| row.map(|x| x / f64::from(order)));
        exponential = product(&scaled, &exponential);
        for (row, one) in exponential.iter_mut().zip(&identity) {
            row.iter_mut().zip(one).for_each(|(x, one)| *x += one);
        }
    }
    for _ in 0..halvings {
        exponential = product(&exponential, &exponential);
    }
    let [x, v, _] = exponential;
    ([[x[0], x[1]], [v[0], v[1]]], [x[2], v[2]])
}

/// With rates of at most 1/16 per step the first omitted term is below 16^-13 / 13!, far below rounding.
const TAYLOR_ORDER: u32 = 12;
