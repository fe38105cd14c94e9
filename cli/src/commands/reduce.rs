//! `feeler reduce`.

mod as_json;

use std::fmt::Write as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use feeler_arm::{Agreement, ArmError, Landmark, MeasuredArm, Others, inverse_kinematics, usual_starts};
use feeler_files::ArmFile;
use feeler_studies::arm::{
    ArmFileError, AxisFile, Grid, MapPoint, MapValues, ToolContact, axis_file, bandwidth_map, distrust,
    gain_in_words, map_csv, tool_target, without_axis,
};

use crate::arguments::Reduce;
use crate::numbers::{count, plain, with_unit};
use crate::pages;
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::progress::Progress;
use crate::terminal::table;

/// Largest number of places of a map, which takes some minutes.
const MOST_PLACES: usize = 10_000;

/// Largest stiffness and damping of a contact, N/m and N s/m. Above these, rounding errors hide slow modes of
/// the arm.
const STIFFEST: f64 = 1e11;
const MOST_DAMPED: f64 = 1e7;

pub(crate) fn run(arguments: &Reduce) -> crate::Result<()> {
    let map_is_page = arguments.map_out.as_deref().map_or(Ok(false), is_page)?;
    let file = ArmFile::load(&arguments.arm)?;
    terminal::warn(&file.doubts);
    let normal = three(&arguments.normal, "--normal")?;
    let others = if arguments.hold { Others::Held } else { Others::Free };
    let contact = contact(arguments)?;
    let at = if arguments.at.is_empty() { None } else { Some(three(&arguments.at, "--at")?) };
    let pose = at.map_or_else(|| Ok(arguments.pose.clone()), |at| pose_at(&file, at, normal))?;
    let axis = axis_file(&file, &pose, normal, others, contact).map_err(refused)?;
    let measured = (arguments.measure)
        .then(|| {
            let touch = [contact.stiffness_n_per_m, contact.damping_n_s_per_m];
            file.arm
                .measure_in_contact(&axis.reduction, &pose, normal, others, touch)
                .map_err(|error| refused(error.into()))
        })
        .transpose()?;
    let map = if arguments.map.is_empty() {
        None
    } else {
        let z_m = at.map_or_else(|| file.arm.chain().tool_place(&pose).translation.z, |[_, _, z]| z);
        let progress = Mutex::new(Progress::new(format!("{}: force bandwidth", file.name)));
        let at = |share: f64| progress.lock().unwrap_or_else(PoisonError::into_inner).at(share);
        let map = bandwidth_map(&file, &grid(&arguments.map, z_m)?, normal, others, contact, &pose, &at)
            .map_err(refused);
        progress.into_inner().unwrap_or_else(PoisonError::into_inner).done();
        Some(map?)
    };
    if let Some(path) = &arguments.out {
        terminal::write_and_tell(path, &axis.text)?;
    }
    if let (Some(path), Some(map)) = (&arguments.map_out, &map) {
        let text = if map_is_page { page(arguments, &file.name, map) } else { map_csv(map) };
        terminal::write_and_tell(path, &text)?;
    }
    if arguments.json {
        let all = as_json::Axis::new(&axis, &pose, measured.as_ref(), map.as_deref());
        return terminal::print(&terminal::json(&all)?);
    }
    let mut text = figures(&axis, &pose, contact);
    if let Some(found) = &measured {
        text.push_str(&measured_text(found));
    }
    if let Some(map) = &map {
        let _ = write!(
            text,
            "\n\nForce bandwidth (Hz) of the arm under integral control with a gain margin of 2, by x \
             (rows) and y of the tool in m:\n{}",
            chart(map)
        );
        text.push_str(&remarks(map));
    }
    terminal::print(&text)
}

/// Whether a map is written as a page. The suffix of its name decides.
fn is_page(path: &Path) -> crate::Result<bool> {
    match path.extension().map(std::ffi::OsStr::to_ascii_lowercase) {
        Some(extension) if extension == "html" => Ok(true),
        Some(extension) if extension == "csv" => Ok(false),
        _ => Err(BadInput::error(
            format!("--map-out {}: a map is a page or a table", path.display()),
            "name a file that ends in .html or .csv",
        )),
    }
}

