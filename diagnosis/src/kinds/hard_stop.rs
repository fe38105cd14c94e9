//! `hard-stop`: an unexpected end stop.

use feeler_plant::effects::{HardStop, Kind};

use super::{At, Balance, Element, Extent, Force, Form, Glance, Known, Seen};

/// Trial positions of stops, as shares of the distance from the middle of the stroke to its ends.
const PLACES: [f64; 4] = [0.3, 0.6, 0.85, 0.97];
/// Ratio of the stroke to the depth at which a stop holds the largest command.
const HARDNESS: [f64; 2] = [4.0, 40.0];

/// Number of trial positions, from the middle of the stroke to an end, at which the missing force may begin.
const LOOKED_AT: usize = 20;

/// Largest deflection of a stop under the largest command, as a share of the stroke. A softer stop is a
/// spring.
const SOFT: f64 = 0.25;
/// Largest share of the stroke beyond a stop.
const BEYOND: f64 = 0.25;

/// Number of trial positions on either side of the middle of the stroke.
const BALANCED: usize = 16;

impl Known for HardStop {
    /// The damping of a stop is left out: it acts only while the stop yields.
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(&[Force::positive(pushed)]),
        shapes: positions,
        values: |of, position| Self { position, stiffness: of[0], damping: 0.0 },
        coefficients: |own| (vec![own.stiffness], own.position),
    });
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::ForceLimit,
        "begin the same stroke at another place: a stop stays where it is, a limit comes at the same force",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let ends = glance.ends();
        let [low, high] = ends;
        let stroke = high - low;
        if !(stroke > 0.0 && stroke.is_finite()) {
            return Vec::new();
        }
        let middle = 0.5 * (low + high);
        let at = |place: f64| {
            HARDNESS.map(|hard| Self {
                position: place,
                stiffness: hard * glance.command / stroke,
                damping: 0.0,
            })
        };
        let places = PLACES.into_iter().flat_map(|share| ends.map(|end| middle + share * (end - middle)));
        let portrayed = ends.into_iter().filter_map(|end| portrayed(&glance.missing, middle, end));
        places.flat_map(at).chain(portrayed).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        is_spring(self, seen)
    }
}

/// Depth in a stop on its side of the middle of the stroke, positive at the upper end.
fn pushed(at: At) -> f64 {
    let side = (at.shape - at.middle).signum();
    side * (side * (at.position - at.shape)).max(0.0)
}

/// Trial positions in ascending order, up to just before the ends of the stroke.
fn positions(extent: &Extent) -> Vec<f64> {
    let share = |k: usize| 0.3 + 0.67 * k as f64 / (BALANCED - 1) as f64;
    let of = |end: f64| (0..BALANCED).map(move |k| extent.middle() + share(k) * (end - extent.middle()));
    let mut positions: Vec<f64> = extent.ends.into_iter().flat_map(of).collect();
    positions.sort_by(f64::total_cmp);
    positions
}

/// Whether a stop is in fact a spring: it is soft, or much of the stroke lies beyond it.
fn is_spring(stop: HardStop, seen: Seen) -> bool {
    let [low, high] = seen.ends_m;
    let beyond = (high - stop.position).min(stop.position - low);
    seen.command_n > SOFT * seen.stroke_m() * stop.stiffness || beyond > BEYOND * seen.stroke_m()
}

/// The stop between the middle and an end of the stroke that explains most of the missing force over
/// position, `(x, F)`; `None` if no force pushes back.
fn portrayed(missing: &[(f64, f64)], middle: f64, end: f64) -> Option<HardStop> {
    let side = (end - middle).signum();
    let at = |k: usize| {
        let position = middle + k as f64 / LOOKED_AT as f64 * (end - middle);
        let depth = |x: f64| (side * (x - position)).max(0.0);
        // The other half of the stroke is left out, because it may have another stop.
        let is_before = |x: f64| depth(x) == 0.0 && side * (x - middle) >= 0.0;
        let before: Vec<f64> = missing.iter().filter(|(x, _)| is_before(*x)).map(|(_, f)| *f).collect();
        let level = before.iter().sum::<f64>() / before.len().max(1) as f64;
        let (mut square, mut pushed) = (0.0_f64, 0.0_f64);
        for (x, f) in missing {
            square += depth(*x).powi(2);
            pushed -= side * depth(*x) * (f - level);
        }
        let stiffness = pushed / square;
        let stop = HardStop { position, stiffness, damping: 0.0 };
        (stiffness > 0.0 && stiffness.is_finite()).then_some((pushed * stiffness, stop))
    };
    let found = (1..LOOKED_AT).filter_map(at).max_by(|a, b| a.0.total_cmp(&b.0));
    found.map(|(_, stop)| stop)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant force of 2 N, and a stop of 500 N/m beyond 0.6 m, over a stroke from -1 m to 1 m.
    #[test]
    fn truth_the_portrait_shows_where_a_stop_begins() {
        let of = |x: f64| (x, 2.0 - 500.0 * (x - 0.6).max(0.0));
        let missing: Vec<(f64, f64)> = (-100..=100).map(|k| of(f64::from(k) / 100.0)).collect();
        let stop = portrayed(&missing, 0.0, 1.0).expect("it pushes back");
        // The stop is at a trial position, where the regression is exact to machine precision.
        assert!((stop.position - 0.6).abs() < 1e-12 && (stop.stiffness / 500.0 - 1.0).abs() < 1e-9);
        assert!(portrayed(&missing, 0.0, -1.0).is_none());
    }

    #[test]
    fn truth_a_stop_ends_a_travel_and_a_spring_does_not() {
        let seen = Seen { ends_m: [-1.0, 1.0], command_n: 100.0, ..Seen::default() };
        let of = |position, stiffness| is_spring(HardStop { position, stiffness, damping: 0.0 }, seen);
        // The stop holds 100 N within 0.5 m, a quarter of the stroke, and begins 0.4 m before an end.
        assert!(!of(0.6, 200.0) && !of(-0.6, 200.0));
        // The first deflects by 1 m. The second begins 0.9 m before the end, like a cable over half of the
        // stroke.
        assert!(of(0.6, 100.0) && of(0.1, 200.0));
    }
}
