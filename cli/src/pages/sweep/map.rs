//! Maps over two axes: each variant is a cell, coloured by its outcome or by a measure. The limits of linear
//! theory are drawn over the cells.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use feeler_files::Setting;
use feeler_studies::run::Outcome;
use feeler_studies::sweep::{DrawnAxis, MapTheory, Sweep, SweepTable, shown};

use super::drawn::{Drawn, MOST_CELLS};
use super::nearest::{Tile, tiles};
use super::palette::of_outcome;
use crate::numbers::with_unit;
use crate::pages::parts::of_share;
use crate::pages::parts::svg::{Frame, INK, Place, Plot, Scale, swatch};

/// Half the size of a variant outside a grid, as a share of the plot.
const DOT: f64 = 0.006;
const PLOT: Place = Place { x: 92.0, y: 34.0, width: 540.0, height: 430.0 };

/// A cell: its lower left corner as shares of the plot, and the variant.
#[derive(Clone, Copy, Debug)]
struct Cell {
    left: f64,
    low: f64,
    width: f64,
    height: f64,
    row: usize,
}

impl Cell {
    fn place(&self) -> Place {
        Place {
            x: PLOT.x + self.left * PLOT.width,
            y: PLOT.y + (1.0 - self.low - self.height) * PLOT.height,
            width: self.width * PLOT.width,
            height: self.height * PLOT.height,
        }
    }
}

/// The variants of one panel on two axes.
pub(super) struct Map<'a> {
    axes: [&'a DrawnAxis; 2],
    pub(super) title: String,
    cells: Vec<Cell>,
    /// Whether variants are denser along boundaries; the area between has the colour of the nearest one.
    is_refined: bool,
    theory: MapTheory,
}

/// Settings that the variants of a panel share.
pub(super) type Panel = [(String, Setting)];

