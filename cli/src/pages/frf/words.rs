//! A measured frequency response in words.

use feeler_studies::frf::{
    COHERENT, DistortionBand, FrequencyResponse, INCOHERENT, Incoherent, KNOWN_DEG, Levels,
};

use crate::numbers::{plain, with_unit};

/// Powers below this share of the response are rounding errors of doubles: -200 dB.
const ROUNDING: f64 = 1e-20;
/// Differences below this, in dB or degrees, are rounding errors.
const EQUAL: f64 = 1e-6;
/// Largest number of named bands of distortion.
const MOST_BANDS: usize = 3;
/// Largest number of named spans of frequency.
const MOST_SPANS: usize = 4;

/// Input and output.
pub(crate) fn path(response: &FrequencyResponse) -> String {
    let reads = response
        .reads
        .as_ref()
        .map_or_else(String::new, |signal| format!(", the sensor's reading of {signal}"));
    format!("from {} to {}{reads}", response.input, response.output)
}

/// Difference between measurement and linear theory, over all frequencies.
pub(crate) fn headline(response: &FrequencyResponse) -> String {
    let agreement = response.agreement();
    let [decibels, at_hz] = agreement.widest;
    if decibels < EQUAL {
        return format!(
            "Measured and linear response are equal, except for rounding errors, at all {} frequencies.",
            response.linear.len()
        );
    }
    format!(
        "Measured and linear response differ by {} dB at most, at {}, over all {} frequencies.",
        plain(decibels),
        with_unit(at_hz, "Hz"),
        response.linear.len()
    )
}

/// A difference, in dB or degrees with the unit, or a word for one that is a rounding error.
pub(crate) fn apart(difference: f64, unit: &str) -> String {
    if difference < EQUAL { "none".to_owned() } else { format!("{}{unit}", plain(difference)) }
}

/// Whether a level exceeds the rounding errors of a response, both in dB.
pub(crate) fn is_level(level_db: f64, response_db: f64) -> bool {
    level_db - response_db > 10.0 * ROUNDING.log10()
}

/// The comparison with linear theory, and the noise and distortion that the excitation separates.
pub(crate) fn sentences(response: &FrequencyResponse) -> Vec<String> {
    let agreement = response.agreement();
    let coherent = (agreement.coherence).map_or_else(
        || format!("the phase is known to ±{KNOWN_DEG}°"),
        |least| format!("the coherence is {} or more", plain(least)),
    );
    let mut said = vec![if agreement.compared == 0 && agreement.coherence.is_none() {
        format!("No frequency is known to {KNOWN_DEG}° of phase: noise outweighs the excitation.")
    } else if agreement.compared == 0 {
        format!("No frequency has a coherence of {}: output and input are hardly related.", COHERENT[2])
    } else if agreement.decibels < EQUAL && agreement.degrees < EQUAL {
        format!(
            "Where {coherent} ({} of {} frequencies), measured and linear response are equal, except for \
             rounding errors.",
            agreement.compared,
            response.linear.len(),
        )
    } else {
        format!(
            "Where {coherent} ({} of {} frequencies), measured and linear response differ by {} dB and {}° \
             at most. The linear response lies within the {} % confidence band at {} % of all frequencies.",
            agreement.compared,
            response.linear.len(),
            plain(agreement.decibels),
            plain(agreement.degrees),
            plain(100.0 * response.confidence),
            plain((100.0 * agreement.within).round()),
        )
    }];
    said.extend(
        (response.incoherent().filter(|found| found.count > 0))
            .map(|found| incoherent(found, response.estimate.frequencies_hz.len())),
    );
    said.extend(response.levels().map(levels));
    said
}

/// Levels of noise and distortion, and whether there is distortion.
fn levels(levels: Levels) -> String {
    let Levels { noise, shows_from, is_beyond_noise, bands } = levels;
    let distortion = if !is_beyond_noise {
        let shows =
            (shows_from > ROUNDING).then(|| format!(" (it would show above {})", decibels(shows_from)));
        format!("none beyond the noise{}", shows.unwrap_or_default())
    } else if bands.is_empty() {
        "at single frequencies only".to_owned()
    } else {
        strongest(bands)
    };
    format!(
        "Relative to the response, in one realisation: noise {} (median over frequency), nonlinear \
         distortion {distortion}.",
        decibels(noise)
    )
}

fn decibels(share: f64) -> String {
    if share > ROUNDING { format!("{} dB", plain((10.0 * share.log10()).round())) } else { "none".to_owned() }
}

/// The strongest bands.
fn strongest(mut bands: Vec<DistortionBand>) -> String {
    bands.sort_by(|a, b| b.share.total_cmp(&a.share));
    let named: Vec<String> = (bands.iter().take(MOST_BANDS))
        .map(|band| {
            format!(
                "{} from {} to {}",
                decibels(band.share),
                plain(band.low_hz),
                with_unit(band.high_hz, "Hz")
            )
        })
        .collect();
    let rest = if bands.len() > MOST_BANDS { ", less in other bands" } else { "" };
    named.join(", ") + rest
}

/// Frequencies at which the output hardly depends on the input: the widest spans.
fn incoherent(Incoherent { count, mut spans }: Incoherent, frequencies: usize) -> String {
    spans.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    let more = if spans.len() > MOST_SPANS { " and elsewhere" } else { "" };
    spans.truncate(MOST_SPANS);
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let named = spans.iter().map(|[a, b]| {
        if a < b { format!("from {} to {}", plain(*a), plain(*b)) } else { format!("at {}", plain(*a)) }
    });
    let named = named.collect::<Vec<_>>().join(", ");
    format!(
        "Coherence is below {INCOHERENT} at {count} of {frequencies} frequencies ({named} Hz{more}). There \
         much of the output is noise, leakage, nonlinearity, or due to something else that acts on the \
         machine."
    )
}
