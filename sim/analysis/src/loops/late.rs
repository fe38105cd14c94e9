//! Sampled loops with many samples of dead time.
//!
//! In a lifted loop every sample of delay is a state, and the eigenvalues become too expensive. A whole
//! number of samples is exactly a factor `z^-n` of the loop broken at its controller. Here that factor is
//! kept beside a system with few states, so responses and margins are those of that system with a delay.
//!
//! A root of `1 + z^-n (H0 + k H1)` lies on the unit circle at gains for which `-(1 + z^-n H0) / (z^-n H1)`
//! is real. Between these gains the number of unstable roots is constant. At each it changes in the direction
//! in which the root crosses (D-decomposition; Neimark 1948).

use std::f64::consts::TAU;

use feeler_lti::{
    C64, Discrete, DiscreteStateSpace, LoopTransfer, StateSpace, TimeDomain, TransferEvaluator,
};
use nalgebra::{DMatrix, DVector};

use crate::error::AnalysisError;
use crate::limits::stability::{Band, Edge, GainBands};
use crate::loops::control_loop::ControlLoop;
use crate::loops::gain_key::with_gain;
use crate::loops::sampled_loop::SampledLoop;
use crate::machine::linearise::OutputRow;
use crate::machine::modes::{VibrationMode, modes};

/// From this number of whole samples onwards, a delay is kept apart from the loop. Fewer samples cost less as
/// states.
const LATE: usize = 12;
/// Largest number of samples beside a loop: the work grows with their square, and these take a minute.
const MOST_LATE: usize = 2000;
/// A delay within this share of a whole number of samples is that number.
const WHOLE: f64 = 1e-9;
/// Shares of half of the sampling rate at which the search measures a loop and checks that it is affine in
/// the gain.
const PROBES: [f64; 7] = [1e-3, 3.1e-3, 1.1e-2, 3.3e-2, 0.1, 0.31, 0.93];
/// Departure from a straight line within which a loop counts as affine in its gain.
const AFFINE: f64 = 1e-9;
/// A gain is real if its imaginary part is below this share of it; bisection leaves about 1e-12.
const REAL: f64 = 1e-6;
/// Bisections of a bracket of frequencies.
const HALVINGS: usize = 60;

/// A sampled response: `z^-samples` times a system.
#[derive(Clone, Debug, PartialEq)]
pub struct LateResponse {
    /// One input, one output.
    pub system: DiscreteStateSpace,
    /// Whole samples of delay beside the system.
    pub samples: usize,
}

impl LateResponse {
    /// The response as an open loop.
    ///
    /// # Errors
    /// [`AnalysisError::Lti`].
    pub fn transfer(&self) -> Result<LoopTransfer<Discrete>, AnalysisError> {
        Ok(LoopTransfer::late(&self.system, self.samples)?)
    }

    /// The response prepared for evaluation.
    pub(crate) fn evaluator(&self) -> Evaluator {
        Evaluator { response: TransferEvaluator::new(&self.system), samples: self.samples }
    }
}

/// A response of one input and one output, and samples of delay.
#[derive(Clone, Debug)]
pub(crate) struct Evaluator {
    response: TransferEvaluator,
    samples: usize,
}

impl Evaluator {
    /// A system without delay.
    pub(crate) fn prompt<T: TimeDomain>(system: &StateSpace<T>) -> Self {
        Self { response: TransferEvaluator::new(system), samples: 0 }
    }

    /// The value at a point of the s or z plane.
    pub(crate) fn at(&self, point: C64) -> Result<C64, AnalysisError> {
        let value = self.response.at(point)?[(0, 0)];
        Ok(if self.samples == 0 { value } else { value * point.powf(-(self.samples as f64)) })
    }
}

impl ControlLoop {
    /// The loop broken at the output of one controller, with the others closed: from that output to the
    /// negated response of the controller.
    ///
    /// # Errors
    /// Those of [`SampledLoop::open_loop`].
    pub fn open_loop(&self, controller: usize) -> Result<LateResponse, AnalysisError> {
        let (short, samples) = self.without_dead_time(controller, true)?;
        Ok(LateResponse { system: SampledLoop::new(&short)?.open_loop(controller)?, samples })
    }

