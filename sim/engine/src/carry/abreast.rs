//! The largest forces of lanes that travel together, from the ends of their spans.

use feeler_lanes::Lane;

use crate::carry::peaks::{PEAK_TOLERANCE, Peak, Peaks, ROUGH_PEAK_TOLERANCE, room};

/// The present stretch of one contact in all lanes, for spans that lanes travel together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Abreast<L> {
    force_n: L,
    t_s: L,
}

impl<L: Lane> Abreast<L> {
    pub(crate) fn new() -> Self {
        Self { force_n: L::zero(), t_s: L::zero() }
    }

    /// Passes the peaks found in group travel to a lane that goes alone.
    pub(crate) fn give(&self, peaks: &mut Peaks, i: usize, l: usize) {
        if let Some(present) = &mut peaks.present[i] {
            *present = self.peak(l);
        }
    }

    pub(crate) fn peak(&self, l: usize) -> Peak {
        Peak { t_s: self.t_s.lane(l), force_n: self.force_n.lane(l) }
    }

    /// Takes over the peaks that a lane has found alone.
    pub(crate) fn take(&mut self, peaks: &Peaks, i: usize, l: usize) {
        let present = peaks.present[i].unwrap_or_default();
        self.force_n.set_lane(l, present.force_n);
        self.t_s.set_lane(l, present.t_s);
    }

    /// Records that a lane's force has reached this value.
    pub(crate) fn rise_to(&mut self, l: usize, t_s: f64, force_n: f64) {
        if force_n > self.force_n.lane(l) {
            self.force_n.set_lane(l, force_n);
            self.t_s.set_lane(l, t_s);
        }
    }

    /// The lanes of `pushing` have moved by `h` from `from_s` (s), with these forces and slopes at start and
    /// end. Returns the lanes whose force may have exceeded the maximum in between.
    #[inline(always)]
    pub(crate) fn pass(
        &mut self,
        pushing: L::Mask,
        [start, end]: [L; 2],
        [rise, fall]: [L; 2],
        from_s: L,
        h: L,
    ) -> L::Mask {
        let zero = L::zero();
        for (force_n, t_s) in [(start, from_s), (end, from_s + h)] {
            let higher = pushing & force_n.gt(self.force_n);
            self.force_n = L::select(higher, force_n, self.force_n);
            self.t_s = L::select(higher, t_s, self.t_s);
        }
        let level = self.force_n * L::splat(1.0 + PEAK_TOLERANCE);
        let peaks = rise.gt(zero) & fall.lt(zero) & room([start, end], [rise, fall], h, level).gt(zero);
        // The values at the ends may show a maximum or minimum in between, even if tangents do not bound it.
        // The cubic through both ends exceeds the higher one by at most 4/27 of the slopes over the span; the
        // bound leaves seven times as much.
        let turns =
            (rise.gt(zero) & fall.ge(zero) & end.lt(start)) | (rise.le(zero) & fall.lt(zero) & start.lt(end));
        let bound = start.max(end) + h * (rise.abs() + fall.abs()) + (end - start).abs();
        pushing & (peaks | (turns & bound.gt(level)))
    }

    /// Lanes whose force may have exceeded the maximum within a span of more than one oscillation. The bound
    /// is the higher end plus the steeper slope over the whole span.
    #[inline(always)]
    pub(crate) fn is_near(&self, [start, end]: [L; 2], [rise, fall]: [L; 2], h: L) -> L::Mask {
        (start.max(end) + h * rise.abs().max(fall.abs()))
            .gt(self.force_n * L::splat(1.0 + ROUGH_PEAK_TOLERANCE))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two oscillations that turn by 1.2 and 0.36 rad over a span, in many phases. A span that is not
    /// examined stays below the maximum.
    #[test]
    fn truth_no_peak_above_the_maximum_is_passed() {
        let h = 1e-3;
        let (fast, slow) = (1.2 / h, 0.36 / h);
        let mut passed = 0;
        for case in 0..400 {
            for share in [0.0, 0.2, 1.0, 5.0] {
                let phases = [0.37, 0.11].map(|turn| turn * f64::from(case));
                let force =
                    |t: f64| 20.0 + (fast * t + phases[0]).sin() + share * (slow * t + phases[1]).sin();
                let slope = |t: f64| {
                    fast * (fast * t + phases[0]).cos() + share * slow * (slow * t + phases[1]).cos()
                };
                let highest = (0..=1000).map(|k| force(h * f64::from(k) * 1e-3)).fold(0.0, f64::max);
                let (ends, slopes) = ([force(0.0), force(h)], [slope(0.0), slope(h)]);
                for above in [0.0, 0.01, 0.1, 1.0] {
                    let mut present = Abreast { force_n: highest - above, t_s: 0.0 };
                    let is_examined = present.pass(true, ends, slopes, 0.0, h);
                    assert!(is_examined || present.force_n >= highest - 1e-6, "{case} {share} {above}");
                    passed += usize::from(!is_examined);
                }
            }
        }
        // A force at rest whose rounding looks like a turn.
        let mut rest = Abreast { force_n: 20.0, t_s: 0.0 };
        assert!(!rest.pass(true, [20.0, 20.0_f64.next_down()], [1e-15, 0.0], 0.0, h));
        assert!(passed > 1000, "{passed}");
    }
}