/// Remarks on the places of a map, each on a line.
fn remarks(map: &[MapPoint]) -> String {
    let mut text = String::new();
    let found = || map.iter().filter_map(|point| point.found.as_ref().ok());
    let without = found().filter(|found| found.agreement.largest_ki_per_s[0] <= 0.0).count();
    if without > 0 {
        let _ = write!(
            text,
            "\nat {} no ki is stable (`none`): there the damping of the motors alone is unstable at 1 kHz",
            count(without, "place", "places")
        );
    }
    for (reason, n) in without_axis(map) {
        let _ = write!(text, "\n{} without an axis (`-`): {reason}", count(n, "place", "places"));
    }
    let doubtful = found().filter(|found| !found.agreement.is_trusted()).count();
    if doubtful > 0 {
        let each = Landmark::ALL.iter().enumerate().filter_map(|(i, landmark)| {
            let places = found().filter(|found| found.agreement.misfits()[i] > Agreement::TRUSTED).count();
            (places > 0).then(|| format!("{} at {places}", landmark.name()))
        });
        let each: Vec<String> = each.collect();
        let _ = write!(
            text,
            "\nwarning: at {}, marked *, the axis is more than 5 % off the arm: {}",
            count(doubtful, "place", "places"),
            each.join(", ")
        );
    }
    let off = found().filter(|found| axis_bandwidth_is_off(&found.agreement)).count();
    if off > 0 {
        let _ = write!(
            text,
            "\nat {} the force bandwidth of the axis differs by more than 5 % from the arm's, which is shown",
            count(off, "place", "places")
        );
    }
    text
}

/// Whether the axis's force bandwidth differs from the arm's.
fn axis_bandwidth_is_off(agreement: &Agreement) -> bool {
    let [arm, axis] = agreement.force_bandwidth_hz;
    arm.is_nan() != axis.is_nan() || (axis / arm - 1.0).abs() > Agreement::TRUSTED
}

fn three(numbers: &[f64], what: &str) -> crate::Result<[f64; 3]> {
    match numbers {
        [x, y, z] if numbers.iter().all(|number| number.is_finite()) => Ok([*x, *y, *z]),
        [_, _, _] => Err(BadInput::error(
            format!("{what} has a number that is not finite"),
            format!("write {what} X,Y,Z with three finite numbers"),
        )),
        _ => Err(BadInput::error(
            format!("{what} takes three finite numbers, not {}", numbers.len()),
            format!("write {what} X,Y,Z"),
        )),
    }
}

fn contact(arguments: &Reduce) -> crate::Result<ToolContact> {
    let [k, c] = [arguments.contact_stiffness, arguments.contact_damping];
    if k > STIFFEST || c > MOST_DAMPED {
        let what = format!(
            "a contact of {k} N/m and {c} N s/m exceeds the limits of {STIFFEST:.0e} N/m and \
             {MOST_DAMPED:.0e} N s/m"
        );
        return Err(BadInput::error(
            what,
            "lower --contact-stiffness or --contact-damping: a cube of steel of half a metre has 1e11 N/m",
        ));
    }
    if k > 0.0 && c >= 0.0 && k.is_finite() && c.is_finite() {
        return Ok(ToolContact { stiffness_n_per_m: k, damping_n_s_per_m: c });
    }
    let remedy = "the stiffness must be above zero, the damping zero or above";
    Err(BadInput::error(format!("the contact has {k} N/m and {c} N s/m"), remedy))
}

fn grid(numbers: &[f64], z_m: f64) -> crate::Result<Grid> {
    let count = |number: f64| {
        (number >= 1.0 && number.fract() == 0.0 && number <= MOST_PLACES as f64).then_some(number as usize)
    };
    if let &[x0, x1, nx, y0, y1, ny] = numbers
        && let (Some(nx), Some(ny)) = (count(nx), count(ny))
        && nx * ny <= MOST_PLACES
    {
        return Ok(Grid { x: (x0, x1, nx), y: (y0, y1, ny), z_m });
    }
    Err(BadInput::error(
        "--map takes six numbers, of which the third and the last count places",
        format!("as in --map 0.4,0.9,6,-0.4,0.4,5; at most {MOST_PLACES} places"),
    ))
}

