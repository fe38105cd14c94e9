//! The clock of a table: its column, its unit, and the reason for this choice.

/// Unit of a clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockUnit {
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
}

impl ClockUnit {
    /// All units, the coarsest first.
    pub const ALL: [Self; 4] = [Self::Seconds, Self::Milliseconds, Self::Microseconds, Self::Nanoseconds];

    /// Its symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Microseconds => "us",
            Self::Nanoseconds => "ns",
        }
    }

    /// How many make a second.
    pub fn per_second(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e3,
            Self::Microseconds => 1e6,
            Self::Nanoseconds => 1e9,
        }
    }

    /// The unit of this symbol.
    pub fn named(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.symbol() == symbol)
    }
}

/// The source of a table's times.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Column, field or part of the format.
    pub column: String,
    pub unit: ClockUnit,
    /// Zero of the table's times on this clock, s.
    pub origin_s: f64,
    /// Reason for this clock and unit.
    pub why: String,
}

/// Seconds after 1970 that count as calendar time: from 2001 to 2096.
const EPOCH_S: std::ops::Range<f64> = 1e9..4e9;
/// Largest row spacing, s, of a clock without a stated unit: a logger at 2 Hz is the slowest.
const SLOWEST_S: f64 = 0.5;

/// Names of clocks, without units.
const NAMES: [&str; 8] = ["t", "time", "timestamp", "stamp", "clock", "timestamps", "times", "log_time"];

/// The name of a clock, with its stated unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClockName {
    pub(crate) unit: Option<ClockUnit>,
}

/// The clock in a header, if it names one.
pub(crate) fn named(header: &str) -> Option<ClockName> {
    let lower = header.trim().to_ascii_lowercase();
    let bare: String = lower.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { ' ' }).collect();
    let words: Vec<&str> = bare.split_whitespace().collect();
    let unit = words.last().filter(|_| words.len() > 1).and_then(|word| match *word {
        "s" | "sec" | "secs" | "second" | "seconds" => Some(ClockUnit::Seconds),
        "ms" | "msec" | "millis" | "milliseconds" => Some(ClockUnit::Milliseconds),
        "us" | "usec" | "micros" | "microseconds" => Some(ClockUnit::Microseconds),
        "ns" | "nsec" | "nanos" | "nanoseconds" => Some(ClockUnit::Nanoseconds),
        _ => None,
    });
    let own = if unit.is_some() { &words[..words.len() - 1] } else { &words[..] };
    let is_clock = match own {
        [] => false,
        [.., last] => NAMES.contains(last) || NAMES.contains(&own.concat().as_str()),
    };
    is_clock.then_some(ClockName { unit })
}

/// The unit of a clock without a stated one, and the reason.
pub(crate) fn guess(first: f64, step: f64) -> (ClockUnit, String) {
    for unit in ClockUnit::ALL {
        if EPOCH_S.contains(&(first / unit.per_second())) {
            return (unit, format!("counts {} since 1970", unit.symbol()));
        }
    }
    // The coarsest unit with rows at 2 Hz or faster.
    let unit = ClockUnit::ALL
        .into_iter()
        .find(|unit| step / unit.per_second() <= SLOWEST_S)
        .unwrap_or(ClockUnit::Nanoseconds);
    let rate = unit.per_second() / step;
    (unit, format!("rows are {step:.6} apart, which in {} is {rate:.4} Hz", unit.symbol()))
}

/// Seconds of a column of times, and their clock. A unit may be stated.
pub(crate) fn make(column: &str, times: &[f64], stated: Option<ClockUnit>) -> (Clock, Vec<f64>) {
    let first = times.iter().copied().find(|t| t.is_finite()).unwrap_or(0.0);
    let (unit, why) = unit_of(first, median_step(times), stated);
    // Small times stay as written; only times since 1970 start at zero.
    let origin = if first / unit.per_second() >= EPOCH_S.start { first } else { 0.0 };
    let seconds = times.iter().map(|t| (t - origin) / unit.per_second()).collect();
    (Clock { column: column.into(), unit, origin_s: origin / unit.per_second(), why }, seconds)
}

/// The same for whole numbers, whose differences are exact.
pub(crate) fn make_whole(column: &str, times: &[i64], stated: Option<ClockUnit>) -> (Clock, Vec<f64>) {
    let first = times.first().copied().unwrap_or(0);
    let since: Vec<f64> = times.iter().map(|t| t.wrapping_sub(first) as f64).collect();
    let (unit, why) = unit_of(first as f64, median_step(&since), stated);
    let is_epoch = first as f64 / unit.per_second() >= EPOCH_S.start;
    let seconds = |ticks: f64| ticks / unit.per_second();
    let clock = Clock {
        column: column.into(),
        unit,
        origin_s: if is_epoch { seconds(first as f64) } else { 0.0 },
        why,
    };
    if is_epoch {
        (clock, since.into_iter().map(seconds).collect())
    } else {
        (clock, times.iter().map(|t| seconds(*t as f64)).collect())
    }
}

