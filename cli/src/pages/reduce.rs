//! The page of a map of the force bandwidth over a workspace.

use std::f64::consts::SQRT_2;
use std::fmt::Write as _;

use feeler_arm::Agreement;
use feeler_studies::arm::{MapPoint, MapValues, NoAxis, without_axis};
use serde_json::{Value, json};

use crate::numbers::{plain, with_unit};
use crate::pages::parts::svg::{Frame, Place, Plot, Scale, swatch, text_at};
use crate::pages::parts::{Page, of_share};

const PLOT: Place = Place { x: 90.0, y: 40.0, width: 540.0, height: 400.0 };
/// Colour of places that the arm does not reach.
const NOTHING: &str = "#f2f2f2";
/// Colours of reachable places without an axis, and of axes without this figure.
const NO_AXIS: &str = "#b8b8b8";
const NONE: &str = "#d9c9a3";
/// Crosses on places with an axis that cannot be trusted.
const CROSS: &str = "stroke=\"#000000\" stroke-width=\"1.2\" fill=\"none\"";
/// Side of the cell of a grid with one place along an axis, m.
const ONLY_CELL_M: f64 = 0.05;
/// Steps of colour in the legend.
const STEPS: u32 = 6;
/// Smallest cell that has room for its number.
const ROOM: [f64; 2] = [56.0, 18.0];
/// Narrowest cell that has room for large letters.
const LARGE_ROOM: f64 = 90.0;
/// Level above which black letters on a colour are more legible than white ones.
const BRIGHT: f64 = 0.47;

/// One figure of every place.
struct Field {
    title: &'static str,
    caption: &'static str,
    unit: &'static str,
    of: fn(&MapValues) -> f64,
    /// Ends of the colours for values between a smallest and a largest one.
    colours: fn([f64; 2]) -> [f64; 2],
}

/// Range of colours of at least a factor of two, so that a small difference looks small.
fn by_ratio([low, high]: [f64; 2]) -> [f64; 2] {
    let middle = (low * high).sqrt();
    if low > 0.0 { [low.min(middle / SQRT_2), high.max(middle * SQRT_2)] } else { [low, high] }
}

/// Range of colours that includes at least the trusted range of errors, %.
fn of_error([_, high]: [f64; 2]) -> [f64; 2] {
    [0.0, high.max(100.0 * Agreement::TRUSTED)]
}

const FIELDS: [Field; 4] = [
    Field {
        title: "Force bandwidth.",
        caption: "That of the arm: crossover of integral control of the contact's spring force, sampled at \
                  1 kHz, at half the arm's largest stable gain. Motor damping is 2 * 0.7 * contact mode * \
                  mass. Point at a place to see the axis's own.",
        unit: "Hz",
        of: |found| found.agreement.force_bandwidth_hz[0],
        colours: by_ratio,
    },
    Field {
        title: "Effective mass.",
        caption: "Moving mass along the normal, motors included.",
        unit: "kg",
        of: |found| found.mass_kg,
        colours: by_ratio,
    },
    Field {
        title: "Stiffness.",
        caption: "All joints in series along the normal, the motors locked.",
        unit: "N/m",
        of: |found| found.stiffness_n_per_m,
        colours: by_ratio,
    },
    Field {
        title: "Error of the axis.",
        caption: "The largest misfit of contact mode, phase crossover, stable kp and stable ki; places \
                  beyond 5 % are crossed out in every map.",
        unit: "%",
        of: |found| 100.0 * found.agreement.worst(),
        colours: of_error,
    },
];

/// The force bandwidth of the axis instead of the arm's.
const AXIS_BANDWIDTH: Field = Field {
    title: "",
    caption: "",
    unit: "Hz",
    of: |found| found.agreement.force_bandwidth_hz[1],
    colours: by_ratio,
};

/// The page; `command` gives the command for a position.
pub(crate) fn page(arm: &str, map: &[MapPoint], command: &dyn Fn([f64; 3]) -> String) -> String {
    let mut page = Page::new(&format!("{arm}: force bandwidth over the workspace"), "");
    let reached: Vec<(&MapPoint, &MapValues)> =
        map.iter().filter_map(|point| Some((point, point.found.as_ref().ok()?))).collect();
    page.lead(&(sentence(map, &reached) + &lacking(map)));
    let grid = Grid::of(map);
    let hover = json!({
        "places": map.iter().map(|point| grid.cell(point)).collect::<Vec<_>>(),
        "columns": columns(map),
        "settings": 0,
        "commands": map.iter().map(|point| command(point.place_m)).collect::<Vec<_>>(),
    });
    let mut first = None;
    for field in &FIELDS {
        let plot = grid.plot(map, field);
        let caption = format!(
            "{} Hover to see a place and the command that gives its axis; click to copy it.",
            field.caption
        );
        match first {
            None => first = Some(page.plot(field.title, &caption, &plot, hover.clone())),
            Some(first) => page.plot_like(field.title, field.caption, &plot, first),
        }
    }
    page.render()
}

