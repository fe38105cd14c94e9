//! Fits what is not linear in a balance: the shapes of causes, and the reversals of friction beside them.

use std::sync::Arc;

use feeler_plant::description::Site;
use feeler_plant::effects::Kind;

use super::reversal::{Reversal, least};
use super::{Inverse, Known, Shaped};
use crate::fit::candidates::Candidate;
use crate::kinds::{Form, Shown, dossier};

/// Iterations over the shapes of several causes, one shape after another.
const ROUNDS: usize = 3;
/// Ratio of golden sections, and their number between two shapes.
const GOLDEN: f64 = 0.618_034;
const SECTIONS: usize = 8;
impl Inverse {
    /// The causes with the shapes, and with the reversals of friction, that leave the smallest residual on
    /// the fitted experiments. A rough search takes the reversals of the causes alone.
    pub(super) fn shaped<'b>(&self, causes: &'b [Candidate], is_fine: bool) -> Option<Shaped<'b>> {
        let shown: Vec<Shown> = causes
            .iter()
            .map(|cause| dossier(cause.definition.kind).balance.filter(|_| self.base.shows(cause)))
            .collect::<Option<_>>()?;
        let grids: Vec<Vec<f64>> = shown.iter().map(|shown| (shown.shapes)(&self.extent)).collect();
        let shapes = grids.iter().map(|grid| grid[grid.len() / 2]).collect();
        let of_form = |shown: &Shown| match shown.form {
            Form::Forces(forces) => forces.len(),
            Form::Mass | Form::Deadband => 1,
            _ => 0,
        };
        let unknowns = shown.iter().map(of_form).sum::<usize>()
            + grids.iter().filter(|grid: &&Vec<f64>| grid.len() > 1).count()
            + self.of_reversals(causes);
        let reversals = self.reversals.clone();
        let mut shaped = Shaped { causes, shown, shapes, unknowns, reversals, is_floating: false };
        let is_dry = self.base.has_dry_friction(causes);
        if let Some((shapes, reversal)) = is_dry.then(|| self.known(causes)).flatten() {
            let reversals = Arc::new(self.reversals(reversal));
            return Some(Shaped { shapes, reversals, ..shaped });
        }
        if is_dry {
            if is_fine {
                self.shape(&mut shaped, &grids);
            }
            self.reverse(&mut shaped, is_fine);
        }
        self.shape(&mut shaped, &grids);
        if is_fine {
            self.sharpen(&mut shaped, &grids);
        }
        if is_dry && is_fine {
            if shaped.is_late() {
                self.reverse(&mut shaped, true);
                self.sharpen(&mut shaped, &grids);
            }
            self.keep(&shaped);
        }
        Some(shaped)
    }

    fn reverse(&self, shaped: &mut Shaped<'_>, is_fine: bool) {
        let reversal = self.reversal_of(shaped, is_fine);
        shaped.reversals = Arc::new(self.reversals(reversal));
    }

    /// The reversal that leaves least with these shapes; a rough search tries those of the causes alone. A
    /// lag or delay floats with the reversal. Damping of bristles makes their force lead and hides a lag.
    /// Neither moves far without the other.
    fn reversal_of(&self, shaped: &Shaped<'_>, is_fine: bool) -> Reversal {
        let is_floating = is_fine && shaped.is_late();
        let left = |reversal: Reversal| {
            let reversals = Arc::new(self.trial(reversal));
            self.left(&Shaped { reversals, is_floating, ..shaped.clone() }, None)
        };
        let causes = shaped.causes;
        let limits = self.limits();
        let all = limits.all().filter(|_| is_fine && self.of_reversals(causes) > 0);
        let known = |cause: &Candidate| self.known(&[*cause]).filter(|_| !is_fine).map(|(_, found)| found);
        let trials = all.chain(causes.iter().filter_map(known)).chain([shaped.reversals.reversal]);
        let begun = least(trials, left);
        if is_fine { limits.refined(begun, left).1 } else { begun.1 }
    }

    /// Shapes and reversal of causes, if they are known.
    fn known(&self, causes: &[Candidate]) -> Option<Known> {
        self.known.lock().ok()?.get(&named(causes)).cloned()
    }

    fn keep(&self, shaped: &Shaped<'_>) {
        if let Ok(mut known) = self.known.lock() {
            known.insert(named(shaped.causes), (shaped.shapes.clone(), shaped.reversals.reversal));
        }
    }

    /// Chooses the shapes with the smallest residual on the fitted experiments.
    fn shape(&self, shaped: &mut Shaped<'_>, grids: &[Vec<f64>]) {
        let mut best = f64::INFINITY;
        for _ in 0..if shaped.causes.len() > 1 { ROUNDS } else { 1 } {
            for (i, grid) in grids.iter().enumerate().filter(|(_, grid)| grid.len() > 1) {
                let mut found = shaped.shapes[i];
                for &shape in grid {
                    shaped.shapes[i] = shape;
                    let left = self.left(shaped, None);
                    if left < best {
                        (best, found) = (left, shape);
                    }
                }
                shaped.shapes[i] = found;
            }
        }
    }

    /// Moves each shape to the least residual between its neighbours in the grid, by golden sections.
    fn sharpen(&self, shaped: &mut Shaped<'_>, grids: &[Vec<f64>]) {
        for (i, grid) in grids.iter().enumerate().filter(|(_, grid)| grid.len() > 1) {
            let own = shaped.shapes[i];
            let [below, above] =
                [grid.partition_point(|shape| *shape < own), grid.partition_point(|shape| *shape <= own)];
            let left = |shape: f64| {
                let mut trial = shaped.clone();
                trial.shapes[i] = shape;
                (self.left(&trial, None), shape)
            };
            let [mut low, mut high] =
                [below.saturating_sub(1), above.min(grid.len() - 1)].map(|neighbour| grid[neighbour]);
            let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
            let [mut a, mut b] = inner(low, high).map(left);
            for _ in 0..SECTIONS {
                if a.0 < b.0 {
                    (high, b) = (b.1, a);
                    a = left(inner(low, high)[0]);
                } else {
                    (low, a) = (a.1, b);
                    b = left(inner(low, high)[1]);
                }
            }
            let tried = [a, b, left(own)].into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            shaped.shapes[i] = tried.map_or(own, |(_, shape)| shape);
        }
    }
}

fn named(causes: &[Candidate]) -> Vec<(Site, Kind)> {
    causes.iter().map(|cause| (cause.site, cause.definition.kind)).collect()
}
