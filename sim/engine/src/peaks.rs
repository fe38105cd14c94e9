//! The largest force of every stretch of contact, between the rows of any record: where a force crests within a span is found on the motion itself.

use feeler_lanes::Lane;
use feeler_plant::motion::{Motion, dot};

use crate::crossing::Look;
use crate::extrapolation::Extrapolation;
use crate::flow::Flow;
use crate::taylor::Series;

/// Share of itself by which a crest may be higher than what is known without being looked at: slopes taken by differences tell no more, and a force at rest
/// is not to be looked at for its rounding.
const CREST: f64 = 1e-9;
/// The same in spans in which the force may swing more than once, so that a force which creeps to its largest value is not looked at all the way.
const NEAR: f64 = 1e-6;
/// Looks at a crest of a nonlinear mode; each brings the bounds several times closer.
const MOST_LOOKS: usize = 60;

/// The largest force of one stretch of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// When, s.
    pub t_s: f64,
    /// How large, N; 0 where the contact only pulled.
    pub force_n: f64,
}

impl Peak {
    fn at(t_s: f64, force_n: f64) -> Self {
        Self { t_s, force_n: if force_n > 0.0 { force_n } else { 0.0 } }
    }

    fn rise_to(&mut self, other: Self) {
        if other.force_n > self.force_n {
            *self = other;
        }
    }
}

/// A force at an instant.
#[derive(Clone, Copy)]
struct Point {
    s: f64,
    force_n: f64,
    slope: f64,
}

/// Where tangents at both ends of a span of `h` meet, above `level` or not: what lies between them if it bends one way only. Positive where above.
#[inline(always)]
fn room<L: Lane>([start, end]: [L; 2], [rise, fall]: [L; 2], h: L, level: L) -> L {
    (start - level) * (rise - fall) + rise * (end - start - fall * h)
}

/// Of one variant: a list per contact, and the stretch that lasts.
#[derive(Debug)]
pub(crate) struct Peaks {
    finished: Vec<Vec<Peak>>,
    present: Vec<Option<Peak>>,
}

impl Peaks {
    pub(crate) fn new(contacts: usize) -> Self {
        Self { finished: vec![Vec::new(); contacts], present: vec![None; contacts] }
    }

    /// The machine is in the mode of `flow` from now on, or is still at the end of a fixed step: stretches begin, rise and end.
    pub(crate) fn enter(&mut self, flow: &Flow, xi: &[f64], t_s: f64) {
        for (i, present) in self.present.iter_mut().enumerate() {
            if flow.pushing[i] {
                let peak = Peak::at(t_s, dot(&flow.equations.contact_force[i], xi));
                present.get_or_insert(peak).rise_to(peak);
            } else {
                self.finished[i].extend(present.take());
            }
        }
    }

    /// Every stretch of contact `i` so far. Of the one that lasts the peak is `abreast`, where the lane travels in company.
    pub(crate) fn of(&self, i: usize, abreast: Option<Peak>) -> Vec<Peak> {
        let present = self.present[i].map(|own| abreast.unwrap_or(own));
        self.finished[i].iter().copied().chain(present).collect()
    }

    /// A leg of `h` of a linear mode, from `xi` at `t_s` on.
    pub(crate) fn linear_leg(&mut self, flow: &Flow, series: &Series, xi: &[f64], t_s: f64, h: f64) {
        for (i, present) in self.present.iter_mut().enumerate() {
            if let Some(present) = present {
                let force = series.functional(&flow.equations.contact_force[i], xi, flow.width);
                let (s, force_n) = force.largest(h);
                present.rise_to(Peak::at(t_s + s, force_n));
            }
        }
    }

    /// A leg of `h` of a nonlinear mode, from `start` at `t_s` to `end`; terms are filled in at both.
    pub(crate) fn nonlinear_leg(
        &mut self,
        motion: &Motion,
        flow: &Flow,
        method: &mut Extrapolation,
        [start, end]: [&[f64]; 2],
        t_s: f64,
        h: f64,
    ) {
        for (i, present) in self.present.iter_mut().enumerate() {
            if let Some(present) = present {
                let look = Look { motion, flow, start, row: &flow.equations.contact_force[i] };
                let point = |s: f64, xi: &[f64]| Point { s, force_n: dot(look.row, xi), slope: look.slope(xi, h) };
                let ends = [point(0.0, start), point(h, end)];
                for point in ends {
                    present.rise_to(Peak::at(t_s + point.s, point.force_n));
                }
                crest(&look, method, ends, h, t_s, present);
            }
        }
    }

