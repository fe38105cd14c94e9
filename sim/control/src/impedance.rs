//! The impedance law.

use feeler_lanes::Lane;

use crate::law::ImpedanceGains;
use crate::listing::Listing;

/// `f_d[n] = K (x_r[n] - x[n]) + D ((x_r[n] - x_r[n-1]) / T - v[n])`, `u[n] = f_d[n] + g (f_d[n] - f[n])`.
#[derive(Clone, Copy)]
pub(crate) struct ImpedanceConfig<L> {
    stiffness: L,
    damping: L,
    force_gain: L,
    period: L,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct ImpedanceState<L> {
    reference: L,
}

impl<L: Lane> ImpedanceState<L> {
    pub(crate) fn from_array([reference]: [L; 1]) -> Self {
        Self { reference }
    }

    pub(crate) fn to_array(self) -> [L; 1] {
        [self.reference]
    }
}

impl<L: Lane> ImpedanceConfig<L> {
    pub(crate) fn new(period_s: f64, gains: impl Fn(usize) -> ImpedanceGains) -> Self {
        Self {
            stiffness: L::from_fn(|i| gains(i).stiffness),
            damping: L::from_fn(|i| gains(i).damping),
            force_gain: L::from_fn(|i| gains(i).force_gain),
            period: L::splat(period_s),
        }
    }

    /// The output before its limit; at the first sample of lanes in `fresh` the reference counts as constant.
    #[inline(always)]
    pub(crate) fn update(
        &self,
        state: &mut ImpedanceState<L>,
        x_r: L,
        f: L,
        x: L,
        v: L,
        fresh: L::Mask,
    ) -> L {
        let last = L::select(fresh, x_r, state.reference);
        let v_r = (x_r - last) / self.period;
        state.reference = x_r;
        let f_d = self.stiffness * (x_r - x) + self.damping * (v_r - v);
        f_d + self.force_gain * (f_d - f)
    }
}

impl ImpedanceConfig<f64> {
    /// [`Self::update`] as lines of a program; gives the name of the output.
    pub(crate) fn list(&self, l: &mut Listing, f: &str, x: &str, v: &str, fresh: &str) -> String {
        for (name, value) in [
            ("STIFFNESS", self.stiffness),
            ("DAMPING", self.damping),
            ("FORCE_GAIN", self.force_gain),
            ("PERIOD", self.period),
        ] {
            l.constant(name, value);
        }
        l.number_state("reference");
        l.choice("last_reference", fresh, "reference", "s.reference");
        l.number("reference_rate", "(reference - last_reference) / PERIOD");
        l.set("reference", "reference");
        let force = format!("STIFFNESS * (reference - {x}) + DAMPING * (reference_rate - {v})");
        l.number("force", &force);
        l.number("u", &format!("force + FORCE_GAIN * (force - {f})"));
        "u".into()
    }
}
