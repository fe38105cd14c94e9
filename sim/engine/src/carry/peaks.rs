//! The largest force of every stretch of contact, also between the rows of a record: peaks within a span are
//! found on the motion itself.

use feeler_lanes::Lane;
use feeler_plant::motion::dot;

use crate::error::EngineError;
use crate::solve::crossing::Piece;
use crate::solve::flow::{Flow, ROWS_PER_BEND, ROWS_PER_LINE};
use crate::solve::taylor::Series;

/// Relative height by which an unexamined peak may exceed the known maximum. Slopes from differences resolve
/// no more, and a force at rest must not be examined for its rounding.
pub(super) const PEAK_TOLERANCE: f64 = 1e-9;
/// The same height for spans in which the force may oscillate more than once. It is larger, so a force that
/// creeps to its maximum is not examined all the way.
pub(super) const ROUGH_PEAK_TOLERANCE: f64 = 1e-6;
/// Relative agreement required of two polynomials through the ends of a span; otherwise the motion itself is
/// searched for the peak.
const AGREE: f64 = 1e-5;
/// Largest number of evaluations at a peak of a nonlinear mode; each brings the bounds several times closer.
const MOST_EVALUATIONS: usize = 60;

/// A femtosecond, s.
const FEMTOSECOND: f64 = 1e-15;

/// The largest force of one stretch of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Time of the peak, s.
    pub t_s: f64,
    /// Largest force, N; 0 if the contact only pulled.
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

/// Height at which the tangents at both ends of a span of `h` meet, relative to `level`. They bound a force
/// that bends one way only. Positive if above.
#[inline(always)]
pub(super) fn room<L: Lane>([start, end]: [L; 2], [rise, fall]: [L; 2], h: L, level: L) -> L {
    (start - level) * (rise - fall) + rise * (end - start - fall * h)
}

/// Peaks of one variant: a list per contact, and the present stretch.
#[derive(Debug)]
pub(crate) struct Peaks {
    finished: Vec<Vec<Peak>>,
    pub(super) present: Vec<Option<Peak>>,
}

impl Peaks {
    pub(crate) fn new(contacts: usize) -> Self {
        Self { finished: vec![Vec::new(); contacts], present: vec![None; contacts] }
    }

    /// Records that the machine enters the mode of `flow`, or is still in it at the end of a fixed step.
    /// Stretches begin, rise and end.
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

    /// Every stretch of contact `i` so far. `abreast` is the peak of the present stretch if the lane travels
    /// in the group.
    pub(crate) fn of(&self, i: usize, abreast: Option<Peak>) -> Vec<Peak> {
        let present = self.present[i].map(|own| abreast.unwrap_or(own));
        self.finished[i].iter().copied().chain(present).collect()
    }

    /// Examines a piece of length `h` of a linear mode, from `xi` at `t_s`.
    pub(crate) fn linear_piece(&mut self, flow: &Flow, series: &Series, xi: &[f64], t_s: f64, h: f64) {
        for (i, present) in self.present.iter_mut().enumerate() {
            if let Some(present) = present {
                let force = series.functional(&flow.equations.contact_force[i], xi, flow.width);
                if force.may_exceed(present.force_n, h) {
                    let (s, force_n) = force.largest(h);
                    present.rise_to(Peak::at(t_s + s, force_n));
                }
            }
        }
    }

    /// Examines a piece of length `h` from `t_s`, of a mode without a polynomial.
    pub(crate) fn piece(&mut self, piece: &mut impl Piece, t_s: f64, h: f64) {
        for (i, present) in self.present.iter_mut().enumerate() {
            if let Some(present) = present {
                let row = piece.flow().equations.contact_force[i].clone();
                let ends = [0.0, h].map(|s| point(piece, &row, s, h));
                let [Some(start), Some(end)] = ends else { return };
                for point in [start, end] {
                    present.rise_to(Peak::at(t_s + point.s, point.force_n));
                }
                find_maximum(piece, &row, [start, end], h, t_s, present);
            }
        }
    }

