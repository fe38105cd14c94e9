//! Records of an axis as a simple recorder writes them: with noise, quantised readings, jitter and lost rows.

use std::collections::VecDeque;
use std::fmt::Write as _;

use super::super::axis::State;
use super::super::noise::Random;
use super::draw::Drawn;
use super::motion::{Motion, Servo};

/// Integration steps per radian of the highest frequency.
const STEPS_PER_RADIAN: f64 = 12.0;
/// Smallest number of integration steps between rows.
const STEPS_PER_ROW: f64 = 4.0;
/// Ratio of an encoder's noise to its resolution.
const ENCODER_NOISE: f64 = 0.1;
/// Largest number of consecutive lost rows.
const LOST_TOGETHER: usize = 6;
/// Rows at either end that are never lost.
const KEPT_ROWS: usize = 3;
/// Shortest time before the first row of records that begin in motion, in periods; up to a period is added at
/// random.
const WARM_UP: f64 = 1.0;

struct Row {
    stamp_s: f64,
    command: f64,
    motor: f64,
    load: f64,
}

/// A record of `periods` of the motion as CSV.
pub(super) fn measure(drawn: &Drawn, motion: &Motion, periods: f64, random: &mut Random) -> String {
    let rows = sampled(drawn, motion, periods, random);
    let mean_square =
        rows.iter().map(|row| row.command * row.command).sum::<f64>() / rows.len().max(1) as f64;
    let noise = drawn.conditions.command_noise_share * mean_square.sqrt();
    let resolution = drawn.conditions.resolution;
    let lost = lost_rows(rows.len(), drawn.conditions.lost_share, random);
    let mut text = header(drawn);
    for (row, lost) in rows.iter().zip(lost) {
        let command = row.command + noise * random.normal();
        let mut read = |x: f64| ((x / resolution + ENCODER_NOISE * random.normal()).round()) * resolution;
        let (motor, load) = (read(row.motor), read(row.load));
        if lost {
            continue;
        }
        let _ = write!(text, "{:.6},{command:.6e},{motor:.9e}", row.stamp_s);
        if drawn.conditions.channels > 2 {
            let _ = write!(text, ",{load:.9e}");
        }
        text.push('\n');
    }
    text
}

/// Names of the columns, with their units.
pub(super) fn columns(is_rotational: bool) -> [&'static str; 3] {
    if is_rotational {
        ["command_nm", "encoder_rad", "load_encoder_rad"]
    } else {
        ["command_n", "encoder_m", "load_encoder_m"]
    }
}

fn header(drawn: &Drawn) -> String {
    let [command, motor, load] = columns(drawn.conditions.is_rotational);
    let load = if drawn.conditions.channels == 2 { String::new() } else { format!(",{load}") };
    format!("t_s,{command},{motor}{load}\n")
}

/// Moves the axis and reads it at every instant of the clock.
fn sampled(drawn: &Drawn, motion: &Motion, periods: f64, random: &mut Random) -> Vec<Row> {
    let (axis, conditions) = (&drawn.axis, &drawn.conditions);
    let period_s = 1.0 / conditions.motion_hz;
    let spacing_s = 1.0 / conditions.rate_hz;
    let fastest = axis.fastest().max(drawn.sizes.servo(axis.mass_kg()));
    let step_s = (1.0 / (STEPS_PER_RADIAN * fastest)).min(spacing_s / STEPS_PER_ROW);
    let begin_s = if conditions.begins_in_motion { period_s * (WARM_UP + random.share()) } else { 0.0 };
    let servo = Servo::new(motion, axis, drawn.sizes);
    let mut arriving: VecDeque<f64> = VecDeque::new();
    let late = (axis.drive.delay_s / step_s).round() as usize;
    let mut state = State::resting_at(motion.start());
    let mut command = 0.0;
    let mut steps = 0_usize;
    let count = (periods * period_s / spacing_s) as usize;
    (0..count)
        .map(|k| {
            let jitter = (conditions.jitter_share * random.normal()).clamp(-0.4, 0.4) * spacing_s;
            let nominal_s = k as f64 * spacing_s;
            let until = ((begin_s + nominal_s + jitter) / step_s).max(0.0) as usize;
            while steps <= until {
                command = servo.command(steps as f64 * step_s, state.motor);
                arriving.push_back(command);
                let arrived = if arriving.len() > late { arriving.pop_front().unwrap_or(0.0) } else { 0.0 };
                axis.step(&mut state, arrived, step_s);
                steps += 1;
            }
            let stamp_s = if conditions.is_jitter_stamped { nominal_s + jitter } else { nominal_s };
            Row { stamp_s, command, motor: state.motor[0], load: state.load[0] }
        })
        .collect()
}