/// A pose that brings the tool to a place. Joints may bend either way, so the search starts from several
/// poses.
fn pose_at(file: &ArmFile, place_m: [f64; 3], normal: [f64; 3]) -> crate::Result<Vec<f64>> {
    let chain = file.arm.chain();
    let target = tool_target(file, place_m, normal).map_err(|error| refused(error.into()))?;
    inverse_kinematics(chain, &target, &usual_starts(chain, place_m)).map_err(|error| refused(error.into()))
}

fn refused(error: ArmFileError) -> crate::Failure {
    match error {
        ArmFileError::Arm(arm @ ArmError::Unreachable { .. }) => {
            BadInput::error(arm.to_string(), "choose a place within reach, or give a --pose")
        }
        other => other.into(),
    }
}

fn figures(axis: &AxisFile, pose: &[f64], contact: ToolContact) -> String {
    let one = &axis.reduction;
    let optional =
        |value: Option<f64>, unit: &str| value.map_or_else(|| "-".to_owned(), |value| with_unit(value, unit));
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![
        row("effective mass", with_unit(one.mass_kg, "kg")),
        row("  of it at the motors", with_unit(one.motor_mass_kg, "kg")),
        row("  of it at the tool", with_unit(one.tip_mass_kg, "kg")),
        row("mass of the links alone", with_unit(one.link_mass_kg, "kg")),
        row("stiffness between the two masses", format!("{} N/m", plain(one.stiffness_n_per_m))),
        row("damping between the two masses", format!("{} N s/m", plain(one.damping_n_s_per_m))),
        row("joints in series, motors locked", format!("{} N/m", plain(one.static_stiffness_n_per_m))),
        row("viscous friction", format!("{} N s/m", plain(one.guide_damping_n_s_per_m))),
        row("dry friction", with_unit(one.dry_friction_n, "N")),
        row("force limit", optional(one.force_limit_n, "N")),
        row("bandwidth of the drives", optional(one.bandwidth_hz, "Hz")),
        row("largest stable kp at 1 kHz", gain(axis.largest_gain)),
        row("force bandwidth of the arm (integral, gain margin 2)", reached(&axis.agreement)),
    ];
    for (number, branch) in (1..).zip(&one.branches) {
        let [mass, frequency] = [with_unit(branch.mass_kg, "kg"), with_unit(branch.frequency_hz(), "Hz")];
        let place = if branch.is_linked() { "between motor and tool" } else { "beside the motor" };
        rows.push(row(&format!("body {number} {place}"), format!("{mass} at {frequency}")));
    }
    let bodies = if one.branches.is_empty() {
        ""
    } else {
        "\nfurther bodies represent modes that also load the drive; two masses alone would be farther off"
    };
    let modes = one.modes.iter().map(|mode| {
        vec![
            plain(mode.frequency_hz),
            plain(mode.damping_ratio),
            plain(mode.drive_share),
            plain(mode.tip_share),
        ]
    });
    let agreement = &axis.agreement;
    let landmarks = [
        landmark("contact mode (Hz)", agreement.contact_mode_hz),
        landmark("phase crossover (Hz)", agreement.phase_crossover_hz),
        stable_gain("stable kp at 1 kHz", agreement.largest_kp),
        stable_gain("stable ki at 1 kHz (1/s)", agreement.largest_ki_per_s),
    ];
    let meaning = format!(
        "\nphase crossover: of the whole contact force, damper included, without the drives' bandwidths.\n\
         stable kp and ki: of loops on the contact's spring force. ki is with {} N s/m of motor damping (2 * \
         0.7 * contact mode * mass), from differenced encoder positions.",
        plain(agreement.motor_damping_n_s_per_m)
    );
    let pose: Vec<String> = pose.iter().map(|x| format!("{x:.4}")).collect();
    let warning = distrust(one, &axis.agreement).map_or_else(String::new, |why| format!("\nwarning: {why}"));
    format!(
        "pose {}\n\n{}\n\nmodes that bend joints, the tool free:\n{}\n\nwhole arm and this axis, on a \
         contact of {} N/m:\n{}{meaning}{bodies}{warning}",
        pose.join(", "),
        table(&["along the normal", ""], &[1], rows),
        table(
            &["frequency (Hz)", "damping ratio", "share drive to tool", "share at tool"],
            &[0, 1, 2, 3],
            modes.collect::<Vec<_>>()
        ),
        plain(contact.stiffness_n_per_m),
        table(&["landmark", "arm", "axis", "off by (%)"], &[1, 2, 3], landmarks),
    )
}

