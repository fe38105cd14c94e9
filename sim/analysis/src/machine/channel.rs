//! One input and one output of a machine: a state space without idle states, and the delay beside it.

use feeler_lti::{C64, Continuous, LtiError, StateSpace, ZeroPoleGain, frequencies_hz};
use nalgebra::DMatrix;

/// Sums of stiffnesses below this share of their parts cancel: nothing holds these bodies in place.
const CANCELS: f64 = 1e-13;

/// From a command to a signal: a linear system and an exact delay.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseChannel {
    /// One input, one output.
    pub system: StateSpace,
    /// Names of the states, as in `motor.position`. Bodies that nothing holds in place are described by
    /// distances.
    pub states: Vec<String>,
    /// Delay of drive and sensor together, s.
    pub delay_s: f64,
}

impl ResponseChannel {
    /// Poles, rad/s.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn poles(&self) -> Result<Vec<C64>, LtiError> {
        self.system.poles()
    }

    /// Zeros, rad/s; `None` if the output does not depend on the input at all.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn zeros(&self) -> Result<Vec<C64>, LtiError> {
        match self.system.zeros() {
            Err(LtiError::Degenerate) => Ok(Vec::new()),
            other => other,
        }
    }

    /// Moduli |s| / 2 pi of the poles, Hz, conjugate pairs once.
    ///
    /// # Errors
    /// As [`Self::poles`].
    pub fn poles_hz(&self) -> Result<Vec<f64>, LtiError> {
        Ok(frequencies_hz(Continuous, &self.poles()?))
    }

    /// Moduli |s| / 2 pi of the zeros, Hz, conjugate pairs once.
    ///
    /// # Errors
    /// As [`Self::zeros`].
    pub fn zeros_hz(&self) -> Result<Vec<f64>, LtiError> {
        Ok(frequencies_hz(Continuous, &self.zeros()?))
    }

    /// The factored form `gain (s - zero) ... / (s - pole) ...`; `None` if the output does not depend on
    /// the input.
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn zero_pole_gain(&self) -> Result<Option<ZeroPoleGain>, LtiError> {
        match self.system.zero_pole_gain() {
            Err(LtiError::Degenerate) => Ok(None),
            other => other.map(Some),
        }
    }

    /// Frequency response with the exact delay.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn frequency_response(&self, frequencies_hz: &[f64]) -> Result<Vec<C64>, LtiError> {
        let response = self.system.delayed_frequency_response(frequencies_hz, self.delay_s)?;
        Ok(response.into_iter().map(|value| value[(0, 0)]).collect())
    }
}

/// A system with fewer states, and the map from these to the original states.
#[derive(Clone, Debug)]
pub(crate) struct Reduction {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    /// Original states from those kept.
    pub(crate) expand: DMatrix<f64>,
    /// The states kept. A state may be its distance from another state, whose index is then the second entry.
    pub(crate) kept: Vec<(usize, Option<usize>)>,
}

impl Reduction {
    /// Names of the states, from the names of the original ones.
    pub(crate) fn names(&self, of_all: &[String]) -> Vec<String> {
        let name = |(state, from): &(usize, Option<usize>)| match from {
            Some(from) => format!("{} - {}", of_all[*state], of_all[*from]),
            None => of_all[*state].clone(),
        };
        self.kept.iter().map(name).collect()
    }
}

/// Replaces the positions of bodies that nothing holds by their distances from the first of them. Then keeps
/// the states that an input reaches and an output observes. The first `2 coordinates` states are positions
/// and speeds.
pub(crate) fn reduce(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, coordinates: usize) -> Reduction {
    let whole = relative_coordinates(a, b, c, coordinates);
    let n = whole.a.nrows();
    let reached = closure(n, |i| whole.b.row(i).amax() > 0.0, |from, to| whole.a[(to, from)].abs() > 0.0);
    let seen = closure(n, |j| whole.c.column(j).amax() > 0.0, |from, to| whole.a[(from, to)].abs() > 0.0);
    let kept: Vec<usize> = (0..n).filter(|&i| reached[i] && seen[i]).collect();
    Reduction {
        a: whole.a.select_rows(&kept).select_columns(&kept),
        b: whole.b.select_rows(&kept),
        c: whole.c.select_columns(&kept),
        expand: whole.expand.select_columns(&kept),
        kept: kept.iter().map(|&i| whole.kept[i]).collect(),
    }
}

fn relative_coordinates(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, nc: usize) -> Reduction {
    let (mut a, mut b, mut c) = (a.clone(), b.clone(), c.clone());
    let mut expand = DMatrix::identity(a.nrows(), a.nrows());
    let mut kept: Vec<(usize, Option<usize>)> = (0..a.nrows()).map(|i| (i, None)).collect();
    for group in spring_groups(&a, nc) {
        let sum = |m: &DMatrix<f64>, row: usize| group.iter().map(|&g| m[(row, g)]).sum::<f64>();
        let size = |m: &DMatrix<f64>, row: usize| group.iter().map(|&g| m[(row, g)].abs()).sum::<f64>();
        let free = (nc..2 * nc).all(|row| sum(&a, row).abs() <= CANCELS * size(&a, row));
        let (Some(&lead), true) = (group.first(), free && group.len() > 1) else { continue };
        let blind = |m: &DMatrix<f64>, row: usize| sum(m, row).abs() <= CANCELS * size(m, row);
        // Drives and filters, too, may depend only on distances. Rounding would otherwise couple the drift to
        // the loop.
        let blind_states: Vec<usize> = (nc..a.nrows()).filter(|&row| blind(&a, row)).collect();
        let blind_outputs: Vec<usize> = (0..c.nrows()).filter(|&row| blind(&c, row)).collect();
        for &g in &group[1..] {
            kept[g].1 = Some(lead);
            for m in [&mut a, &mut c, &mut expand] {
                let column = m.column(g).into_owned();
                m.column_mut(lead).axpy(1.0, &column, 1.0);
            }
        }
        for row in blind_states {
            a[(row, lead)] = 0.0;
        }
        for row in blind_outputs {
            c[(row, lead)] = 0.0;
        }
        for m in [&mut a, &mut b] {
            let of_lead = m.row(lead).into_owned();
            for &g in &group[1..] {
                let mut row = m.row_mut(g);
                row -= &of_lead;
            }
        }
    }
    Reduction { a, b, c, expand, kept }
}

/// Groups of coordinates that springs join.
fn spring_groups(a: &DMatrix<f64>, nc: usize) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..nc).collect();
    for _ in 0..nc {
        for i in 0..nc {
            for j in 0..nc {
                if i != j && a[(nc + i, j)].abs() > 0.0 {
                    let low = group[i].min(group[j]);
                    group[i] = low;
                    group[j] = low;
                }
            }
        }
    }
    (0..nc)
        .map(|lead| (0..nc).filter(|&g| group[g] == lead).collect::<Vec<_>>())
        .filter(|members| !members.is_empty())
        .collect()
}

fn closure(n: usize, from: impl Fn(usize) -> bool, leads: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    let mut member: Vec<bool> = (0..n).map(from).collect();
    let mut open: Vec<usize> = (0..n).filter(|&i| member[i]).collect();
    while let Some(i) = open.pop() {
        let next: Vec<usize> = (0..n).filter(|&j| !member[j] && leads(i, j)).collect();
        for j in next {
            member[j] = true;
            open.push(j);
        }
    }
    member
}
