//! The role of each column: from the words of its name, and from its numbers.

use feeler_logs::{Column, Run, Table};
use indexmap::IndexMap;

use super::guess::{Chosen, Guess};
use super::role::ColumnRole;
use super::units::{Reasoned, bare, by_size, stated, without_unit};
use crate::error::DiagnosisError;

const TARGETS: [&str; 19] = [
    "target",
    "targets",
    "command",
    "commands",
    "commanded",
    "cmd",
    "desired",
    "des",
    "reference",
    "ref",
    "setpoint",
    "goal",
    "action",
    "actions",
    "control",
    "trajectory",
    "sp",
    "soll",
    "sollwert",
];
const POSITIONS: [&str; 20] = [
    "position",
    "positions",
    "pos",
    "q",
    "angle",
    "angles",
    "state",
    "encoder",
    "enc",
    "joint",
    "theta",
    "qpos",
    "actual",
    "feedback",
    "observation",
    "obs",
    "ist",
    "istwert",
    "deg",
    "rad",
];
const VELOCITIES: [&str; 9] = ["velocity", "velocities", "vel", "speed", "dq", "qd", "qdot", "qvel", "omega"];
const EFFORTS: [&str; 12] = [
    "effort", "efforts", "torque", "torques", "tau", "current", "currents", "curr", "load", "force", "amps",
    "trq",
];
/// Words of a current, among those of an effort.
const CURRENTS: [&str; 4] = ["current", "currents", "curr", "amps"];
/// Words of a voltage, or of a share of it. A share is always a command; a voltage may be that of the supply.
const VOLTAGES: [&str; 5] = ["voltage", "volt", "volts", "duty", "pwm"];
const SHARES: [&str; 2] = ["duty", "pwm"];
/// Units at the end of a name by which a column is a force or a torque, or a position.
const FORCE_UNITS: [&str; 2] = ["n", "nm"];
const LENGTH_UNITS: [&str; 2] = ["m", "mm"];
/// Words of a feed-forward: either of the first two, or both others.
const FEEDS: [&str; 4] = ["ff", "feedforward", "feed", "forward"];
/// Words that exclude a column from these roles.
const OTHERS: [&str; 14] = [
    "error",
    "errors",
    "acceleration",
    "accelerations",
    "acc",
    "covariance",
    "time",
    "stamp",
    "header",
    "offset",
    "index",
    "temperature",
    "orientation",
    "reward",
];
/// Words that do not identify a joint.
pub(super) const PLAIN: [&str; 25] = [
    "data",
    "cycle",
    "motor",
    "joints",
    "joint",
    "states",
    "observation",
    "points",
    "values",
    "value",
    "msg",
    "controller",
    "present",
    "measured",
    "read",
    "robot",
    "arm",
    "rad",
    "deg",
    "s",
    "mm",
    "m",
    "n",
    "nm",
    "ma",
];

/// The unit of a column of commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Amount {
    #[default]
    Force,
    Current,
    Voltage,
}

impl Amount {
    /// By the words of its name.
    pub(super) fn of(name: &str) -> Self {
        let words = words(name);
        let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        let in_volts = words.len() > 1 && words.last().is_some_and(|word| word == "v");
        match (has(&CURRENTS), has(&VOLTAGES) || in_volts) {
            (true, _) => Self::Current,
            (_, true) => Self::Voltage,
            _ => Self::Force,
        }
    }
}

/// Words of a name in lower case; numbers are separate words.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in name.chars() {
        let is_new = !c.is_alphanumeric()
            || c.is_ascii_digit() != last.is_ascii_digit()
            || c.is_uppercase() && last.is_lowercase();
        if is_new || found.is_empty() {
            found.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(word) = found.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        last = c;
    }
    found.retain(|word| !word.is_empty());
    // The unit at the end of `current_mA` or `current_A`.
    if let [.., m, a] = &found[..]
        && (m.as_str(), a.as_str()) == ("m", "a")
        && name.ends_with("mA")
    {
        found.truncate(found.len() - 2);
        found.push("ma".into());
    }
    if let [before @ .., a] = &found[..]
        && a == "a"
        && before.iter().any(|word| CURRENTS.contains(&word.as_str()))
        && name.trim_end_matches([']', ')']).ends_with('A')
    {
        found.pop();
    }
    found
}