    /// From the held output of one controller to any signal, as that controller would sample it just before
    /// it acts; the other controllers are closed.
    ///
    /// # Errors
    /// Those of [`SampledLoop::open_loop`].
    pub(crate) fn response_to(
        &self,
        controller: usize,
        mut output: OutputRow,
    ) -> Result<LateResponse, AnalysisError> {
        let (short, mut samples) = self.without_dead_time(controller, false)?;
        let period_s = self.controllers()[controller].spec.period_s;
        if whole_samples(output.delay_s, period_s) >= LATE {
            samples += cut(&mut output.delay_s, period_s);
        }
        Ok(LateResponse { system: SampledLoop::response_to(&short, controller, output)?, samples })
    }

    /// The same loop without its whole samples of delay, and their number. The delay lies between the output
    /// of a controller and the plant, and in its sensor if that is part of the loop. A few samples stay in
    /// the loop. A delay that another controller shares stays, too.
    fn without_dead_time(
        &self,
        controller: usize,
        with_sensor: bool,
    ) -> Result<(Self, usize), AnalysisError> {
        let own = &self.controllers()[controller];
        let (period_s, drive) = (own.spec.period_s, own.drive);
        let others = || {
            self.controllers().iter().enumerate().filter(|(i, _)| *i != controller).map(|(_, other)| other)
        };
        // A target reaches the drive through the servo's loop, which has a delay of its own.
        let aims = own.aims_at.is_some();
        let own_drive = aims || others().all(|other| other.drive != drive);
        // If the law also uses a second sensor, this sensor's delay is not a factor of the loop.
        let alone = |sensor: &usize| {
            with_sensor
                && others().all(|other| other.reading != Some(*sensor) && other.motion != Some(*sensor))
        };
        let sensor = own.reading.xor(own.motion).filter(alone);
        let of_drive = if own_drive { self.output_delay_s(own) - own.spec.delay_s } else { 0.0 };
        let of_sensor = sensor.map_or(0.0, |sensor| self.assembly().sensors[sensor].delay);
        let count: usize = [own.spec.delay_s, of_drive, of_sensor]
            .map(|delay_s| whole_samples(delay_s, period_s))
            .iter()
            .sum();
        if count < LATE {
            return Ok((self.clone(), 0));
        }
        let mut samples = 0;
        let short = self.altered(|assembly, controllers| {
            samples += cut(&mut controllers[controller].spec.delay_s, period_s);
            if own_drive {
                let drive = &mut assembly.drives[drive];
                let sampling = drive.servo.as_mut().and_then(|servo| servo.sampling.as_mut());
                let target = sampling.filter(|_| aims).map(|sampling| &mut sampling.target.delay);
                samples += cut(target.unwrap_or(&mut drive.delay), period_s);
            }
            if let Some(sensor) = sensor {
                samples += cut(&mut assembly.sensors[sensor].delay, period_s);
            }
        })?;
        Ok((short, samples))
    }

    /// Stable values, from zero onwards, of a gain times a sign in a loop with much dead time. `None` if the
    /// dead time is not a factor of the loop, or if the loop is not affine in the gain. A delay of more than
    /// [`MOST_LATE`] samples is an error.
    pub(crate) fn late_bands(
        &self,
        controller: usize,
        gain: &str,
        sign: f64,
    ) -> Result<Option<GainBands>, AnalysisError> {
        let (short, samples) = self.without_dead_time(controller, true)?;
        if samples > MOST_LATE {
            return Err(AnalysisError::LongDelay {
                stored: samples,
                most: MOST_LATE,
                common_s: own_period_s(&short, controller),
            });
        }
        if samples == 0
            || (SampledLoop::new(&short)?.common_period_s() / own_period_s(&short, controller) - 1.0).abs()
                > WHOLE
        {
            return Ok(None);
        }
        let search = LateSearch::new(short, samples, controller, gain, sign)?;
        search.map(|search| search.bands()).transpose()
    }
}

fn own_period_s(whole: &ControlLoop, controller: usize) -> f64 {
    whole.controllers()[controller].spec.period_s
}

fn whole_samples(delay_s: f64, period_s: f64) -> usize {
    (delay_s / period_s * (1.0 + WHOLE)).floor() as usize
}

/// Reduces a delay to its fraction of a sample and returns the number of whole samples.
fn cut(delay_s: &mut f64, period_s: f64) -> usize {
    let samples = whole_samples(*delay_s, period_s);
    let left_s = *delay_s - samples as f64 * period_s;
    *delay_s = if left_s > WHOLE * *delay_s { left_s } else { 0.0 };
    samples
}