fn sentence(map: &[MapPoint], reached: &[(&MapPoint, &MapValues)]) -> String {
    let places = map.len();
    let within = map.iter().filter(|point| !matches!(point.found, Err(NoAxis::OutOfReach))).count();
    let bandwidth = |(_, found): &&(&MapPoint, &MapValues)| found.agreement.force_bandwidth_hz[0];
    let with_one = || reached.iter().filter(|place| bandwidth(place).is_finite());
    let worst = with_one().min_by(|a, b| bandwidth(a).total_cmp(&bandwidth(b)));
    let best = with_one().max_by(|a, b| bandwidth(a).total_cmp(&bandwidth(b)));
    let at = |(point, found): &(&MapPoint, &MapValues)| {
        let [x, y, _] = point.place_m;
        format!(
            "{} at x = {} m, y = {} m",
            with_unit(found.agreement.force_bandwidth_hz[0], "Hz"),
            plain(x),
            plain(y)
        )
    };
    if within == 0 {
        return format!("The arm reaches none of {places} places.");
    }
    let (Some(worst), Some(best)) = (worst, best) else {
        return format!(
            "The arm reaches {within} of {places} places, and has a force bandwidth at none of them."
        );
    };
    let doubtful = reached.iter().filter(|(_, found)| !found.agreement.is_trusted()).count();
    let doubts = match doubtful {
        0 => " Everywhere the axis is within 5 % of the whole arm in contact mode, phase crossover, stable \
              kp and stable ki."
            .to_owned(),
        count => format!(
            " At {count} of them the axis is more than 5 % off the whole arm in contact mode, phase \
             crossover, stable kp or stable ki."
        ),
    };
    format!(
        "The arm reaches {within} of {places} places; its force bandwidth goes from {} to {}.{doubts}",
        at(worst),
        at(best)
    )
}

/// The colour of a place in the map of a figure.
fn colour_of(point: &MapPoint, field: &Field, share: &dyn Fn(f64) -> f64) -> String {
    match point.found.as_ref().map(field.of) {
        Ok(value) if value.is_finite() => of_share(share(value)),
        Ok(_) => NONE.to_owned(),
        Err(NoAxis::OutOfReach) => NOTHING.to_owned(),
        Err(_) => NO_AXIS.to_owned(),
    }
}

/// Number of places without an axis, or without a stable gain, by reason.
fn lacking(map: &[MapPoint]) -> String {
    let unstable = map
        .iter()
        .filter(|point| point.found.as_ref().is_ok_and(|found| found.agreement.largest_ki_per_s[0] <= 0.0))
        .count();
    let mut said: Vec<String> = without_axis(map)
        .into_iter()
        .map(|(reason, count)| format!(" Without an axis, {count}: {reason}."))
        .collect();
    if unstable > 0 {
        said.push(format!(
            " At {unstable} of the places no ki is stable, as the damping of the motors alone is unstable \
             at 1 kHz: there is no force bandwidth."
        ));
    }
    said.concat()
}

/// Texts of a place under the pointer.
fn columns(map: &[MapPoint]) -> Vec<Value> {
    let place = |name: &str, axis: usize| {
        json!([name, map.iter().map(|point| point.place_m[axis]).collect::<Vec<_>>(), "m"])
    };
    let field = |name: &str, field: &Field| {
        let values: Vec<Option<f64>> =
            map.iter().map(|point| point.found.as_ref().ok().map(field.of)).collect();
        json!([name, values, field.unit])
    };
    let [bandwidth, mass, stiffness, misfit] = &FIELDS;
    vec![
        place("x", 0),
        place("y", 1),
        place("z", 2),
        field("force bandwidth", bandwidth),
        field("of the axis", &AXIS_BANDWIDTH),
        field("mass", mass),
        field("stiffness", stiffness),
        field("axis off by", misfit),
    ]
}

/// The cells of a map.
struct Grid {
    frame: Frame,
    /// Sides of a cell, m.
    cell_m: [f64; 2],
}