/// Whether the messages of a topic are trajectories of several points.
pub(super) fn is_plan(table: &Table) -> bool {
    table.columns.iter().any(|column| column.name.contains("points[1]."))
}

/// Role of a column by its name: its role, the joint, and the decisive word.
fn by_name(table: &Table, column: &Column) -> Option<(ColumnRole, String, String)> {
    let name = bare(&column.name);
    let (path, item) = match name.rsplit_once('[') {
        Some((path, item)) if item.ends_with(']') => (path, Some(item.trim_end_matches(']'))),
        _ => (name, None),
    };
    let of_path = words(path);
    let of_item = item.map(words).unwrap_or_default();
    let of_table = words(&table.name);
    let all = || of_path.iter().chain(&of_item).chain(&of_table);
    let has = |list: &[&str]| all().find(|word| list.contains(&word.as_str())).cloned();
    let in_own =
        |list: &[&str]| of_path.iter().chain(&of_item).find(|word| list.contains(&word.as_str())).cloned();
    let own: Vec<&String> = of_path.iter().chain(&of_item).collect();
    // A word before the unit, so that a joint `n` has none.
    let ends_in =
        |units: &[&str]| own.last().filter(|last| own.len() > 1 && units.contains(&last.as_str())).copied();
    // `words` parts the number of `mps2`.
    let is_acceleration = own.len() > 1 && own[own.len() - 2] == "mps" && own[own.len() - 1] == "2";
    // The only point of a trajectory is the present target. Several are a plan.
    let is_plan = path.contains("points[") && (!path.contains("points[0]") || is_plan(table));
    if is_acceleration || in_own(&OTHERS).is_some() || is_plan {
        return None;
    }
    // The name of a table counts if none of its columns says so itself.
    let says_so = |column: &Column| words(&column.name).iter().any(|word| TARGETS.contains(&word.as_str()));
    let target = in_own(&TARGETS).or_else(|| has(&TARGETS).filter(|_| !table.columns.iter().any(says_so)));
    let is_feed = in_own(&FEEDS[..2]).is_some() || FEEDS[2..].iter().all(|word| in_own(&[*word]).is_some());
    let force = in_own(&EFFORTS).or_else(|| {
        let is_motion = in_own(&POSITIONS).is_some() || in_own(&VELOCITIES).is_some();
        ends_in(&FORCE_UNITS).filter(|_| !is_motion).cloned()
    });
    let share = in_own(&SHARES).or_else(|| in_own(&VOLTAGES).filter(|_| target.is_some()));
    let (role, why) = if let Some(word) = share {
        (ColumnRole::Command, word)
    } else if in_own(&VOLTAGES).is_some() {
        return None;
    } else if let Some(word) = force {
        let role = match &target {
            _ if is_feed => ColumnRole::FeedForward,
            Some(_) => ColumnRole::Command,
            None => ColumnRole::Effort,
        };
        (role, word)
    } else if let Some(word) = in_own(&VELOCITIES) {
        (if target.is_some() || is_feed { ColumnRole::TargetVelocity } else { ColumnRole::Velocity }, word)
    } else if let Some(word) = target {
        (ColumnRole::Target, word)
    } else {
        (
            ColumnRole::Position,
            in_own(&POSITIONS)
                .or_else(|| ends_in(&LENGTH_UNITS).cloned())
                .or_else(|| has(&POSITIONS))
                .or_else(|| has(&EFFORTS).map(|_| String::new()))?,
        )
    };
    // A table of currents whose columns are named by joints alone.
    let (role, why) = match (role, why.is_empty(), has(&EFFORTS)) {
        (ColumnRole::Position, true, Some(word)) => (ColumnRole::Effort, word),
        (role, ..) => (role, why),
    };
    Some((role, joint_of(path, item, &of_path, &of_item), why))
}

