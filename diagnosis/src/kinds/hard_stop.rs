//! `hard-stop`: an unexpected end of travel.

use feeler_plant::effects::{HardStop, Kind};

use super::{Element, Glance, Known, Seen};

/// Trial positions of stops, as shares of the way from the middle of the travel to its ends.
const PLACES: [f64; 4] = [0.3, 0.6, 0.85, 0.97];
/// Travel over the depth at which a stop holds the largest command.
const HARDNESS: [f64; 2] = [4.0, 40.0];

/// Share of the travel by which a stop gives way at most under the largest command: a softer one is a spring.
const SOFT: f64 = 0.15;

impl Known for HardStop {
    const APART: &'static [(Kind, &'static str)] = &[(
        Kind::ForceLimit,
        "begin the same stroke at another place: a stop stays where it is, a limit comes at the same force",
    )];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let ends = (glance.missing.iter())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (x, _)| [low.min(*x), high.max(*x)]);
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
        places.flat_map(at).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.command_n > SOFT * seen.stroke_m * self.stiffness
    }
}