/// A largest stable gain as text.
fn gain(value: f64) -> String {
    gain_in_words(value).map_or_else(|| plain(value), str::to_owned)
}

/// The arm's force bandwidth, or the reason why there is none; then the axis's, if it differs.
fn reached(agreement: &Agreement) -> String {
    let said = |side: usize| match agreement.largest_ki_per_s[side] {
        edge if edge <= 0.0 => "none: no ki is stable".to_owned(),
        edge if edge.is_infinite() => "none: every ki is stable".to_owned(),
        _ => with_unit(agreement.force_bandwidth_hz[side], "Hz"),
    };
    if axis_bandwidth_is_off(agreement) { format!("{} (of the axis {})", said(0), said(1)) } else { said(0) }
}

fn stable_gain(name: &str, [whole, own]: [f64; 2]) -> Vec<String> {
    let off = 100.0 * (own / whole - 1.0);
    vec![name.to_owned(), gain(whole), gain(own), if off.is_finite() { plain(off) } else { "-".to_owned() }]
}

fn landmark(name: &str, [whole, own]: [f64; 2]) -> Vec<String> {
    vec![name.to_owned(), plain(whole), plain(own), plain(100.0 * (own / whole - 1.0))]
}

fn measured_text(found: &MeasuredArm) -> String {
    let rows = [
        landmark("phase at -90 degrees (Hz)", found.contact_mode_hz),
        landmark("phase at -180 degrees (Hz)", found.phase_crossover_hz),
    ];
    format!(
        "\n\nmeasured in simulation, {} lines of a multisine on the drive over {}:\n{}",
        found.frequencies_hz.len(),
        with_unit(found.simulated_s, "s"),
        table(&["landmark", "arm", "axis", "off by (%)"], &[1, 2, 3], rows)
    )
}

fn page(arguments: &Reduce, name: &str, map: &[MapPoint]) -> String {
    let arm = terminal::quoted(&arguments.arm.display().to_string());
    let normal = arguments.normal.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let hold = if arguments.hold { " --hold" } else { "" };
    let contact = format!(
        "--contact-stiffness {} --contact-damping {}",
        arguments.contact_stiffness, arguments.contact_damping
    );
    let command = |at: [f64; 3]| {
        // Digits beyond a picometre are rounding errors.
        let [x, y, z] = at.map(|v| (v * 1e12).round() / 1e12);
        format!("feeler reduce {arm} --at {x},{y},{z} --normal {normal} {contact}{hold} --out axis.toml")
    };
    pages::reduce::page(name, map, &command)
}

/// The map as a table, y to the right.
fn chart(map: &[MapPoint]) -> String {
    let mut columns: Vec<f64> = map.iter().map(|point| point.place_m[1]).collect();
    columns.sort_by(f64::total_cmp);
    columns.dedup_by(|a, b| a.to_bits() == b.to_bits());
    let header: Vec<String> =
        std::iter::once("x \\ y".to_owned()).chain(columns.iter().map(|y| plain(*y))).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows: Vec<Vec<String>> = (map.chunks(columns.len()))
        .map(|row| {
            let value = |point: &MapPoint| {
                let mark = |found: &MapValues| if found.agreement.is_trusted() { "" } else { "*" };
                let said = |found: &MapValues| match found.agreement.force_bandwidth_hz[0] {
                    hz if hz.is_nan() => format!("none{}", mark(found)),
                    hz => format!("{hz:.2}{}", mark(found)),
                };
                point.found.as_ref().map_or_else(|_| "-".to_owned(), said)
            };
            std::iter::once(plain(row[0].place_m[0])).chain(row.iter().map(value)).collect()
        })
        .collect();
    table(&header, &(1..header.len()).collect::<Vec<_>>(), rows)
}