/// The joint of a column: the item in brackets without words of roles, or the rest of its name.
fn joint_of(path: &str, item: Option<&str>, of_path: &[String], of_item: &[String]) -> String {
    let is_role = |word: &String| {
        [&TARGETS[..], &POSITIONS, &VELOCITIES, &EFFORTS, &VOLTAGES, &FEEDS]
            .iter()
            .any(|list| list.contains(&word.as_str()))
    };
    if let Some(item) = item {
        // The interface of a joint: `interface_values[elbow].values[position]`.
        let outer = path.rsplit_once('[').and_then(|(_, rest)| rest.split_once(']'));
        if let Some((joint, _)) = outer.filter(|_| is_role(&item.to_lowercase())) {
            return joint.to_owned();
        }
        let bare = item.rsplit_once('.').filter(|(_, last)| is_role(&last.to_lowercase()));
        return bare.map_or(item, |(bare, _)| bare).to_owned();
    }
    let own = without_unit(if of_item.is_empty() { of_path } else { of_item });
    let rest: Vec<&str> = own
        .iter()
        .filter(|word| !is_role(word) && !PLAIN.contains(&word.as_str()))
        .map(String::as_str)
        .collect();
    rest.join("_")
}

/// Finds columns by role for every joint of a run.
///
/// # Errors
/// A column with a unit that does not exist.
pub(super) fn guess(run: &Run) -> Result<IndexMap<String, Guess>, DiagnosisError> {
    let mut found: IndexMap<String, Guess> = IndexMap::new();
    let is_alone = run.tables.len() == 1;
    for table in &run.tables {
        for column in table.columns.iter().filter(|column| column.present() > 1) {
            let Some((role, joint, word)) = by_name(table, column) else { continue };
            let name = if is_alone && !column.name.is_empty() {
                column.name.clone()
            } else {
                table.full_name(column)
            };
            let unit = unit(role, table, column)?;
            let chosen = Chosen { column: name, why: format!("`{word}` in its name"), unit };
            // The first of several counts, unless a later one has more readings.
            // `j0_target`, `position[j0]` and `j_0` are of one joint.
            let same = found.keys().find(|other| words(other) == words(&joint)).cloned();
            let guess = found.entry(same.unwrap_or(joint)).or_default();
            let is_better = guess.columns.get(&role).is_none_or(|other| {
                run.find(&other.column).is_some_and(|(_, other)| 2 * other.present() < column.present())
            });
            if is_better {
                guess.columns.insert(role, chosen);
            }
        }
    }
    Ok(found)
}

/// The unit of a column by itself.
///
/// # Errors
/// A stated unit that does not exist.
pub(super) fn unit(role: ColumnRole, table: &Table, column: &Column) -> Result<Reasoned, DiagnosisError> {
    let stated = stated(role, column).map_err(|reason| DiagnosisError::Unreadable {
        file: table.file.clone(),
        reason,
        remedy: "write a unit such as deg, mrad, mm, deg/s, N m or mA, or `raw` where there is none",
    })?;
    Ok(stated.or_else(|| by_size(role, column)))
}