/// A gain at which a root lies on the unit circle.
struct Crossing {
    gain: f64,
    w: f64,
    /// Increase of the number of unstable roots as the gain rises through this value.
    change: isize,
}

/// The search for stable gains of a loop with dead time, in units of a gain that has a noticeable effect.
struct LateSearch {
    whole: ControlLoop,
    samples: usize,
    controller: usize,
    gain: String,
    unit: f64,
    period_s: f64,
    /// The loop without dead time at one and at two units of the gain.
    ends: Vec<TransferEvaluator>,
    frequencies: Vec<f64>,
    modes: Vec<VibrationMode>,
}

impl LateSearch {
    fn new(
        whole: ControlLoop,
        samples: usize,
        controller: usize,
        gain: &str,
        sign: f64,
    ) -> Result<Option<Self>, AnalysisError> {
        let period_s = own_period_s(&whole, controller);
        let own = modes(whole.plant())?;
        let mut search = Self {
            whole,
            samples,
            controller,
            gain: gain.into(),
            unit: sign,
            period_s,
            ends: Vec::new(),
            frequencies: Vec::new(),
            modes: own,
        };
        let probes = PROBES.map(|share| C64::cis(share * std::f64::consts::PI));
        let values = |search: &Self, gain: f64| -> Result<Vec<C64>, AnalysisError> {
            let at = TransferEvaluator::new(&search.open(gain)?);
            probes.iter().map(|z| Ok(at.at(*z)?[(0, 0)])).collect()
        };
        let (one, two) = (values(&search, 1.0)?, values(&search, 2.0)?);
        let mut sizes: Vec<f64> = one.iter().zip(&two).map(|(a, b)| (b - a).norm()).collect();
        sizes.sort_by(f64::total_cmp);
        let size = sizes[sizes.len() / 2];
        if !(size.is_finite() && size > 0.0) {
            return Ok(None);
        }
        search.unit = sign / size;
        let [one, two, three] = [values(&search, 1.0)?, values(&search, 2.0)?, values(&search, 3.0)?];
        let bent = |i: usize| {
            (one[i] - two[i] * 2.0 + three[i]).norm() > AFFINE * three[i].norm().max(one[i].norm())
        };
        if (0..probes.len()).any(bent) {
            return Ok(None);
        }
        let systems = [search.open(1.0)?, search.open(2.0)?];
        let mut frequencies = vec![0.0, std::f64::consts::PI / period_s];
        for system in &systems {
            let points = LoopTransfer::late(system, samples)?.sampled(1.0)?;
            frequencies.extend(points.iter().filter(|point| point.s.re.abs() <= 0.0).map(|point| point.s.im));
        }
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        search.frequencies = frequencies;
        search.ends = systems.iter().map(TransferEvaluator::new).collect();
        Ok(Some(search))
    }

    /// The loop without dead time at a gain.
    fn open(&self, gain: f64) -> Result<DiscreteStateSpace, AnalysisError> {
        let mut whole = self.whole.clone();
        let spec = with_gain(&whole.controllers()[self.controller].spec, &self.gain, self.unit * gain)?;
        whole.set_spec(self.controller, spec);
        SampledLoop::new(&whole)?.open_loop(self.controller)
    }

    /// The complex gain for which a root lies at this frequency; only real values are gains. NaN at a pole of
    /// the loop.
    fn gain_at(&self, w: f64) -> C64 {
        let z = C64::cis(w * self.period_s);
        let [Ok(one), Ok(two)] = [0, 1].map(|i| self.ends[i].at(z)) else {
            return C64::new(f64::NAN, f64::NAN);
        };
        let (one, two) = (one[(0, 0)], two[(0, 0)]);
        let late = C64::cis(w * self.period_s * self.samples as f64);
        -(late + one * 2.0 - two) / (two - one)
    }