/// The quantity that colours the cells.
pub(super) enum Colouring<'a> {
    /// Outcomes by row.
    Outcome(&'a [String]),
    /// A measure by row, with its name and unit.
    Measure(&'a [Option<f64>], &'static str, &'static str),
}

impl<'a> Map<'a> {
    pub(super) fn new(
        sweep: &Sweep,
        table: &SweepTable,
        drawn: &Drawn,
        axes: [&'a DrawnAxis; 2],
        panel: &Panel,
        theory: &MapTheory,
    ) -> Self {
        let values = axes.map(|axis| table.reals(&axis.key).unwrap_or_default());
        let place =
            |row: usize| Some(([axes[0].share(values[0][row]?), axes[1].share(values[1][row]?)], row));
        let places: Vec<([f64; 2], usize)> = table.rows_with(panel).into_iter().filter_map(place).collect();
        let lattice = axes.map(|axis| {
            axis.points.map(|points| {
                let stride = axis.stride(&sweep.file);
                let every = drawn.every(&axis.key).unwrap_or_else(|| points.div_ceil(MOST_CELLS));
                Lattice { last: (points - 1) * stride, stride, every }
            })
        });
        let cells = match (sweep.file.refine, lattice) {
            (Some(_), [Some(x), Some(y)]) => refined(&places, [x, y]),
            _ => places
                .iter()
                .filter_map(|(share, row)| {
                    let [[left, width], [low, height]] = sides(*share, lattice)?;
                    Some(Cell { left, low, width, height, row: *row })
                })
                .collect(),
        };
        let is_refined = sweep.file.refine.is_some();
        let mut map = Self { axes, title: words(panel), cells, is_refined, theory: theory.clone() };
        let frame = map.frame();
        for lines in [&mut map.theory.limits.sampled, &mut map.theory.limits.continuous] {
            lines.retain(|line| crosses(&frame, line));
        }
        map
    }

    /// The meaning of a cell.
    pub(super) fn about_cells(&self) -> &'static str {
        if self.is_refined {
            "Each place has the colour of the nearest variant."
        } else {
            "Each cell is a variant."
        }
    }

    /// Meaning of the lines, or why there are none.
    pub(super) fn about_limits(&self) -> String {
        if !self.theory.varied.is_empty() {
            return format!(
                "No limit of linear theory is drawn, since each cell has its own value of {}.",
                self.theory.varied.join(", ")
            );
        }
        let [sampled, continuous] =
            [&self.theory.limits.sampled, &self.theory.limits.continuous].map(|lines| !lines.is_empty());
        match (sampled, continuous) {
            (true, true) => {
                "The solid line is the stability limit of the sampled loop by linear theory, the dashed line \
                 that of continuous control. Every contact is closed."
            }
            (true, false) => {
                "The line is the stability limit of the sampled loop by linear theory. Every contact is \
                 closed. Continuous control has no limit on this map."
            }
            (false, true) => {
                "The dashed line is the stability limit of continuous control by linear theory. Every \
                 contact is closed. The sampled loop has no limit on this map."
            }
            (false, false) => "Linear theory has no stability limit on this map. Every contact is closed.",
        }
        .into()
    }

    /// The rows that the map shows.
    pub(super) fn rows(&self) -> impl Iterator<Item = usize> {
        self.cells.iter().map(|cell| cell.row)
    }

    fn frame(&self) -> Frame {
        let scale = |axis: &DrawnAxis, margin: f64| Scale {
            label: axis.key.clone(),
            unit: axis.unit.clone(),
            range: [axis.value(-margin), axis.value(1.0 + margin)],
            log: axis.log,
        };
        let [x, y] = [0, 1].map(|i| scale(self.axes[i], self.theory.margins[i]));
        Frame { place: PLOT, x, y }
    }

    /// Place and row of each cell, as input of the page's script.
    pub(super) fn places(&self) -> Vec<[f64; 5]> {
        let round = |v: f64| (v * 100.0).round() / 100.0;
        let of = |cell: &Cell| {
            let place = cell.place();
            [round(place.x), round(place.y), round(place.width), round(place.height), cell.row as f64]
        };
        self.cells.iter().map(of).collect()
    }

    pub(super) fn plot(&self, colouring: &Colouring<'_>) -> Plot {
        let (mut body, mut contents) = (String::new(), String::new());
        let (colours, mut entries) = self.colours(colouring);
        let mut paths: BTreeMap<String, String> = BTreeMap::new();
        for (cell, colour) in self.cells.iter().zip(&colours) {
            let Place { x, y, width, height } = cell.place();
            let path = paths.entry(colour.clone()).or_default();
            // Cells are slightly widened, so that there are no gaps between them.
            let _ =
                write!(path, "M{x:.2} {y:.2}h{:.2}v{:.2}h-{:.2}z", width + 0.15, height + 0.15, width + 0.15);
        }
        for (colour, path) in &paths {
            let _ = write!(contents, "<path d=\"{path}\" fill=\"{colour}\" shape-rendering=\"crispEdges\"/>");
        }
        let frame = self.frame();
        frame.clip(&mut body, "plot");
        for line in &self.theory.limits.continuous {
            frame.line(&mut contents, "plot", line, true);
        }
        for line in &self.theory.limits.sampled {
            frame.line(&mut contents, "plot", line, false);
        }
        let class = if matches!(colouring, Colouring::Outcome(_)) { " outcomes" } else { "" };
        frame.zoomable(&mut body, "plot", class, &contents);
        frame.draw(&mut body, &self.title);
        let line = |dash: &str| format!("<path d=\"M0 7h24\" stroke=\"{INK}\" stroke-width=\"2\"{dash}/>");
        if !self.theory.limits.sampled.is_empty() {
            entries.push((line(""), "stability limit, sampled".into()));
        }
        if !self.theory.limits.continuous.is_empty() {
            entries.push((line(" stroke-dasharray=\"7 5\""), "stability limit, continuous control".into()));
        }
        Plot { place: PLOT, body, entries }
    }

    /// A colour for each cell, and the legend.
    fn colours(&self, colouring: &Colouring<'_>) -> (Vec<String>, Vec<(String, String)>) {
        match colouring {
            Colouring::Outcome(outcomes) => {
                let colours =
                    self.cells.iter().map(|cell| of_outcome(&outcomes[cell.row]).to_owned()).collect();
                let met = |name: &str| self.cells.iter().any(|cell| outcomes[cell.row] == name);
                let known = Outcome::ALL.iter().filter(|(_, name)| met(name));
                let mut entries: Vec<_> = known
                    .map(|(outcome, name)| (swatch(of_outcome(name)), outcome.words().to_owned()))
                    .collect();
                if met("error") {
                    entries.push((swatch(of_outcome("error")), "failed".into()));
                }
                (colours, entries)
            }
            Colouring::Measure(values, name, unit) => {
                let positive = self.cells.iter().filter_map(|cell| values[cell.row]).filter(|v| *v > 0.0);
                let (low, high) =
                    positive.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
                let share =
                    |value: f64| if high > low { (value / low).ln() / (high / low).ln() } else { 0.5 };
                let colour = |cell: &Cell| match values[cell.row] {
                    Some(value) if value > 0.0 => of_share(share(value)),
                    _ => "#f2f2f2".to_owned(),
                };
                let colours = self.cells.iter().map(colour).collect();
                let mut entries = vec![(String::new(), (*name).to_owned())];
                if high > low {
                    let step = |i: u32| f64::from(i) / 6.0;
                    let entry = |i: u32| {
                        (swatch(&of_share(step(i))), with_unit(low * (high / low).powf(step(i)), unit))
                    };
                    entries.extend((0..=6).rev().map(entry));
                }
                if self.cells.iter().any(|cell| values[cell.row].is_none_or(|v| v <= 0.0)) {
                    entries.push((swatch("#f2f2f2"), "none".into()));
                }
                (colours, entries)
            }
        }
    }
}

/// Whether part of a line may be within a frame.
fn crosses(frame: &Frame, line: &[[f64; 2]]) -> bool {
    let shares = |point: &[f64; 2]| [frame.x.share(point[0]), frame.y.share(point[1])];
    let spans = |[a, b]: [[f64; 2]; 2]| (0..2).all(|i| a[i].min(b[i]) <= 1.0 && a[i].max(b[i]) >= 0.0);
    let meets = |pair: &[[f64; 2]]| spans([shares(&pair[0]), shares(&pair[pair.len() - 1])]);
    if line.len() == 1 { meets(line) } else { line.windows(2).any(meets) }
}

/// The drawn values of an axis.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    /// Index of the last value.
    last: u64,
    /// Distance between values of the coarsest grid, in values of the finest.
    stride: u64,
    /// A cell is drawn at every n-th index.
    every: u64,
}

