//! The variants of a large sweep that its page draws.

use feeler_files::{Sampling, SweepAxis, SweepFile};
use feeler_studies::sweep::{DrawnAxis, Panels};

/// Largest number of drawn panels; the table has the rest.
pub(crate) const MOST_PANELS: usize = 8;
/// Largest number of drawn cells along an axis; of finer grids every n-th value is drawn.
pub(super) const MOST_CELLS: u64 = 256;
/// Largest number of variants that maps draw and show under the pointer.
const MOST_ON_MAPS: usize = 20_000;
/// Largest number of variants that diagrams draw: their columns are then narrower than half a pixel. Each
/// variant has a list of impacts.
const MOST_ON_DIAGRAMS: usize = 2_000;

/// A choice of variants.
#[derive(Debug)]
pub(super) enum Drawn {
    /// Every variant.
    All,
    /// This number of variants from the start: a fair sample of random points, or the coarse passes of an
    /// adaptive sweep.
    First(usize),
    /// For a grid, these values of each axis in the order of the file, and this number of panels.
    Grid { axes: Vec<Values>, panels: u64 },
}

/// The drawn values of an axis.
#[derive(Debug)]
pub(super) struct Values {
    key: String,
    count: u64,
    /// One value in this many is drawn; `None` if each value has its own panel.
    every: Option<u64>,
}

impl Values {
    fn drawn(&self) -> u64 {
        self.every.map_or(1, |every| self.count.div_ceil(every))
    }
}

impl Drawn {
    /// Selects from the `rows` variants of a sweep.
    pub(super) fn of(sweep: &SweepFile, rows: usize) -> Self {
        let on_diagrams = DrawnAxis::of(sweep).len() == 1;
        let most = if on_diagrams { MOST_ON_DIAGRAMS } else { MOST_ON_MAPS };
        if rows <= most {
            return Self::All;
        }
        if sweep.sampling != Sampling::Grid || sweep.refine.is_some() {
            return Self::First(most);
        }
        let apart = Panels::of(sweep);
        let panels = apart.count().min(MOST_PANELS as u64);
        let values = |(key, axis): (&String, &SweepAxis)| {
            let count = axis.count().unwrap_or(1);
            let every = if on_diagrams { 1 } else { count.div_ceil(MOST_CELLS) };
            Values { key: key.clone(), count, every: (!apart.has(key)).then_some(every) }
        };
        let mut axes: Vec<Values> = sweep.axes.iter().map(values).collect();
        let budget = most as u64 / panels.max(1);
        // The axis with the most remaining values is thinned out until the number is small enough.
        while axes.iter().map(Values::drawn).product::<u64>() > budget.max(1) {
            let Some(axis) = axes.iter_mut().max_by_key(|axis| axis.drawn()) else { break };
            axis.every = axis.every.map(|every| every + 1);
        }
        Self::Grid { axes, panels }
    }

    /// Whether a variant is drawn.
    pub(super) fn has(&self, row: usize) -> bool {
        match self {
            Self::All => true,
            Self::First(count) => row < *count,
            Self::Grid { axes, panels: drawn } => {
                // The last axis varies fastest, also among panels.
                let (mut rest, mut panel, mut panels) = (row as u64, 0, 1);
                for axis in axes.iter().rev() {
                    let index = rest % axis.count;
                    rest /= axis.count;
                    match axis.every {
                        Some(every) if !index.is_multiple_of(every) => return false,
                        Some(_) => {}
                        None => {
                            panel += index * panels;
                            panels *= axis.count;
                        }
                    }
                }
                panel < *drawn
            }
        }
    }

    /// The codes of every variant in a panel of a thinned grid. They are the number of columns and rows of
    /// its map, and one code for each cell, row by row from below. `None` if all values are drawn.
    pub(super) fn panel(&self, keys: [&str; 2], panel: u64, codes: &[u8]) -> Option<([usize; 2], Vec<u8>)> {
        let Self::Grid { axes, .. } = self else { return None };
        let count = |key: &str| axes.iter().find(|axis| axis.key == key).map(|axis| axis.count as usize);
        let [columns, rows] = [count(keys[0])?, count(keys[1])?];
        let mut cells = vec![0; columns * rows];
        for (row, code) in codes.iter().enumerate() {
            let (mut rest, mut own, mut panels, mut at) = (row as u64, 0, 1, [0; 2]);
            for axis in axes.iter().rev() {
                let index = rest % axis.count;
                rest /= axis.count;
                if axis.every.is_none() {
                    own += index * panels;
                    panels *= axis.count;
                } else if let Some(i) = keys.iter().position(|key| *key == axis.key) {
                    at[i] = index as usize;
                }
            }
            if own == panel {
                cells[at[1] * columns + at[0]] = *code;
            }
        }
        Some(([columns, rows], cells))
    }