/// The rows that the recorder loses: some alone, some in runs.
fn lost_rows(count: usize, share: f64, random: &mut Random) -> Vec<bool> {
    let mut lost = vec![false; count];
    let mut left = (share * count as f64).round() as usize;
    while left > 0 && count > 4 * KEPT_ROWS {
        let together = (1 + random.pick(LOST_TOGETHER)).min(left);
        let first = KEPT_ROWS + random.pick(count - 2 * KEPT_ROWS - together);
        lost[first..first + together].iter_mut().for_each(|row| *row = true);
        left -= together;
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::super::draw::draw;
    use super::*;

    fn drawn() -> Drawn {
        let mut drawn = draw(3, &mut Random::new(8), &|_| true);
        drawn.conditions.rate_hz = 200.0;
        drawn.conditions.motion_hz = 1.0;
        drawn.conditions.channels = 3;
        drawn
    }

    fn numbers(text: &str) -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    }

    #[test]
    fn truth_rows_are_a_period_of_the_clock_apart_and_readings_are_steps_of_the_encoder() {
        let mut drawn = drawn();
        (drawn.conditions.lost_share, drawn.conditions.jitter_share) = (0.0, 0.0);
        let mut random = Random::new(1);
        let motion = Motion::waves(&drawn.sizes, 1.0, &mut random);
        let rows = numbers(&measure(&drawn, &motion, 3.0, &mut random));
        assert_eq!(rows.len(), 600);
        for (k, row) in rows.iter().enumerate() {
            // Stamps are written with a resolution of a microsecond, readings with ten digits.
            assert!((row[0] - k as f64 / 200.0).abs() < 1e-6);
            let steps = row[2] / drawn.conditions.resolution;
            assert!((steps - steps.round()).abs() < 1e-6 * steps.abs().max(1.0));
        }
    }

    #[test]
    fn truth_lost_rows_are_missing_and_the_others_stay_as_they_are() {
        let mut drawn = drawn();
        (drawn.conditions.lost_share, drawn.conditions.jitter_share) = (0.0, 0.0);
        let motion = Motion::stroke(&drawn.sizes, 1.0, 1.0);
        let whole = numbers(&measure(&drawn, &motion, 5.0, &mut Random::new(4)));
        drawn.conditions.lost_share = 0.01;
        let cut = numbers(&measure(&drawn, &motion, 5.0, &mut Random::new(4)));
        assert!(cut.len() < whole.len() && cut.len() >= whole.len() - 10);
        assert!(cut.iter().all(|row| whole.iter().any(|other| other[0].to_bits() == row[0].to_bits())));
    }

    #[test]
    fn truth_a_stamped_jitter_shows_in_the_stamps_only_where_it_is_stamped() {
        let mut drawn = drawn();
        (drawn.conditions.lost_share, drawn.conditions.jitter_share) = (0.0, 0.1);
        let motion = Motion::stroke(&drawn.sizes, 1.0, 1.0);
        for is_stamped in [true, false] {
            drawn.conditions.is_jitter_stamped = is_stamped;
            let rows = numbers(&measure(&drawn, &motion, 3.0, &mut Random::new(4)));
            let square = |pair: &[Vec<f64>]| (200.0 * (pair[1][0] - pair[0][0]) - 1.0).powi(2);
            let spread = (rows.windows(2).map(square).sum::<f64>() / rows.len() as f64).sqrt();
            // Each of the two instants has a deviation of a tenth of a row. 600 rows give the spread within 3
            // %; four times that is allowed.
            let wanted = if is_stamped { 0.1 * 2.0_f64.sqrt() } else { 0.0 };
            assert!((spread - wanted).abs() < 0.12 * 0.1 * 2.0_f64.sqrt());
        }
    }

    #[test]
    fn truth_command_noise_has_its_share() {
        let mut drawn = drawn();
        (drawn.conditions.lost_share, drawn.conditions.jitter_share) = (0.0, 0.0);
        let motion = Motion::stroke(&drawn.sizes, 1.0, 1.0);
        let mut commands = |share: f64| {
            drawn.conditions.command_noise_share = share;
            numbers(&measure(&drawn, &motion, 5.0, &mut Random::new(4)))
                .into_iter()
                .map(|row| row[1])
                .collect::<Vec<_>>()
        };
        let (clean, noisy) = (commands(0.0), commands(0.08));
        let rms = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        let share = rms(&mut noisy.iter().zip(&clean).map(|(a, b)| a - b)) / rms(&mut clean.iter().copied());
        // 1000 rows give the deviation within 2 %; about four times that is allowed.
        assert!((share / 0.08 - 1.0).abs() < 0.09);
    }
}
