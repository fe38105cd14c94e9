//! How guides give way before they slide, found from the force around reversals.

use super::rows::{Rows, SHARPER};
use super::smooth::free;
use super::solve::solve;
use super::{Inverse, NOTHING, direction, mean, squares};
use crate::kinds::{At, Form};

/// Trial presliding distances, as shares of the stroke.
const WAYS: [f64; 6] = [1e-6, 1e-4, 2.5e-4, 6e-4, 1.5e-3, 4e-3];
/// Trial ratios of the damping of bristles to their stiffness, over `sqrt(distance mass / command)`. With
/// friction of a third of the largest command, 2 is a damping ratio of 0.6.
const AHEAD: [f64; 4] = [0.0, 1.0, 2.0, 4.0];
/// Ratio of two trials, at first and at last.
const STEP: f64 = 2.5;
const FINEST: f64 = 1.02;

/// How a guide gives way before it slides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Turn {
    /// Presliding distance, m.
    pub(crate) way_m: f64,
    /// Ratio of the damping to the stiffness of the bristles, s.
    pub(crate) ahead_s: f64,
    /// Index of the sharpness with which reversals are seen, in [`SHARPER`].
    pub(super) sharper: usize,
}

impl Turn {
    /// The neighbours in which the distance or the damping differs by a factor.
    fn near(self, by: f64) -> [Self; 4] {
        let way = |by: f64| Self { way_m: self.way_m * by, ..self };
        let ahead = |by: f64| Self { ahead_s: self.ahead_s * by, ..self };
        [way(1.0 / by), way(by), ahead(1.0 / by), ahead(by)]
    }
}

/// How the drive changes a command at its reversals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Changes {
    is_late: bool,
    has_band: bool,
}

impl Changes {
    pub(super) const ALL: [Self; 4] = [
        Self { is_late: false, has_band: false },
        Self { is_late: true, has_band: false },
        Self { is_late: false, has_band: true },
        Self { is_late: true, has_band: true },
    ];

    /// What causes of these forms change.
    pub(super) fn of(forms: impl Iterator<Item = Form>) -> Self {
        forms.fold(Self::default(), |found, form| match form {
            Form::Lag | Form::Delay => Self { is_late: true, ..found },
            Form::Deadband => Self { has_band: true, ..found },
            _ => found,
        })
    }

    /// Its place in [`Self::ALL`].
    pub(super) fn index(self) -> usize {
        usize::from(self.is_late) + 2 * usize::from(self.has_band)
    }
}

impl Inverse {
    /// Finds how guides give way, and sets the directions of friction in every view: first beside a drive that
    /// changes nothing, then near that beside others.
    pub(super) fn turn(&mut self) {
        let (mass, command, stroke) = (self.base.mass(), self.extent.command, self.extent.stroke());
        let of = |way_m: f64, sharper: usize| {
            let slow_s = (way_m * mass / command).sqrt();
            AHEAD.map(|times| Turn { way_m, ahead_s: times * slow_s, sharper })
        };
        let mut least = (f64::INFINITY, Turn::default());
        for sharper in 0..SHARPER.len() {
            let ways = WAYS.into_iter().flat_map(|share| of(share * stroke, sharper));
            let (_, best) = self.best_of_turns(Changes::default(), ways);
            let found = self.refined(Changes::default(), best);
            if found.0 < least.0 {
                least = found;
            }
        }
        let (_, plain) = least;
        for changes in Changes::ALL {
            let ways = [1.0 / STEP, 1.0, STEP].into_iter().flat_map(|by| of(by * plain.way_m, plain.sharper));
            let (_, best) = self.best_of_turns(changes, ways.chain([plain]));
            let (_, turn) = self.refined(changes, best);
            let view = &mut self.views[changes.index()];
            view.all().for_each(|rows| rows.turn_over(turn));
            view.turn = turn;
        }
    }

    /// The best trial near another one: steps shrink where no neighbour is better.
    fn refined(&mut self, changes: Changes, turn: Turn) -> (f64, Turn) {
        let mut best = (self.left_by(changes, turn), turn);
        let mut by = STEP.sqrt();
        while by > FINEST {
            let next = self.best_of_turns(changes, best.1.near(by));
            if next.0 < best.0 {
                best = next;
            } else {
                by = by.sqrt();
            }
        }
        best
    }

    /// The trial with the smallest residual of the fitted experiments.
    fn best_of_turns(&mut self, changes: Changes, turns: impl IntoIterator<Item = Turn>) -> (f64, Turn) {
        let tried = turns.into_iter().map(|turn| (self.left_by(changes, turn), turn));
        tried.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    }

    /// Mean square residual of the believed machine, with any friction, load, drag and mass. These would else
    /// be made up for by a wrong distance.
    fn left_by(&mut self, changes: Changes, turn: Turn) -> f64 {
        self.views[changes.index()].fitted.iter_mut().for_each(|rows| rows.turn_over(turn));
        let fitted = &self.views[changes.index()].fitted;
        let (mut terms, target) = self.balance(fitted, &NOTHING, None);
        let forces: [fn(At) -> f64; 4] =
            [|at| at.direction, |_| 1.0, |at| at.speed, |at| at.speed * at.speed.abs()];
        let mut add = |series: &dyn Fn(&Rows) -> Vec<f64>| {
            terms.push(free(fitted.iter().flat_map(|rows| rows.weighed(&series(rows))).collect()));
        };
        for force in forces {
            add(&|rows| rows.of_motion(0.0, force));
        }
        add(&|rows| rows.acceleration.clone());
        if changes.is_late {
            add(&|rows| rows.command_rate.clone());
        }
        if changes.has_band {
            add(&|rows| rows.smooth.iter().map(|u| direction(*u, self.extent.command)).collect());
        }
        solve(&terms, &target).map_or(f64::INFINITY, |x| mean(&squares(&terms, &x, &target)))
    }
}