    /// A span of a linear mode that was travelled in one go crests in it: looks where, from `xi` at its start on. `xi` is moved.
    pub(crate) fn crest(&mut self, flow: &Flow, series: &mut Series, xi: &mut [f64], t_s: f64, span_s: f64) {
        let mut gone_s = 0.0;
        while gone_s < span_s {
            let h = flow.horizon_s.min(span_s - gone_s);
            series.expand(flow, xi, h);
            self.linear_leg(flow, series, xi, t_s + gone_s, h);
            series.evaluate(h, xi);
            gone_s += h;
        }
    }
}

/// Where the force rises at one end of a leg and falls at the other, the crest in between: by the secant of the slope, until the tangents leave no room.
fn crest(look: &Look, method: &mut Extrapolation, [mut a, mut b]: [Point; 2], h: f64, t_s: f64, present: &mut Peak) {
    for _ in 0..MOST_LOOKS {
        let level = present.force_n * (1.0 + CREST);
        if a.slope <= 0.0 || b.slope >= 0.0 || room([a.force_n, b.force_n], [a.slope, b.slope], b.s - a.s, level) <= 0.0 {
            return;
        }
        // Kept off the ends, so that both come closer.
        let share = (a.slope / (a.slope - b.slope)).clamp(0.05, 0.95);
        let s = a.s + share * (b.s - a.s);
        let Some(xi) = look.at(method, s) else { return };
        let middle = Point { s, force_n: dot(look.row, &xi), slope: look.slope(&xi, h) };
        present.rise_to(Peak::at(t_s + s, middle.force_n));
        if middle.slope > 0.0 { a = middle } else { b = middle }
    }
}

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

    /// Gives a lane that goes alone from here on what was found in company.
    pub(crate) fn give(&self, peaks: &mut Peaks, i: usize, l: usize) {
        if let Some(present) = &mut peaks.present[i] {
            *present = self.peak(l);
        }
    }

    pub(crate) fn peak(&self, l: usize) -> Peak {
        Peak { t_s: self.t_s.lane(l), force_n: self.force_n.lane(l) }
    }

    /// Takes over what a lane has found alone.
    pub(crate) fn take(&mut self, peaks: &Peaks, i: usize, l: usize) {
        let present = peaks.present[i].unwrap_or_default();
        self.force_n.set_lane(l, present.force_n);
        self.t_s.set_lane(l, present.t_s);
    }

    /// The lanes of `pushing` have gone from `from_s` on by `h` (s), with these forces at start and end and these slopes: gives those whose force may have been
    /// larger in between than anything yet.
    #[inline(always)]
    pub(crate) fn pass(&mut self, pushing: L::Mask, [start, end]: [L; 2], [rise, fall]: [L; 2], from_s: L, h: L) -> L::Mask {
        let zero = L::zero();
        for (force_n, t_s) in [(start, from_s), (end, from_s + h)] {
            let higher = pushing & force_n.gt(self.force_n);
            self.force_n = L::select(higher, force_n, self.force_n);
            self.t_s = L::select(higher, t_s, self.t_s);
        }
        let crests = rise.gt(zero) & fall.lt(zero) & room([start, end], [rise, fall], h, self.force_n * L::splat(1.0 + CREST)).gt(zero);
        // Ends that tell of a turn at least, though tangents do not bound it.
        let turns = (rise.gt(zero) & fall.ge(zero) & end.lt(start)) | (rise.le(zero) & fall.lt(zero) & start.lt(end));
        pushing & (crests | turns)
    }

    /// Lanes whose force may have been larger than anything yet within a span in which it swings more than once: at the steeper of its slopes, from the
    /// higher of its ends, it would get there.
    #[inline(always)]
    pub(crate) fn is_near(&self, [start, end]: [L; 2], [rise, fall]: [L; 2], h: L) -> L::Mask {
        (start.max(end) + h * rise.abs().max(fall.abs())).gt(self.force_n * L::splat(1.0 + NEAR))
    }
}
