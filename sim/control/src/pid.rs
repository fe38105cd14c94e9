//! The PID law with its lead compensator and its anti-windup.

use feeler_lanes::{Lane, LaneMask};

use crate::filter::{Section, SectionState};
use crate::law::{AntiWindup, ForceGains, PositionGains};
use crate::listing::Listing;

/// `u = feed_forward r + kp e + i + kd d - damping v`, with `e` the error `r - y` after the lead compensator,
/// and
/// - `i[n] = i[n-1] + ki T e[n]`: the integral includes the error of this sample,
/// - `d[n] = (tau d[n-1] + e[n] - e[n-1]) / (tau + T)`: the backward-Euler form of `s / (tau s + 1)`
///   (Astrom and Wittenmark, "Computer-Controlled Systems", 3rd ed., section 8.5).
///
/// As a system with state `x[n] = i[n-1]` the integral is `x[n+1] = x[n] + ki T e[n]`, `y[n] = x[n] + ki T
/// e[n]`. On a pure stiffness k it closes to `f[n+1] = f[n] + T ki k (r - f[n])`, stable for `T ki k < 2`.
/// This rule is the case of no sample of delay (n = 0) of `T G k < 2 sin(pi / (2 (2 n + 1)))`, and `delay_s =
/// n period_s` gives the case n.
#[derive(Clone, Copy)]
pub(crate) struct PidConfig<L: Lane> {
    feed_forward: L,
    kp: L,
    ki_period: L,
    kd: L,
    damping: L,
    derivative_pole: L,
    derivative_gain: L,
    /// `None` if no lane has a lead.
    lead: Option<Section<L>>,
    /// Lanes whose integrator stops at the limit.
    conditional: L::Mask,
    /// Share of the excess removed per sample, `T / T_t`; zero without back-calculation.
    tracking: L,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct PidState<L> {
    integral: L,
    error: L,
    derivative: L,
    lead: SectionState<L>,
}

impl<L: Lane> PidState<L> {
    pub(crate) fn from_array([integral, error, derivative, s1, s2]: [L; 5]) -> Self {
        Self { integral, error, derivative, lead: SectionState::from_array([s1, s2]) }
    }

    pub(crate) fn to_array(self) -> [L; 5] {
        let [s1, s2] = self.lead.to_array();
        [self.integral, self.error, self.derivative, s1, s2]
    }
}

impl<L: Lane> PidConfig<L> {
    pub(crate) fn new(period_s: f64, gains: impl Fn(usize) -> ForceGains) -> Self {
        let tau = L::from_fn(|i| gains(i).derivative_filter_s);
        let period = L::splat(period_s);
        Self {
            feed_forward: L::from_fn(|i| gains(i).feed_forward),
            kp: L::from_fn(|i| gains(i).kp),
            ki_period: L::from_fn(|i| gains(i).ki * period_s),
            kd: L::from_fn(|i| gains(i).kd),
            damping: L::from_fn(|i| gains(i).damping),
            derivative_pole: tau / (tau + period),
            derivative_gain: L::splat(1.0) / (tau + period),
            lead: Section::of_lanes(|i| {
                gains(i).lead.map(|lead| Section::lead(lead.zero_hz, lead.pole_hz, period_s))
            }),
            conditional: L::Mask::from_fn(|i| gains(i).anti_windup == AntiWindup::Conditional),
            tracking: L::from_fn(|i| match gains(i).anti_windup {
                // Without an integral gain there is no integral to reset.
                AntiWindup::BackCalculation { tracking_time_s } if gains(i).ki != 0.0 => {
                    period_s / tracking_time_s
                }
                _ => 0.0,
            }),
        }
    }

