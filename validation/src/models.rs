//! Poles, zeros and largest stable gains of the paper's models and of the second axis, against independent
//! numbers.

use std::f64::consts::TAU;

use feeler_analysis::{ControlLoop, GainBands, View};
use feeler_control::ForceGains;
use feeler_plant::description::{ActuatorKind, Quantity, SignalName};

use crate::error::ValidationError;
use crate::paper::{IDEAL, MODEL_TABLE, ModelRow, PaperAxis, gain_of};
use crate::table::CheckRow;

/// The sample time of the table, s.
const PERIOD_S: f64 = 1e-3;
/// The reference gains come from a root search; they are trusted to this share.
const CRITICAL_GAIN: f64 = 1e-6;
/// Poles and zeros of the reference are printed to nine digits.
const CRITICAL_POINT: f64 = 1e-8;

/// Half a unit of the last printed decimal.
fn printed(decimals: i32) -> f64 {
    0.5 * 10_f64.powi(-decimals) * (1.0 + 1e-9)
}

/// The largest stable gain, searched from above as in the table: infinite if the last interval has no end.
fn largest(bands: &GainBands) -> f64 {
    bands.bands.last().map_or(0.0, |band| band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain))
}

/// Rows for the table of models.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn model_rows() -> Result<Vec<CheckRow>, ValidationError> {
    let mut rows = Vec::new();
    for row in &MODEL_TABLE {
        rows.extend(one_model(row)?);
    }
    Ok(rows)
}

/// The unstable gains below the largest stable one, in words.
fn unstable_before(bands: &GainBands) -> String {
    let spans = bands.bands.windows(2).filter_map(|pair| {
        let (from, to) = (pair[0].upper.as_ref()?.gain, pair[1].lower.as_ref()?.gain);
        Some(format!(" (though not from {from:.3} to {to:.3})"))
    });
    spans.collect()
}

fn one_model(row: &ModelRow) -> Result<Vec<CheckRow>, ValidationError> {
    const CLAIM: &str = "table of the paper's models (SciPy)";
    let name = row.name();
    let whole = row.axis().kp_loop(PERIOD_S, 0.0)?;
    let input = SignalName::new("drive", Quantity::Command);
    let channel = whole.plant().channel(&input, &SignalName::new("tool", Quantity::SpringForce))?;
    let (poles, zeros) = (channel.poles()?, channel.zeros()?);
    let count = |what: &str, got: usize, expected: usize| {
        CheckRow::close(format!("{name}: number of {what}"), CLAIM, got as f64, expected as f64, 0.0)
    };
    let mut rows = vec![count("poles", poles.len(), row.order.0), count("zeros", zeros.len(), row.order.1)];
    for (what, found, expected) in
        [("pole", channel.poles_hz()?, row.poles_hz), ("zero", channel.zeros_hz()?, row.zeros_hz)]
    {
        rows.push(count(&format!("{what} frequencies"), found.len(), expected.len()));
        for (found, expected) in found.iter().zip(expected) {
            rows.push(CheckRow::close(
                format!("{name}: {what} at {expected} Hz"),
                CLAIM,
                *found,
                *expected,
                printed(3),
            ));
        }
    }
    let key = gain_of(&whole);
    let (expected, decimals) = row.continuous.unwrap_or((f64::INFINITY, 0));
    let bands = whole.continuous_bands(key)?;
    rows.push(CheckRow::close(
        format!("{name}: largest kp, continuous{}", unstable_before(&bands)),
        CLAIM,
        largest(&bands),
        expected,
        printed(decimals),
    ));
    for (samples, expected) in row.sampled.into_iter().flatten().enumerate() {
        let delayed = row.axis().kp_loop(PERIOD_S, samples as f64 * PERIOD_S)?;
        let got = largest(&delayed.sampled_bands(key)?);
        rows.push(CheckRow::close(
            format!("{name}: largest kp, 1 kHz, {samples} samples late"),
            CLAIM,
            got,
            expected,
            printed(4),
        ));
    }
    Ok(rows)
}