    /// Spacing of the drawn values of an axis; `None` if all values of a grid are drawn.
    pub(super) fn every(&self, key: &str) -> Option<u64> {
        if let Self::Grid { axes, .. } = self {
            axes.iter().find(|axis| axis.key == key)?.every
        } else {
            None
        }
    }

    /// Describes the omitted variants; empty if none is omitted. `drawn` is the number of drawn variants.
    pub(super) fn words(&self, drawn: usize) -> String {
        let which = match self {
            Self::All => return String::new(),
            Self::First(_) => "the first of them".to_owned(),
            Self::Grid { axes, .. } => {
                let thinned =
                    axes.iter().filter_map(|axis| Some((axis.every.filter(|&every| every > 1)?, &axis.key)));
                let words: Vec<String> =
                    thinned.map(|(every, key)| format!("one value in {every} of {key}")).collect();
                words.join(", ")
            }
        };
        format!(
            " The drawings below hold {drawn} variants ({which}); all figures here, and sweep.parquet, are \
             of all."
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_studies::sweep::Sweep;

    fn sweep(axes: &str) -> SweepFile {
        let text = format!("scenario = \"../paper/rigid.toml\"\n{axes}");
        let place = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/sweeps/large.toml");
        Sweep::parse(&text, &place.display().to_string()).unwrap().file
    }

    fn drawn(file: &SweepFile) -> Vec<usize> {
        let rows = file.samples as usize;
        let drawn = Drawn::of(file, rows);
        (0..rows).filter(|&row| drawn.has(row)).collect()
    }

    #[test]
    fn prop_large_grids_are_thinned_evenly_and_small_ones_not() {
        let grid = |[x, y]: [u64; 2]| {
            sweep(&format!(
                "[axes]\n\"controllers.force.kp\" = {{ linear = [0.1, 1.0], points = {x} }}\n\
                 \"contacts.tool.stiffness\" = {{ log = [\"10 kN/m\", \"1 MN/m\"], points = {y} \
                 }}\n\"run.seed\" = [1, 2]\n"
            ))
        };
        assert_eq!(drawn(&grid([100, 100])).len(), 20_000);
        let large = grid([400, 300]);
        let rows = drawn(&large);
        assert!(rows.len() > MOST_ON_MAPS / 2 && rows.len() <= MOST_ON_MAPS, "{}", rows.len());
        let Drawn::Grid { axes, .. } = Drawn::of(&large, 240_000) else {
            panic!("a grid is thinned by values")
        };
        let [x, y] = [0, 1].map(|i| axes[i].every.unwrap() as usize);
        let on_lattice = |row: usize| (row / 600).is_multiple_of(x) && (row / 2 % 300).is_multiple_of(y);
        assert_eq!(rows, (0..240_000).filter(|&row| on_lattice(row)).collect::<Vec<_>>());
        // The page holds all of 400 by 300 values: the variants with the second seed, by their rows.
        let whole = Drawn::of(&large, 240_000);
        let codes: Vec<u8> = (0..240_000_usize).map(|row| (row % 251) as u8).collect();
        let keys = ["controllers.force.kp", "contacts.tool.stiffness"];
        let ([columns, rows], cells) = whole.panel(keys, 1, &codes).unwrap();
        assert_eq!([columns, rows], [400, 300]);
        let of = |x: usize, y: usize| codes[x * 600 + 2 * y + 1];
        assert!((0..400).all(|x| (0..300).all(|y| cells[y * columns + x] == of(x, y))));
        assert!(Drawn::All.panel(keys, 0, &codes).is_none());
    }

    #[test]
    fn prop_drawn_points_and_diagrams_stay_in_bounds() {
        let drawn_at_random = "sampling = \"sobol\"\nsamples = 50000\n[axes]\n\"controllers.force.kp\" = { \
                               uniform = [0.1, 1.0] }\n";
        assert_eq!(drawn(&sweep(drawn_at_random)), (0..MOST_ON_DIAGRAMS).collect::<Vec<_>>());
        let line = sweep("[axes]\n\"controllers.force.kp\" = { linear = [0.1, 1.0], points = 5000 }\n");
        assert_eq!(drawn(&line), (0..5000).step_by(3).collect::<Vec<_>>());
    }
}
