//! The paper's figures, from the reference axis (Figs. 4 to 14 and 18) and from the machine with the measured
//! landmarks (Figs. 15 to 17).

use std::f64::consts::TAU;

use feeler_analysis::frf::{Excitation, FrfExperiment, NoiseMethod};
use feeler_analysis::{ContinuousLoop, ControlLoop, LinearMachine, ResponseChannel, View};
use feeler_control::ForceGains;
use feeler_lti::spectral::LocalPolynomialSettings;
use feeler_lti::{C64, root_locus, unwrapped_phase_rad};
use feeler_plant::description::{Engagement, Quantity, SignalName};

use crate::error::ValidationError;
use crate::landmarks;
use crate::paper::{self, IDEAL, PaperModel, SOURCE, gain_of};
use crate::svg::{Figure, FigureAxis, FigureCurve, Mark, Panel};

const BLUE: &str = "#1f5fa8";
const RED: &str = "#c0392b";
const GREY: &str = "#777";
/// Length of the simulated experiments of Figs. 15 to 17, s.
const EXPERIMENT_S: f64 = 60.0;
/// Hold of their command, s: so short that it has almost no phase.
const HOLD_S: f64 = 2e-4;
/// Band of Figs. 15 to 17, Hz.
const BAND_HZ: (f64, f64) = (2.0, 100.0);
/// Ratio of the frequencies of neighbouring dots: about a hundred in the band.
const DOT_SPACING: f64 = 1.04;

/// A pole and a zero closer than this share of a picture's half height are drawn again, magnified.
const CLOSE: f64 = 0.02;
/// Width over height of a panel, so that a magnified pair is drawn to scale.
const PANEL_SHAPE: f64 = 2.1;

/// Every figure, in the paper's order.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn figures() -> Result<Vec<Figure>, ValidationError> {
    let source = "driven by the velocity source of Fig. 2";
    let ideal = "driven by an ideal force";
    let pairs = [
        (
            PaperModel::Rigid,
            SOURCE,
            "fig04",
            "fig05",
            "rigid-body model coupled with the actuator (Fig. 3)",
            source,
        ),
        (PaperModel::Flexible, IDEAL, "fig07", "fig08", "flexible robot (Fig. 6)", ideal),
        (PaperModel::Base, IDEAL, "fig10", "fig11", "robot on a base that gives way (Fig. 9)", ideal),
        (PaperModel::Workpiece, IDEAL, "fig13", "fig14", "robot with workpiece dynamics (Fig. 12)", ideal),
    ];
    let mut all = Vec::new();
    for (model, drive, bode, locus, name, how) in pairs {
        let axis = paper::PaperAxis::reference(model, drive);
        let damped =
            |factor: f64| paper::PaperAxis { base: axis.base.map(|(m, k, b)| (m, k, factor * b)), ..axis };
        let mut axes = vec![(String::new(), axis)];
        if model == PaperModel::Base {
            axes = vec![("base damping as given".into(), axis), ("base damping times 5".into(), damped(5.0))];
        }
        all.push(bode_figure(
            bode,
            &format!(
                "Fig. {}. Open-loop frequency response of the {name}, {how}: command to sensed force.",
                number(bode)
            ),
            &axes,
        )?);
        let gap = if model == PaperModel::Workpiece { " Gains from 11.7 to 40.7 are too large." } else { "" };
        all.push(locus_figure(
            locus,
            &format!(
                "Fig. {}. Root locus of the {name} under explicit force control, {how}; poles at gain zero \
                 are crosses, zeros circles.{gap}",
                number(locus)
            ),
            &axis,
        )?);
    }
    all.extend(measured_figures()?);
    let (three, rigid) = (
        paper::PaperAxis::reference(PaperModel::AllThree, SOURCE),
        paper::PaperAxis::reference(PaperModel::Rigid, SOURCE),
    );
    let mut last = bode_figure(
        "fig18",
        "Fig. 18. Three dynamic problems: open-loop phase of the machine with base, transmission and \
         workpiece flexibility, driven by the velocity \
         source, and of its rigid body (dashed). The base's dip near 11 Hz is colocated, the drop at the \
         transmission's mode near 104 Hz noncolocated.",
        &[("all three".into(), three), ("rigid body and actuator".into(), rigid)],
    )?;
    last.panels.remove(0);
    last.panels[0].curves[1].mark = Mark::Dashed;
    all.push(last);
    Ok(all)
}

/// The number in a figure's name.
fn number(name: &str) -> &str {
    name.trim_start_matches("fig").trim_start_matches('0')
}

fn channel_of(axis: &paper::PaperAxis) -> Result<ResponseChannel, ValidationError> {
    let plant = LinearMachine::new(&axis.machine("axis"), &View::CLAMPED)?;
    Ok(plant.channel(
        &SignalName::new("drive", Quantity::Command),
        &SignalName::new("tool", Quantity::SpringForce),
    )?)
}