fn unit_of(first: f64, step: Option<f64>, stated: Option<ClockUnit>) -> (ClockUnit, String) {
    match stated {
        Some(unit) => (unit, "this unit is stated".to_owned()),
        None => guess(first, step.unwrap_or(0.0)),
    }
}

/// Nanoseconds of a calendar time, as in `2024-05-01T12:00:00.25Z` or `2024-05-01 12:00:00,25+02:00`; since
/// midnight of a time of day with its seconds.
pub(crate) fn calendar_ns(text: &str) -> Option<i64> {
    let text = text.trim();
    let of_day = || (text.matches(':').count() == 2).then_some(("1970-01-01", text));
    let (date, time) = text.split_once(['T', ' ', 't']).or_else(of_day)?;
    let mut parts = date.split(['-', '/']);
    let mut next = || parts.next()?.parse::<i64>().ok();
    let (year, month, day) = (next()?, next()?, next()?);
    if !(1970..=2200).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let end = time.find(['Z', 'z', '+', '-']).unwrap_or(time.len());
    let (clock, zone) = time.split_at(end);
    let mut parts = clock.trim().split(':');
    let hour: i64 = parts.next()?.parse().ok()?;
    let minute: i64 = parts.next()?.parse().ok()?;
    let seconds = parts.next().unwrap_or("0");
    let (whole, fraction) = seconds.split_once(['.', ',']).unwrap_or((seconds, ""));
    let second: i64 = whole.parse().ok()?;
    if !fraction.bytes().all(|b| b.is_ascii_digit()) || hour > 24 || minute > 59 || second > 60 {
        return None;
    }
    let nanos: i64 = format!("{fraction:0<9}").get(..9)?.parse().ok()?;
    let offset_minutes = match zone {
        "" | "Z" | "z" => 0,
        zone => {
            let (sign, zone) =
                zone.strip_prefix('-').map_or((1, zone.strip_prefix('+')), |rest| (-1, Some(rest)));
            let digits = zone?.replacen(':', "", 1);
            if !matches!(digits.len(), 2 | 4) || !digits.bytes().all(|b| b.is_ascii_digit()) {
                return None;
            }
            let value: i64 = digits.parse().ok()?;
            sign * if digits.len() > 2 { value / 100 * 60 + value % 100 } else { value * 60 }
        }
    };
    // Days since 1970 of the proleptic Gregorian calendar, with years that begin in March.
    let (y, m) = if month <= 2 { (year - 1, month + 9) } else { (year, month - 3) };
    let days = 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 719_468;
    let seconds = ((days * 24 + hour) * 60 + minute - offset_minutes) * 60 + second;
    Some(seconds * 1_000_000_000 + nanos)
}

/// The median distance of neighbouring times that increase.
pub fn median_step(times: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_headers_name_clocks_and_their_units() {
        for (header, expected) in [
            ("t_s", Some(Some(ClockUnit::Seconds))),
            ("Time [ms]", Some(Some(ClockUnit::Milliseconds))),
            ("timestamp_us", Some(Some(ClockUnit::Microseconds))),
            ("header.stamp_ns", Some(Some(ClockUnit::Nanoseconds))),
            ("timestamp", Some(None)),
            ("t", Some(None)),
            ("torque", None),
            ("time_constant", None),
            ("position_s", None),
            ("", None),
        ] {
            assert_eq!(named(header).map(|name| name.unit), expected, "{header}");
        }
    }

    #[test]
    fn truth_units_follow_from_size_and_spacing() {
        let unit = |first, step| guess(first, step).0;
        assert_eq!(unit(1.7e9, 0.001), ClockUnit::Seconds);
        assert_eq!(unit(1.7e18, 1e6), ClockUnit::Nanoseconds);
        assert_eq!(unit(1.7e12, 5.0), ClockUnit::Milliseconds);
        assert_eq!(unit(4.9, 20_000.0), ClockUnit::Microseconds);
        assert_eq!(unit(0.0, 1.0), ClockUnit::Milliseconds);
        assert_eq!(unit(0.0, 0.02), ClockUnit::Seconds);
        assert_eq!(unit(0.0, 1e6), ClockUnit::Nanoseconds);
    }

    #[test]
    fn truth_calendar_times_count_from_1970() {
        // `date -u -d 2024-05-01T12:00:00.25 +%s.%N`
        let ns = 1_714_564_800_250_000_000;
        for text in ["2024-05-01T12:00:00.25Z", "2024-05-01 14:00:00,250+02:00", "2024/05/01 12:00:00.25"] {
            assert_eq!(calendar_ns(text), Some(ns), "{text}");
        }
        assert_eq!(calendar_ns("1970-01-01T00:00:00"), Some(0));
        assert_eq!(calendar_ns("12:00:00.25"), Some(43_200_250_000_000));
        for text in
            ["1.5", "12:00", "a:b:c", "2024-13-01T00:00:00", "2024-05-01Tx", "2024-05-01T00:00:00Z,0.103", ""]
        {
            assert_eq!(calendar_ns(text), None, "{text}");
        }
    }
}