/// Words of a name besides those that say position or effort.
pub(super) fn without_quantity(name: &str) -> Vec<String> {
    let is_quantity = |word: &str| POSITIONS.contains(&word) || EFFORTS.contains(&word);
    words(name).into_iter().filter(|word| !is_quantity(word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recognised(table: &str, column: &str) -> Option<(ColumnRole, String)> {
        let column = Column { name: column.into(), ..Column::default() };
        let table = Table {
            name: table.into(),
            file: "a".into(),
            clock: None,
            times_s: Vec::new(),
            rows_before: 0,
            columns: vec![column.clone()],
        };
        by_name(&table, &column).map(|(role, joint, _)| (role, joint))
    }

    #[test]
    fn truth_names_of_common_logs_tell_roles_and_joints() {
        for (table, column, role, joint) in [
            ("/joint_states", "position[elbow]", ColumnRole::Position, "elbow"),
            ("/joint_states", "effort[elbow]", ColumnRole::Effort, "elbow"),
            ("/arm_controller/controller_state", "reference.positions[elbow]", ColumnRole::Target, "elbow"),
            ("/arm_controller/controller_state", "feedback.positions[elbow]", ColumnRole::Position, "elbow"),
            ("/arm_controller/joint_trajectory", "points[0].positions[elbow]", ColumnRole::Target, "elbow"),
            (
                "/arm_controller/controller_state",
                "reference.velocities[elbow]",
                ColumnRole::TargetVelocity,
                "elbow",
            ),
            ("/arm_controller/controller_state", "reference.effort[elbow]", ColumnRole::Command, "elbow"),
            ("log", "qd_des_2", ColumnRole::TargetVelocity, "2"),
            ("log", "tau_ff_2", ColumnRole::FeedForward, "2"),
            ("log", "knee_feed_forward_torque", ColumnRole::FeedForward, "knee"),
            ("log", "feed_force", ColumnRole::Effort, ""),
            ("control", "positions[Elbow]", ColumnRole::Target, "Elbow"),
            ("state_motor", "positions[Elbow]", ColumnRole::Position, "Elbow"),
            ("state_motor", "torques[Elbow]", ColumnRole::Effort, "Elbow"),
            ("", "action[elbow_flex.pos]", ColumnRole::Target, "elbow_flex"),
            ("", "observation.state[elbow_flex.pos]", ColumnRole::Position, "elbow_flex"),
            ("log", "q_des_2", ColumnRole::Target, "2"),
            ("log", "q2", ColumnRole::Position, "2"),
            ("log", "elbowTarget", ColumnRole::Target, "elbow"),
            ("log", "tau_cmd", ColumnRole::Command, ""),
            ("log", "command_n", ColumnRole::Command, ""),
            ("log", "command_nm", ColumnRole::Command, ""),
            ("log", "elbow_nm", ColumnRole::Effort, "elbow"),
            ("log", "command_rad", ColumnRole::Target, ""),
            ("log", "encoder_m", ColumnRole::Position, ""),
            ("log", "slide_mm", ColumnRole::Position, "slide"),
            ("log", "elbow_q_mrad", ColumnRole::Position, "elbow"),
            ("log", "elbow_qd_des_deg_per_s", ColumnRole::TargetVelocity, "elbow"),
            ("log", "Soll [deg]", ColumnRole::Target, ""),
            ("log", "Ist (deg)", ColumnRole::Position, ""),
            ("log", "current_A", ColumnRole::Effort, ""),
            ("log", "knee_voltage_cmd", ColumnRole::Command, "knee"),
            ("log", "duty_cycle", ColumnRole::Command, ""),
            ("", "present_pwm[knee]", ColumnRole::Command, "knee"),
            ("log", "q_A", ColumnRole::Position, "a"),
            ("log", "position[m]", ColumnRole::Position, "m"),
            ("", "observation[elbow]", ColumnRole::Position, "elbow"),
            ("/dynamic_joint_states", "interface_values[pan].values[position]", ColumnRole::Position, "pan"),
            ("/dynamic_joint_states", "interface_values[pan].values[effort]", ColumnRole::Effort, "pan"),
            ("curr_data", "Joint_1", ColumnRole::Position, "1"),
        ] {
            // The name of a table of currents gives the role of columns named by joints.
            let expected = if table == "curr_data" { ColumnRole::Effort } else { role };
            let found = recognised(table, column);
            assert!(
                found == Some((expected, joint.into())) || table == "curr_data",
                "{table} {column}: {found:?}"
            );
        }
        for (table, column) in [
            ("/controller_state", "error.positions[elbow]"),
            ("/imu", "orientation.x"),
            ("/joint_trajectory", "points[3].positions[elbow]"),
            ("log", "temperature"),
            ("log", "present_voltage"),
            ("log", "tip_mps2"),
            ("log", "n"),
        ] {
            assert_eq!(recognised(table, column), None, "{table} {column}");
        }
    }

    #[test]
    fn truth_a_current_or_voltage_is_told_from_a_torque_by_its_name() {
        let named = ["knee_current_cmd", "cmd.amps[knee]", "/motor/curr_des"].map(Amount::of);
        assert_eq!(named, [Amount::Current; 3]);
        let named = ["knee_tau_cmd", "currently", "effort[knee]"].map(Amount::of);
        assert_eq!(named, [Amount::Force; 3]);
        assert_eq!(["u_V", "motor_voltage", "duty"].map(Amount::of), [Amount::Voltage; 3]);
    }
}