    /// Finds the peak of a span of a linear mode that was travelled in one step from `xi`. The search uses
    /// parts in which a force has at most one peak. `xi` is moved.
    pub(crate) fn peak(
        &mut self,
        flow: &mut Flow,
        series: &mut Series,
        xi: &mut [f64],
        t_s: f64,
        span_fs: u64,
    ) -> Result<(), EngineError> {
        let parts = flow.evaluations(span_fs as f64 * FEMTOSECOND)?;
        let length_s = (span_fs / parts) as f64 * FEMTOSECOND;
        if parts == 1 {
            self.find_maximum_of_motion(flow, series, xi, t_s, length_s);
            return Ok(());
        }
        let (states, width) = (flow.states, flow.width);
        let bends_from = states + ROWS_PER_LINE * flow.lines.len();
        let rows = flow.transition(span_fs / parts)?.to_vec();
        for part in 0..parts {
            let from_s = t_s + part as f64 * length_s;
            let y: Vec<f64> = rows.chunks_exact(width).map(|row| dot(row, &xi[..width])).collect();
            let mut unclear = false;
            for (i, present) in self.present.iter_mut().enumerate() {
                let Some(present) = present else { continue };
                let (line, bends) = (&y[states + ROWS_PER_LINE * i..], &y[bends_from + ROWS_PER_BEND * i..]);
                let (ends, slopes) = ([line[3], line[0]], [line[1], line[2]]);
                present.rise_to(Peak::at(from_s, ends[0]));
                present.rise_to(Peak::at(from_s + length_s, ends[1]));
                match (Span { ends, slopes, bends: [bends[0], bends[1]], length_s, is_rough: false }).peak() {
                    PeakWithin::At { s, force_n } => present.rise_to(Peak::at(from_s + s, force_n)),
                    PeakWithin::Unclear => {
                        unclear |= room(ends, slopes, length_s, present.force_n) > 0.0
                            || slopes[0] * slopes[1] >= 0.0;
                    }
                    PeakWithin::None => {}
                }
            }
            if unclear {
                self.find_maximum_of_motion(flow, series, &mut xi.to_vec(), from_s, length_s);
            }
            xi[..states].copy_from_slice(&y[..states]);
        }
        Ok(())
    }

    /// Finds the peak of a span on the motion itself, by its series; `xi` is moved.
    fn find_maximum_of_motion(
        &mut self,
        flow: &Flow,
        series: &mut Series,
        xi: &mut [f64],
        t_s: f64,
        span_s: f64,
    ) {
        let mut gone_s = 0.0;
        while gone_s < span_s {
            let h = flow.horizon_s.min(span_s - gone_s);
            series.expand(flow, xi, h);
            self.linear_piece(flow, series, xi, t_s + gone_s, h);
            series.evaluate(h, xi);
            gone_s += h;
        }
    }
}

/// The force `s` after the start of a piece of `h`.
fn point(piece: &mut impl Piece, row: &[f64], s: f64, h: f64) -> Option<Point> {
    let xi = piece.state(s)?;
    Some(Point { s, force_n: dot(row, &xi), slope: piece.slope(row, &xi, h) })
}

/// The maximum within a piece in which the force rises at one end and falls at the other. Secant steps on the
/// slope go on until the tangents bound the maximum.
fn find_maximum(
    piece: &mut impl Piece,
    row: &[f64],
    [mut a, mut b]: [Point; 2],
    h: f64,
    t_s: f64,
    present: &mut Peak,
) {
    for _ in 0..MOST_EVALUATIONS {
        let level = present.force_n * (1.0 + PEAK_TOLERANCE);
        if a.slope <= 0.0
            || b.slope >= 0.0
            || room([a.force_n, b.force_n], [a.slope, b.slope], b.s - a.s, level) <= 0.0
        {
            return;
        }
        // The share stays away from the ends, so that both bounds move.
        let share = (a.slope / (a.slope - b.slope)).clamp(0.05, 0.95);
        let s = a.s + share * (b.s - a.s);
        let Some(middle) = point(piece, row, s, h) else { return };
        present.rise_to(Peak::at(t_s + s, middle.force_n));
        if middle.slope > 0.0 { a = middle } else { b = middle }
    }
}

/// A span of a linear mode, as seen by the force of one contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    /// Force at start and end, N.
    pub(crate) ends: [f64; 2],
    /// Slopes of the force at start and end, N/s.
    pub(crate) slopes: [f64; 2],
    /// Second derivatives of the force at start and end, N/s2.
    pub(crate) bends: [f64; 2],
    pub(crate) length_s: f64,
    /// Whether the force may have oscillated more than once.
    pub(crate) is_rough: bool,
}

/// The peak of a force within a span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PeakWithin {
    /// There is no peak.
    None,
    /// `s` after the start, with the force `force_n`.
    At { s: f64, force_n: f64 },
    /// The ends do not show whether there is a peak.
    Unclear,
}