/// The second axis of the independent critical gains, for a case such as `transmission/lag30Hz`.
fn second_axis(params: &serde_json::Value, case: &str) -> Option<PaperAxis> {
    let p = |name: &str| params[name].as_f64();
    let (structure, drive) = case.split_once('/')?;
    let (wb, ww) = (TAU * p("fb")?, TAU * p("fw")?);
    // The base's frequency and damping are those of base and robot moving as one, as in the reference's
    // zeros.
    let on_base = p("mb")? + p("mr")?;
    Some(PaperAxis {
        masses_kg: (p("m1")?, p("m2")?),
        guide_n_s_per_m: p("br")?,
        contact: (p("ks")?, p("bs")?),
        transmission: if structure == "transmission" { Some((p("krf")?, p("crf")?)) } else { None },
        base: if structure == "base" {
            Some((p("mb")?, on_base * wb * wb, 2.0 * p("zb")? * on_base * wb))
        } else {
            None
        },
        workpiece: if structure == "workpiece" {
            Some((p("mw")?, p("mw")? * ww * ww, 2.0 * p("zw")? * p("mw")? * ww))
        } else {
            None
        },
        drive: if drive == "no_actuator" {
            IDEAL
        } else {
            ActuatorKind::Force { bandwidth_hz: Some(1.0 / (TAU * p("tau")?)) }
        },
        total_force: true,
    })
}

/// Rows for the independent critical gains, from the text of `critical-gains.json`.
///
/// # Errors
/// [`ValidationError::Reference`] for a text of another form; [`ValidationError::Analysis`].
pub fn critical_gain_rows(json: &str) -> Result<Vec<CheckRow>, ValidationError> {
    const CLAIM: &str = "critical gains of a second axis (independent root search)";
    let bad = |what: &str| ValidationError::Reference { what: what.into() };
    let reference: serde_json::Value = serde_json::from_str(json).map_err(|e| bad(&e.to_string()))?;
    let cases = reference["cases"].as_object().ok_or_else(|| bad("cases"))?;
    let mut rows = Vec::new();
    for (case, expected) in cases {
        let axis = second_axis(&reference["params"], case).ok_or_else(|| bad(case))?;
        let whole = axis.kp_loop(PERIOD_S, 0.0)?;
        let channel = whole.plant().channel(
            &SignalName::new("drive", Quantity::Command),
            &SignalName::new("tool", Quantity::Force),
        )?;
        for (what, found) in [("poles", channel.poles()?), ("zeros", channel.zeros()?)] {
            let points = expected[what].as_array().ok_or_else(|| bad(what))?;
            let mut worst: f64 = if points.len() == found.len() { 0.0 } else { f64::INFINITY };
            for point in points {
                let (re, im) = (point[0].as_f64().unwrap_or(f64::NAN), point[1].as_f64().unwrap_or(f64::NAN));
                let nearest = found
                    .iter()
                    .map(|f| (f.re - re).hypot(f.im - im) / re.hypot(im))
                    .fold(f64::INFINITY, f64::min);
                worst = worst.max(nearest);
            }
            rows.push(CheckRow::at_most(
                format!("{case}: {what}, relative error"),
                CLAIM,
                worst,
                CRITICAL_POINT,
            ));
        }
        let one = |kp, ki| ForceGains { kp, ki, ..ForceGains::default() };
        for (law, gains) in [("Kp", one(0.1, 0.0)), ("Ki", one(0.0, 0.1))] {
            let looped =
                |delay: f64| ControlLoop::new(&axis.force_loop(gains, PERIOD_S, delay), &View::CLAMPED);
            let whole = looped(0.0)?;
            let key = gain_of(&whole);
            let mut check = |label: String, bands: GainBands| {
                let value = expected[&label].as_f64().unwrap_or(f64::INFINITY);
                rows.push(CheckRow::relative(
                    format!("{case}: {label}"),
                    CLAIM,
                    bands.first_upper(),
                    value,
                    CRITICAL_GAIN,
                ));
            };
            check(format!("{law}_crit_continuous"), whole.continuous_bands(key)?);
            for samples in 0..3 {
                check(
                    format!("{law}_crit_ZOH_T0.001_delay{samples}"),
                    looped(f64::from(samples) * PERIOD_S)?.sampled_bands(key)?,
                );
            }
        }
    }
    Ok(rows)
}
