//! The variants of a sweep, each computed from its number.

use feeler_control::Stream;

use super::permutation::Permutation;
use super::sobol::sobol;
use feeler_files::{Sampling, Setting, SweepAxis, SweepFile};

/// A point on the lattice of an adaptive sweep: one index per axis.
pub(super) type Node = Vec<u64>;

/// Some variants, by number.
#[derive(Debug)]
pub(super) enum Points<'a> {
    Plan(&'a SweepFile),
    /// These points of a lattice with these numbers of values per axis.
    Nodes(&'a SweepFile, Vec<Node>, Vec<u64>),
}

impl Points<'_> {
    pub(super) fn count(&self) -> u64 {
        match self {
            Self::Plan(sweep) => sweep.samples,
            Self::Nodes(_, nodes, _) => nodes.len() as u64,
        }
    }

    /// The value of each axis.
    pub(super) fn settings(&self, index: u64) -> Vec<Setting> {
        match self {
            Self::Plan(sweep) => planned(sweep, index),
            Self::Nodes(sweep, nodes, counts) => {
                let value = |((axis, &i), &count): ((&SweepAxis, &u64), &u64)| on_lattice(axis, i, count);
                sweep.axes.values().zip(&nodes[index as usize]).zip(counts).map(value).collect()
            }
        }
    }
}

fn planned(sweep: &SweepFile, index: u64) -> Vec<Setting> {
    if sweep.sampling == Sampling::Grid {
        return on_grid(sweep, index);
    }
    let share = |(dimension, key): (usize, &String)| {
        let stream = Stream::new(sweep.seed, &format!("axes.{key}"));
        match sweep.sampling {
            Sampling::LatinHypercube => {
                let permutation = Permutation::new(sweep.samples, shift(&stream));
                (permutation.at(index) as f64 + stream.uniform_at(index)) / sweep.samples as f64
            }
            Sampling::Sobol => {
                f64::from(sobol(dimension, index as u32) ^ (shift(&stream) >> 32) as u32) * 0.5_f64.powi(32)
            }
            Sampling::Grid | Sampling::Random => stream.uniform_at(index),
        }
    };
    sweep
        .axes
        .keys()
        .enumerate()
        .map(share)
        .zip(sweep.axes.values())
        .map(|(share, axis)| axis.at(share))
        .collect()
}

/// A number for an axis as a whole; no variant has this index.
fn shift(stream: &Stream) -> u64 {
    (stream.uniform_at(u64::from(u32::MAX) << 16) * 2_f64.powi(64)) as u64
}

/// The last axis runs fastest.
fn on_grid(sweep: &SweepFile, index: u64) -> Vec<Setting> {
    let mut rest = index;
    let mut settings: Vec<Setting> = (sweep.axes.values().rev())
        .map(|axis| {
            let count = axis.count().unwrap_or(1);
            let setting = axis.point(rest % count);
            rest /= count;
            setting
        })
        .collect();
    settings.reverse();
    settings
}

fn on_lattice(axis: &SweepAxis, index: u64, count: u64) -> Setting {
    match index {
        0 => axis.point(0),
        last if last + 1 == count => axis.point(axis.count().unwrap_or(1) - 1),
        between => axis.at(between as f64 / (count - 1) as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_files::Keep;

    fn sweep(sampling: Sampling, samples: u64) -> SweepFile {
        let axes = [
            ("a", SweepAxis::Uniform { from: 0.0, to: 1.0 }),
            ("b", SweepAxis::LogUniform { from: 1.0, to: 100.0 }),
        ];
        SweepFile {
            name: String::new(),
            about: String::new(),
            scenario: String::new().into(),
            units: axes.iter().map(|(key, _)| ((*key).to_owned(), String::new())).collect(),
            axes: axes.into_iter().map(|(key, axis)| (key.to_owned(), axis)).collect(),
            sampling,
            samples,
            seed: 7,
            keep: Keep { outcome: true, traces: false, tail: 0 },
            refine: None,
        }
    }

    fn numbers(sweep: &SweepFile) -> Vec<[f64; 2]> {
        let number = |setting: &Setting| if let Setting::Number(value) = setting { *value } else { f64::NAN };
        (0..sweep.samples).map(|i| planned(sweep, i)).map(|s| [number(&s[0]), number(&s[1])]).collect()
    }

    #[test]
    fn truth_a_grid_runs_through_every_combination() {
        let mut grid = sweep(Sampling::Grid, 6);
        grid.axes["a"] = SweepAxis::Linear { from: 0.0, to: 1.0, points: 2 };
        grid.axes["b"] = SweepAxis::Log { from: 1.0, to: 100.0, points: 3 };
        let expected = [[0.0, 1.0], [0.0, 10.0], [0.0, 100.0], [1.0, 1.0], [1.0, 10.0], [1.0, 100.0]];
        for (found, expected) in numbers(&grid).iter().zip(expected) {
            assert!(
                (found[0] - expected[0]).abs() < 1e-12 && (found[1] / expected[1] - 1.0).abs() < 1e-12,
                "{found:?}"
            );
        }
    }

    /// 500 draws of a uniform number: mean 1/2, standard error 0.013.
    #[test]
    fn truth_draws_are_uniform_and_axes_independent() {
        for sampling in [Sampling::Random, Sampling::LatinHypercube, Sampling::Sobol] {
            let drawn = numbers(&sweep(sampling, 500));
            let mean = drawn.iter().map(|point| point[0]).sum::<f64>() / 500.0;
            let mean_log = drawn.iter().map(|point| point[1].log10() / 2.0).sum::<f64>() / 500.0;
            let product =
                drawn.iter().map(|point| (point[0] - 0.5) * (point[1].log10() / 2.0 - 0.5)).sum::<f64>()
                    / 500.0;
            assert!(
                (mean - 0.5).abs() < 0.04 && (mean_log - 0.5).abs() < 0.04,
                "{sampling:?}: {mean} {mean_log}"
            );
            assert!(product.abs() < 0.012, "{sampling:?}: {product}");
        }
    }

    #[test]
    fn truth_a_latin_hypercube_draws_once_from_each_slice() {
        let drawn = numbers(&sweep(Sampling::LatinHypercube, 100));
        let mut slices: Vec<usize> = drawn.iter().map(|point| (point[0] * 100.0) as usize).collect();
        slices.sort_unstable();
        assert_eq!(slices, (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn prop_another_seed_draws_other_points() {
        let other = SweepFile { seed: 8, ..sweep(Sampling::Sobol, 16) };
        assert_ne!(numbers(&sweep(Sampling::Sobol, 16)), numbers(&other));
    }
}