/// Decibels and degrees of a response.
fn bode_curves(
    name: &str,
    frequencies: &[f64],
    response: &[C64],
    mark: Mark,
    colour: &'static str,
) -> [FigureCurve; 2] {
    let decibels = response.iter().map(|g| 20.0 * g.norm().log10());
    let degrees = unwrapped_phase_rad(response).into_iter().map(f64::to_degrees);
    let curve = |values: Vec<f64>, name: &str| FigureCurve {
        name: name.into(),
        points: frequencies.iter().copied().zip(values).collect(),
        mark,
        colour,
    };
    [curve(decibels.collect(), name), curve(degrees.collect(), name)]
}

/// A panel that contains its curves, its range rounded outwards to whole steps.
fn panel(x: FigureAxis, label: &str, step: f64, curves: Vec<FigureCurve>) -> Panel {
    let values = || curves.iter().flat_map(|c| &c.points).map(|p| p.1).filter(|v| v.is_finite());
    let low = (values().fold(f64::INFINITY, f64::min) / step).floor() * step;
    let high = (values().fold(f64::NEG_INFINITY, f64::max) / step).ceil() * step;
    Panel { x, y: FigureAxis::linear(label, (low, high.max(low + step))), curves }
}

fn bode_panels(
    band: (f64, f64),
    unit: &str,
    magnitudes: Vec<FigureCurve>,
    phases: Vec<FigureCurve>,
) -> Vec<Panel> {
    let x = || FigureAxis::logarithmic("Frequency (Hz)", band);
    vec![
        panel(x(), &format!("Magnitude (dB re 1 {unit})"), 20.0, magnitudes),
        panel(x(), "Phase (\u{b0})", 90.0, phases),
    ]
}

fn bode_figure(
    name: &str,
    caption: &str,
    axes: &[(String, paper::PaperAxis)],
) -> Result<Figure, ValidationError> {
    let band = (1.0, 1000.0);
    let frequencies: Vec<f64> = (0..=1500).map(|i| 10_f64.powf(3.0 * f64::from(i) / 1500.0)).collect();
    let (mut magnitudes, mut phases) = (Vec::new(), Vec::new());
    for ((label, axis), colour) in axes.iter().zip([BLUE, RED]) {
        let response = channel_of(axis)?.frequency_response(&frequencies)?;
        let [magnitude, phase] = bode_curves(label, &frequencies, &response, Mark::Line, colour);
        magnitudes.push(magnitude);
        phases.push(phase);
    }
    let unit = if axes[0].1.drive == IDEAL { "N/N" } else { "N s/m" };
    Ok(Figure {
        name: name.into(),
        caption: caption.into(),
        panels: bode_panels(band, unit, magnitudes, phases),
    })
}

fn locus_figure(name: &str, caption: &str, axis: &paper::PaperAxis) -> Result<Figure, ValidationError> {
    let scenario = axis.force_loop(ForceGains { kp: 1.0, ..ForceGains::default() }, 1e-3, 0.0);
    let whole = ControlLoop::new(&scenario, &View::CLAMPED)?;
    let continuous = ContinuousLoop::new(&whole)?;
    let gain = gain_of(&whole);
    let (one, two) = (continuous.closed_loop_with(0, gain, 1.0)?, continuous.closed_loop_with(0, gain, 2.0)?);
    // Up to a hundred times the gain at which the loop becomes unstable, or a hundred if it never does.
    let bands = whole.continuous_bands(gain)?;
    let first = bands.first_upper();
    let top = if first.is_finite() { 100.0 * first } else { 100.0 };
    let gains: Vec<f64> = std::iter::once(0.0)
        .chain((0..=600).map(|i| top * 1e-5_f64.powf(1.0 - f64::from(i) / 600.0)))
        .collect();
    let locus = root_locus(|k| &one + (&two - &one) * (k - 1.0), &gains)?;
    let point = |s: &C64| (s.re, s.im / TAU);
    let mut curves: Vec<FigureCurve> = (locus.branches.iter())
        .map(|branch| FigureCurve {
            name: String::new(),
            points: branch.iter().map(point).collect(),
            mark: Mark::Line,
            colour: BLUE,
        })
        .collect();
    let channel = channel_of(axis)?;
    let (poles, zeros) = (channel.poles()?, channel.zeros()?);
    curves.push(FigureCurve {
        name: String::new(),
        points: poles.iter().map(point).collect(),
        mark: Mark::Cross,
        colour: RED,
    });
    curves.push(FigureCurve {
        name: String::new(),
        points: zeros.iter().map(point).collect(),
        mark: Mark::Circle,
        colour: RED,
    });
    // The view contains all poles and complex zeros, and that part of the locus.
    let roots = || poles.iter().chain(zeros.iter().filter(|z| z.im.abs() > 0.0));
    let crossing = bands
        .bands
        .iter()
        .flat_map(|band| [&band.lower, &band.upper])
        .flatten()
        .map(|edge| edge.frequency_hz)
        .fold(0.0, f64::max);
    let high = (1.6 * roots().map(|s| s.im.abs() / TAU).fold(0.0, f64::max)).max(1.8 * crossing);
    let left = 1.3 * roots().map(|s| -s.re).fold(0.0, f64::max);
    let limit =
        curves.iter().flat_map(|c| &c.points).filter(|p| p.1.abs() <= high).map(|p| p.0).fold(0.0, f64::max);
    let right = (1.1 * limit).clamp(0.15 * left, left);
    let axis_line = FigureCurve {
        name: String::new(),
        points: vec![(0.0, -high), (0.0, high)],
        mark: Mark::Line,
        colour: GREY,
    };
    curves.insert(0, axis_line);
    let (re, im) = ("Real part (1/s)", "Imaginary part / 2\u{3c0} (Hz)");
    let closer = close_pair(&poles, &zeros, TAU * high).map(|(middle, reach)| Panel {
        x: FigureAxis::linear(
            &format!("{re}, magnified"),
            (middle.re - PANEL_SHAPE * reach, middle.re + PANEL_SHAPE * reach),
        ),
        y: FigureAxis::linear(im, ((middle.im - reach) / TAU, (middle.im + reach) / TAU)),
        curves: curves.clone(),
    });
    let more = if closer.is_some() { " Below, the pole and the zero that lie close together." } else { "" };
    let whole =
        Panel { x: FigureAxis::linear(re, (-left, right)), y: FigureAxis::linear(im, (-high, high)), curves };
    Ok(Figure {
        name: name.into(),
        caption: format!("{caption}{more}"),
        panels: [whole].into_iter().chain(closer).collect(),
    })
}