impl Grid {
    fn of(map: &[MapPoint]) -> Self {
        let axis = |axis: usize, name: &str| {
            let mut values: Vec<f64> = map.iter().map(|point| point.place_m[axis]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup_by(|a, b| a.to_bits() == b.to_bits());
            let (low, high) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
            let cell_m =
                if values.len() > 1 { (high - low) / (values.len() - 1) as f64 } else { ONLY_CELL_M };
            let range = [low - 0.5 * cell_m, high + 0.5 * cell_m];
            (Scale { label: format!("{name} of the tool"), unit: "m".into(), range, log: false }, cell_m)
        };
        let ((x, width), (y, height)) = (axis(0, "x"), axis(1, "y"));
        Self { frame: Frame { place: PLOT, x, y }, cell_m: [width, height] }
    }

    /// Left, top, width and height.
    fn cell(&self, point: &MapPoint) -> [f64; 4] {
        let [x, y, _] = point.place_m;
        let [half_x, half_y] = self.cell_m.map(|side| 0.5 * side);
        let ([left, top], [right, bottom]) =
            (self.frame.at([x - half_x, y + half_y]), self.frame.at([x + half_x, y - half_y]));
        [left, top, right - left, bottom - top].map(|v| (v * 100.0).round() / 100.0)
    }

    fn plot(&self, map: &[MapPoint], field: &Field) -> Plot {
        let values = || {
            map.iter()
                .filter_map(|point| point.found.as_ref().ok().map(field.of))
                .filter(|value| value.is_finite())
        };
        let extent = values()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
        let [low, high] = if extent[0].is_finite() { (field.colours)(extent) } else { extent };
        let share = |value: f64| if high > low { (value - low) / (high - low) } else { 0.5 };
        let mut body = String::new();
        for point in map {
            let [x, y, width, height] = self.cell(point);
            let colour = colour_of(point, field, &share);
            // Cells are slightly enlarged, so that there are no gaps between them.
            let (width, height) = (width + 0.15, height + 0.15);
            let _ = write!(
                body,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{colour}\" \
                 shape-rendering=\"crispEdges\"/>"
            );
            let number = point.found.as_ref().ok().map(field.of).filter(|value| value.is_finite());
            if let Some(value) = number.filter(|_| width >= ROOM[0] && height >= ROOM[1]) {
                let ink = if share(value) < BRIGHT { "#ffffff" } else { "#000000" };
                let middle = [x + 0.5 * width, y + 0.5 * height + 4.0];
                // The larger letters of a narrow screen need more room.
                let tight = if width < LARGE_ROOM { " class=\"tight\"" } else { "" };
                let _ = write!(body, "<g{tight}>");
                text_at(&mut body, middle, "middle", 12, ink, &plain(value));
                body.push_str("</g>");
            }
            if point.found.as_ref().is_ok_and(|found| !found.agreement.is_trusted()) {
                let (right, bottom) = (x + width, y + height);
                let _ = write!(
                    body,
                    "<path d=\"M{x} {y}L{right:.2} {bottom:.2}M{right:.2} {y}L{x} {bottom:.2}\" {CROSS}/>"
                );
            }
        }
        self.frame.draw(&mut body, "");
        let entry = |step: u32| {
            let share = f64::from(step) / f64::from(STEPS);
            (swatch(&of_share(share)), with_unit(low + share * (high - low), field.unit))
        };
        let mut entries: Vec<(String, String)> = match (low.is_finite(), high > low) {
            (false, _) => Vec::new(),
            (true, false) => vec![(swatch(&of_share(0.5)), with_unit(low, field.unit))],
            (true, true) => (0..=STEPS).rev().map(entry).collect(),
        };
        if map.iter().any(|point| matches!(point.found, Err(NoAxis::OutOfReach))) {
            entries.push((swatch(NOTHING), "out of reach".into()));
        }
        if map.iter().any(|point| matches!(&point.found, Err(why) if *why != NoAxis::OutOfReach)) {
            entries.push((swatch(NO_AXIS), "no axis".into()));
        }
        if map.iter().any(|point| point.found.as_ref().is_ok_and(|found| !(field.of)(found).is_finite())) {
            entries.push((swatch(NONE), "none: see above".into()));
        }
        if map.iter().filter_map(|point| point.found.as_ref().ok()).any(|found| !found.agreement.is_trusted())
        {
            entries.push((
                format!("{}<path d=\"M0 0L24 14M24 0L0 14\" {CROSS}/>", swatch(NO_AXIS)),
                "axis off by over 5 %".into(),
            ));
        }
        Plot { place: PLOT, body, entries }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An increase of 10 % is 0.14 of the octave that the colours span.
    #[test]
    fn regress_small_differences_do_not_fill_the_colours() {
        let [low, high] = by_ratio([3.6, 3.96]);
        assert!((high / low - 2.0).abs() < 1e-12 && low < 3.6 && high > 3.96);
        assert!((3.96 - 3.6) / (high - low) < 0.15);
        let wide = by_ratio([1.0, 10.0]).map(f64::to_bits);
        assert_eq!(wide, [1.0_f64, 10.0].map(f64::to_bits));
        assert_eq!(of_error([0.5, 1.5]).map(f64::to_bits), [0.0_f64, 5.0].map(f64::to_bits));
    }
}