    /// The output before its limit, with `fed` added. Lanes in `fresh` start here: no integral, no
    /// derivative, the lead settled at this error.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the signals of one sample")]
    pub(crate) fn update(
        &self,
        state: &mut PidState<L>,
        r: L,
        y: L,
        v: L,
        fed: L,
        limit: L,
        fresh: L::Mask,
    ) -> L {
        let zero = L::zero();
        let mut e = r - y;
        if let Some(lead) = &self.lead {
            state.lead = SectionState::select(fresh, lead.settled(e), state.lead);
            e = lead.update(&mut state.lead, e);
        }
        let last_error = L::select(fresh, e, state.error);
        let last_integral = L::select(fresh, zero, state.integral);
        let last_derivative = L::select(fresh, zero, state.derivative);

        let d = self.derivative_pole * last_derivative + self.derivative_gain * (e - last_error);
        let rest = self.feed_forward * r + self.kp * e + self.kd * d - self.damping * v + fed;
        let gained = self.ki_period * e;
        let wanted = rest + last_integral + gained;
        let deeper = (wanted.gt(limit) & gained.gt(zero)) | (wanted.lt(-limit) & gained.lt(zero));
        let integral = last_integral + L::select(self.conditional & deeper, zero, gained);
        let u = rest + integral;
        let excess = u - limited(u, limit);

        state.integral = integral - self.tracking * excess;
        state.error = e;
        state.derivative = d;
        u
    }
}

impl PidConfig<f64> {
    /// [`Self::update`] as lines of a program; gives the name of the output before its limit.
    pub(crate) fn list(&self, l: &mut Listing, y: &str, v: &str, is_limited: bool, fresh: &str) -> String {
        for (name, value) in [
            ("FEED_FORWARD", self.feed_forward),
            ("KP", self.kp),
            ("KI_PERIOD", self.ki_period),
            ("KD", self.kd),
            ("DERIVATIVE_POLE", self.derivative_pole),
            ("DERIVATIVE_GAIN", self.derivative_gain),
        ] {
            l.constant(name, value);
        }
        for state in ["integral", "error", "derivative"] {
            l.number_state(state);
        }
        l.number("error", &format!("reference - {y}"));
        let e =
            self.lead.as_ref().map_or_else(|| "error".into(), |lead| lead.list(l, "lead", "error", fresh));
        l.choice("last_error", fresh, &e, "s.error");
        l.choice("last_integral", fresh, "0.0", "s.integral");
        l.choice("last_derivative", fresh, "0.0", "s.derivative");
        let change = format!("DERIVATIVE_GAIN * ({e} - last_error)");
        l.number("derivative", &format!("DERIVATIVE_POLE * last_derivative + {change}"));
        // Without a motion sensor there is no damping either.
        let damped = if v == "0.0" {
            String::new()
        } else {
            l.constant("DAMPING", self.damping);
            format!(" - DAMPING * {v}")
        };
        l.number("rest", &format!("FEED_FORWARD * reference + KP * {e} + KD * derivative{damped}"));
        l.number("gained", &format!("KI_PERIOD * {e}"));
        if is_limited && self.conditional {
            l.number("wanted", "rest + last_integral + gained");
            let deeper = "(wanted > LIMIT && gained > 0.0) || (wanted < -LIMIT && gained < 0.0)";
            l.truth("deeper", deeper);
            l.choice("kept", "deeper", "0.0", "gained");
            l.number("integral", "last_integral + kept");
        } else {
            l.number("integral", "last_integral + gained");
        }
        l.number("u", "rest + integral");
        if is_limited && self.tracking != 0.0 {
            l.constant("TRACKING", self.tracking);
            list_limited(l, "driven", "u");
            l.set("integral", "integral - TRACKING * (u - driven)");
        } else {
            l.set("integral", "integral");
        }
        l.set("error", &e);
        l.set("derivative", "derivative");
        "u".into()
    }
}

/// [`limited`] as lines of a program.
pub(crate) fn list_limited(l: &mut Listing, name: &str, u: &str) {
    let below = format!("{name}_below");
    l.choice(&below, &format!("{u} > LIMIT"), "LIMIT", u);
    l.choice(name, &format!("{below} < -LIMIT"), "-LIMIT", &below);
}

/// `u` within `[-limit, limit]`; NaN if `u` is NaN.
#[inline(always)]
pub(crate) fn limited<L: Lane>(u: L, limit: L) -> L {
    let u = L::select(u.gt(limit), limit, u);
    L::select(u.lt(-limit), -limit, u)
}

impl From<PositionGains> for ForceGains {
    /// The same PID on a position error; terms that the position law does not have are zero.
    fn from(gains: PositionGains) -> Self {
        let PositionGains { kp, ki, kd, damping, derivative_filter_s, anti_windup } = gains;
        Self { feed_forward: 0.0, kp, ki, kd, damping, derivative_filter_s, lead: None, anti_windup }
    }
}