/// Start, as a share of the plot, and length of a cell's sides; `None` if the grid is too fine to show this
/// cell.
fn sides(share: [f64; 2], lattice: [Option<Lattice>; 2]) -> Option<[[f64; 2]; 2]> {
    let [Some(x), Some(y)] = lattice else {
        return Some(share.map(|at| [at - DOT, 2.0 * DOT]));
    };
    let of = |share: f64, Lattice { last, every, .. }: Lattice| {
        let index = (share * last as f64).round() as u64;
        // The plot extends half a cell beyond the outermost values, and clips wider cells there.
        let cells = (last + 1) as f64;
        let half = 0.5 * every as f64;
        let [from, to] = [-half, half].map(|side| (index as f64 + 0.5 + side).clamp(0.0, cells));
        (index.is_multiple_of(every)).then(|| [from / cells, (to - from) / cells])
    };
    Some([of(share[0], x)?, of(share[1], y)?])
}

/// The cells of a map whose variants, at shares of the axes, are denser along boundaries.
fn refined(places: &[([f64; 2], usize)], lattice: [Lattice; 2]) -> Vec<Cell> {
    // Converts shares between the outermost values to shares of the plot, which extends by half of the finest
    // cell beyond them.
    let of_plot = |share: f64, Lattice { last, .. }: Lattice| (share * last as f64 + 0.5) / (last + 1) as f64;
    let shares: Vec<[f64; 2]> =
        places.iter().map(|([x, y], _)| [of_plot(*x, lattice[0]), of_plot(*y, lattice[1])]).collect();
    let counts = lattice.map(|lattice| (lattice.last + 1).min(MOST_CELLS));
    let coarse = [0, 1].map(|i| lattice[i].stride as f64 * counts[i] as f64 / (lattice[i].last + 1) as f64);
    let [columns, rows] = counts.map(|count| count as f64);
    let cell = |tile: Tile| Cell {
        left: tile.columns[0] as f64 / columns,
        width: tile.columns[1] as f64 / columns,
        low: tile.rows[0] as f64 / rows,
        height: tile.rows[1] as f64 / rows,
        row: places[tile.of].1,
    };
    tiles(&shares, counts.map(|count| count as usize), coarse).into_iter().map(cell).collect()
}