impl Span {
    /// The peak, by the polynomials of third and fifth degree through the ends. For a sine that turns by `q`
    /// over the span their errors are `q^4 / 384` and `q^6 / 46080`. If both agree to [`AGREE`], the second
    /// is therefore correct to `q^2 / 120` times [`AGREE`]. An oscillation with many periods in the span
    /// separates the polynomials by many times its size, since its curvature exceeds what they can follow.
    pub(crate) fn peak(&self) -> PeakWithin {
        let ([start, end], [rise, fall]) = (self.ends, self.slopes);
        let [cubic, quintic] = self.polynomials();
        let size = AGREE * start.abs().max(end.abs());
        if self.is_rough && cubic.iter().zip(&quintic).map(|(a, b)| (a - b).abs()).sum::<f64>() > size {
            return PeakWithin::Unclear;
        }
        if rise <= 0.0 || fall >= 0.0 {
            return if (rise > 0.0 && end < start) || (fall < 0.0 && start < end) {
                PeakWithin::Unclear
            } else {
                PeakWithin::None
            };
        }
        let [(_, rough), (share, fine)] = [cubic, quintic].map(|c| highest(&c));
        if (fine - rough).abs() > size {
            PeakWithin::Unclear
        } else {
            PeakWithin::At { s: share * self.length_s, force_n: start + fine }
        }
    }

    /// The gain of the force over the span, by powers of the elapsed share.
    fn polynomials(&self) -> [[f64; 6]; 2] {
        let h = self.length_s;
        let ([d1, e1], [d2, e2]) = (self.slopes.map(|slope| slope * h), self.bends.map(|bend| bend * h * h));
        let gain = self.ends[1] - self.ends[0];
        let (r0, r1, r2) = (gain - d1 - 0.5 * d2, e1 - d1 - d2, e2 - d2);
        [
            [0.0, d1, 3.0 * gain - 2.0 * d1 - e1, d1 + e1 - 2.0 * gain, 0.0, 0.0],
            [
                0.0,
                d1,
                0.5 * d2,
                10.0 * r0 - 4.0 * r1 + 0.5 * r2,
                7.0 * r1 - 15.0 * r0 - r2,
                6.0 * r0 - 3.0 * r1 + 0.5 * r2,
            ],
        ]
    }
}

/// The maximum in `[0, 1]` of a polynomial that rises at the start and falls at the end: Newton on its slope,
/// kept inside the bracket.
fn highest(c: &[f64; 6]) -> (f64, f64) {
    let at = |u: f64| c.iter().rev().fold(0.0, |sum, c| sum * u + c);
    let slope = |u: f64| (1..6).rev().fold(0.0, |sum, k| sum * u + k as f64 * c[k]);
    let bend = |u: f64| (2..6).rev().fold(0.0, |sum, k| sum * u + (k * (k - 1)) as f64 * c[k]);
    let (mut a, mut b, mut u) = (0.0, 1.0, 0.5);
    for _ in 0..MOST_EVALUATIONS {
        let value = slope(u);
        if value > 0.0 {
            a = u;
        } else {
            b = u;
        }
        let newton = u - value / bend(u);
        let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
        if (next - u).abs() <= ROUGH_PEAK_TOLERANCE {
            return (next, at(next));
        }
        u = next;
    }
    (u, at(u))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 + 10 sin, turned by up to 1.2 rad over a span: the ends give the peak to 1.2e-7 (see
    /// [`Span::peak`]).
    #[test]
    fn truth_the_peak_of_a_sine_follows_from_both_ends() {
        let h = 5e-4;
        let mut told = 0;
        for turn in [0.02_f64, 0.1, 0.2, 0.4, 0.8, 1.2] {
            for share in [0.1, 0.37, 0.5, 0.9] {
                let (w, phase) = (turn / h, std::f64::consts::FRAC_PI_2 - share * turn);
                let of = |f: &dyn Fn(f64) -> f64| [f(phase), f(phase + turn)];
                let span = Span {
                    ends: of(&|p| 20.0 + 10.0 * p.sin()),
                    slopes: of(&|p| 10.0 * w * p.cos()),
                    bends: of(&|p| -10.0 * w * w * p.sin()),
                    length_s: h,
                    is_rough: false,
                };
                if let PeakWithin::At { s, force_n } = span.peak() {
                    told += 1;
                    assert!(
                        (force_n / 30.0 - 1.0).abs() < 1.2e-7 && (s / h - share).abs() < 1e-2,
                        "{turn} {share}: {force_n} at {s}"
                    );
                } else {
                    assert!(turn > 0.2, "{turn} {share}");
                }
                // A ripple of 1e-4 with seventy periods.
                let ripple = |p: f64| {
                    [3e-3 * p.sin(), 3e-3 * 440.0 / h * p.cos(), -3e-3 * (440.0 / h).powi(2) * p.sin()]
                };
                let [a, b] = [ripple(0.3 + turn), ripple(440.3 + turn)];
                let add = |values: [f64; 2], k: usize| [values[0] + a[k], values[1] + b[k]];
                let [ends, slopes, bends] = [add(span.ends, 0), add(span.slopes, 1), add(span.bends, 2)];
                assert_eq!(Span { ends, slopes, bends, is_rough: true, ..span }.peak(), PeakWithin::Unclear);
            }
        }
        assert!(told >= 12, "{told}");
    }
}