/// Middle of a complex pole and a zero that would coincide in a picture of this height (rad/s), and the view
/// that separates them.
fn close_pair(poles: &[C64], zeros: &[C64], height: f64) -> Option<(C64, f64)> {
    let pairs = poles
        .iter()
        .flat_map(|pole| zeros.iter().map(move |zero| (pole, zero)))
        .filter(|(pole, zero)| pole.im > 0.0 && zero.im > 0.0);
    let (pole, zero) = pairs.min_by(|a, b| (a.0 - a.1).norm().total_cmp(&(b.0 - b.1).norm()))?;
    let apart = (pole - zero).norm();
    (apart < CLOSE * height).then(|| ((pole + zero) * 0.5, apart))
}

/// The rising points that are distinct on a logarithmic axis.
fn apart(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for &point in points {
        if kept.last().is_none_or(|last| point.0 > DOT_SPACING * last.0) {
            kept.push(point);
        }
    }
    kept
}

fn measured_figures() -> Result<Vec<Figure>, ValidationError> {
    let stand_in = "the machine fitted to the paper's landmarks (not the robot's own parameters, which were \
                    never published): white noise in, dots \
                    estimated from the records, line linear theory.";
    let cases = [
        (
            "fig15",
            Engagement::Free,
            "motor",
            Quantity::Acceleration,
            "Colocated acceleration: velocity command to acceleration at the motor",
            "1/s",
        ),
        (
            "fig16",
            Engagement::Free,
            "link4",
            Quantity::Acceleration,
            "Noncolocated acceleration: velocity command to acceleration at the end-point",
            "1/s",
        ),
        (
            "fig17",
            Engagement::Clamped,
            "tool",
            Quantity::SpringForce,
            "Noncolocated force: velocity command to contact force, end-point clamped",
            "N s/m",
        ),
    ];
    let mut all = Vec::new();
    for (name, engagement, element, quantity, what, unit) in cases {
        let experiment = FrfExperiment {
            machine: landmarks::fitted(engagement)?,
            actuator: "drive".into(),
            output: SignalName::new(element, quantity),
            hold_s: HOLD_S,
            offset: 0.0,
            seed: 3,
        };
        let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
        let measured = experiment.measure(
            &Excitation::WhiteNoise { duration_s: EXPERIMENT_S, method },
            0.01,
            BAND_HZ,
        )?;
        // A line needs only every eighth point.
        let kept: Vec<usize> = (0..measured.linear.len()).step_by(8).collect();
        let pick = |values: &[C64]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
        let frequencies: Vec<f64> = kept.iter().map(|&i| measured.estimate.frequencies_hz[i]).collect();
        let [line, line_phase] =
            bode_curves("linear theory", &frequencies, &pick(&measured.linear), Mark::Line, RED);
        let mut dots =
            bode_curves("estimated", &frequencies, &pick(&measured.estimate.response), Mark::Dot, BLUE);
        for curve in &mut dots {
            curve.points = apart(&curve.points);
        }
        let [dots, dots_phase] = dots;
        let caption = format!("Fig. {}. {what}, {stand_in}", number(name));
        all.push(Figure {
            name: name.into(),
            caption,
            panels: bode_panels(BAND_HZ, unit, vec![line, dots], vec![line_phase, dots_phase]),
        });
    }
    Ok(all)
}