/// The settings of a panel, as a title.
pub(super) fn words(panel: &Panel) -> String {
    let words: Vec<String> =
        panel.iter().map(|(key, setting)| format!("{key} = {}", shown(setting))).collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Frame {
        let scale = |range| Scale { label: String::new(), unit: String::new(), range, log: false };
        Frame { place: PLOT, x: scale([0.0, 10.0]), y: scale([0.0, 1.0]) }
    }

    #[test]
    fn truth_only_lines_that_show_are_drawn_and_named() {
        assert!(crosses(&frame(), &[[1.0, 0.5], [2.0, 3.0]]));
        assert!(crosses(&frame(), &[[1.0, -2.0], [2.0, 3.0]]), "through the plot, with no point in it");
        assert!(!crosses(&frame(), &[[1.0, 2.0], [9.0, 3.0]]) && !crosses(&frame(), &[]));
    }

    /// Two levels of bisection between three values: the coarse values are known, and one in between. The
    /// plot ends half a finest cell beyond the outermost values.
    #[test]
    fn regress_a_refined_map_is_painted_by_the_nearest_variant_up_to_its_ends() {
        let lattice = Lattice { last: 8, stride: 4, every: 1 };
        let coarse = (0..3).flat_map(|x| (0..3).map(move |y| [0.5 * f64::from(x), 0.5 * f64::from(y)]));
        let places: Vec<([f64; 2], usize)> =
            coarse.chain([[0.25, 0.25]]).enumerate().map(|(row, share)| (share, row)).collect();
        let cells = refined(&places, [lattice; 2]);
        let area = |row: usize| {
            cells
                .iter()
                .filter(|cell| cell.row == row)
                .map(|cell| 81.0 * cell.width * cell.height)
                .sum::<f64>()
        };
        assert!((cells.iter().map(|cell| cell.width * cell.height).sum::<f64>() - 1.0).abs() < 1e-12);
        // Corner (0, 0). Of the 3 x 3 cells nearest to it among the coarse ones, (2, 2), (1, 2) and (2, 1)
        // belong to the middle variant.
        assert!((area(0) - 6.0).abs() < 1e-9, "{}", area(0));
        let holds = |cell: &Cell, x: f64, y: f64| {
            (cell.left..cell.left + cell.width).contains(&x)
                && (cell.low..cell.low + cell.height).contains(&y)
        };
        let at = |x: f64, y: f64| cells.iter().find(|cell| holds(cell, x / 9.0, y / 9.0)).unwrap().row;
        assert_eq!((at(0.5, 0.5), at(2.5, 2.5), at(8.5, 8.5)), (0, 9, 8));
    }

    #[test]
    fn truth_cells_of_a_grid_stand_about_their_values() {
        let [[left, width], [low, height]] =
            sides([0.0, 0.5], [Some(Lattice { last: 4, stride: 1, every: 1 }); 2]).unwrap();
        assert!(
            left.abs() < 1e-12
                && (width - 0.2).abs() < 1e-12
                && (low - 0.4).abs() < 1e-12
                && (height - 0.2).abs() < 1e-12
        );
    }
}