    fn crossings(&self) -> Result<Vec<Crossing>, AnalysisError> {
        let mut found = Vec::new();
        let real = |gain: C64| gain.re > 0.0 && gain.re.is_finite() && gain.im.abs() <= REAL * gain.re;
        let ends = [self.frequencies[0], self.frequencies[self.frequencies.len() - 1]];
        for w in ends {
            let gain = self.gain_at(w);
            if real(gain) {
                found.push(Crossing { gain: gain.re, w, change: self.outwards(w, gain.re)? });
            }
        }
        let mut before = (ends[0], self.gain_at(ends[0]));
        for &w in &self.frequencies[1..] {
            let here = (w, self.gain_at(w));
            if (before.1.im > 0.0) != (here.1.im > 0.0) && before.1.im.abs() > 0.0 && here.1.im.abs() > 0.0 {
                let (mut low, mut high) = (before.0, here.0);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    if (self.gain_at(middle).im > 0.0) == (before.1.im > 0.0) {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let w = 0.5 * (low + high);
                let gain = self.gain_at(w);
                if real(gain) && !ends.contains(&w) {
                    found.push(Crossing { gain: gain.re, w, change: 2 * self.outwards(w, gain.re)? });
                }
            }
            before = here;
        }
        found.sort_by(|a, b| a.gain.total_cmp(&b.gain));
        Ok(found)
    }

    /// 1 if the root at this frequency leaves the unit circle as the gain rises, -1 if it enters.
    fn outwards(&self, w: f64, gain: f64) -> Result<isize, AnalysisError> {
        let z = C64::cis(w * self.period_s);
        let [one, two] = [self.ends[0].with_derivative(z)?, self.ends[1].with_derivative(z)?];
        let at = |pair: fn(&(DMatrix<C64>, DMatrix<C64>)) -> C64| {
            let (one, two) = (pair(&one), pair(&two));
            (one * 2.0 - two + (two - one) * gain, two - one)
        };
        let ((value, slope), (derivative, _)) = (at(|p| p.0[(0, 0)]), at(|p| p.1[(0, 0)]));
        // The derivative of z^n + H0 + k H1, which has the same roots on the unit circle.
        let late = z.powf(self.samples as f64 - 1.0) * self.samples as f64;
        debug_assert!((z.powf(self.samples as f64) + value).norm() <= 1e-3 * (1.0 + value.norm()), "no root");
        let moved = -slope / (late + derivative);
        Ok(if (z.conj() * moved).re > 0.0 { 1 } else { -1 })
    }

    fn unstable(&self, gain: f64) -> Result<isize, AnalysisError> {
        Ok(LoopTransfer::late(&self.open(gain)?, self.samples)?
            .closed_loop_unstable_poles(1.0)?
            .cast_signed())
    }

    fn bands(&self) -> Result<GainBands, AnalysisError> {
        let crossings = self.crossings()?;
        let mut unstable = self.unstable(crossings.first().map_or(1.0, |first| 0.5 * first.gain))?;
        let mut bands = Vec::new();
        let mut begun: Option<Option<Edge>> = (unstable == 0).then_some(None);
        for (i, crossing) in crossings.iter().enumerate() {
            let mut after = unstable + crossing.change;
            if after <= 0 {
                // Whether the loop is stable matters most, so unstable roots are counted anew.
                let next = crossings
                    .get(i + 1)
                    .map_or(2.0 * crossing.gain, |next| 0.5 * (crossing.gain + next.gain));
                after = self.unstable(next)?;
            }
            if unstable == 0 && after > 0 {
                let lower = begun.take().flatten();
                bands.push(Band { lower, upper: Some(self.edge(crossing)?) });
            } else if unstable > 0 && after == 0 {
                begun = Some(Some(self.edge(crossing)?));
            }
            unstable = after;
        }
        bands.extend(begun.map(|lower| Band { lower, upper: None }));
        Ok(GainBands { bands })
    }

    fn edge(&self, crossing: &Crossing) -> Result<Edge, AnalysisError> {
        let open = self.open(crossing.gain)?;
        let sampled = SampledLoop::new(&self.whole)?;
        let expand = sampled.expand();
        let plant = DMatrix::identity(expand.ncols(), open.states());
        let nothing = DMatrix::zeros(expand.ncols(), 1);
        let moves = StateSpace::discrete(open.a().clone(), open.b().clone(), plant, nothing, self.period_s)?;
        let motion: DVector<C64> = moves.at(C64::cis(crossing.w * self.period_s))?.column(0).into_owned();
        let mode = self.whole.most_alike(&self.modes, &motion, expand);
        Ok(Edge { gain: crossing.gain * self.unit.abs(), frequency_hz: crossing.w / TAU, mode })
    }
}
