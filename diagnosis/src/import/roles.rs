//! The role of each column: from the words of its name, and from its numbers.

use feeler_logs::{Column, Run, Table};
use indexmap::IndexMap;

use super::follow::{Follow, follow};
use super::role::Role;
use super::units::{UnitGuess, unit};

/// A column that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Its name in the run.
    pub column: String,
    /// Why.
    pub why: String,
    /// The apparent unit of its numbers, and the reason; `None` for SI.
    pub unit: Option<(UnitGuess, String)>,
}

impl Chosen {
    /// One of its numbers in SI.
    pub(super) fn in_si(&self) -> f64 {
        self.unit.as_ref().map_or(1.0, |(unit, _)| unit.in_si())
    }
}

/// Findings on a joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guess {
    /// Columns by role.
    pub columns: IndexMap<Role, Chosen>,
    /// How the position follows the target, if both exist.
    pub follow: Option<Follow>,
}

const TARGETS: [&str; 17] = [
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
];
const POSITIONS: [&str; 16] = [
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
/// Units at the end of a name by which a column is a force or a torque, or a position.
const FORCE_UNITS: [&str; 2] = ["n", "nm"];
const LENGTH_UNITS: [&str; 2] = ["m", "mm"];
/// Words of a feed-forward: either of the first two, or both others.
const FEEDS: [&str; 4] = ["ff", "feedforward", "feed", "forward"];
/// Words by which a column has none of these roles.
const OTHERS: [&str; 15] = [
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
    "voltage",
    "orientation",
    "reward",
];
/// Words that do not identify a joint.
pub(super) const PLAIN: [&str; 23] = [
    "data",
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
];

/// Whether a column of efforts is one of currents, by its name.
pub(super) fn is_current(name: &str) -> bool {
    words(name).iter().any(|word| CURRENTS.contains(&word.as_str()))
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
    found
}

/// Role of a column by its name: its role, the joint, and the decisive word.
fn by_name(table: &Table, column: &Column) -> Option<(Role, String, String)> {
    let (path, item) = match column.name.rsplit_once('[') {
        Some((path, item)) if item.ends_with(']') => (path, Some(item.trim_end_matches(']'))),
        _ => (column.name.as_str(), None),
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
    // The last item of a trajectory's points is a plan, and its first one is the present target.
    if is_acceleration || in_own(&OTHERS).is_some() || path.contains("points[") && !path.contains("points[0]")
    {
        return None;
    }
    let target = has(&TARGETS);
    let is_feed = in_own(&FEEDS[..2]).is_some() || FEEDS[2..].iter().all(|word| in_own(&[*word]).is_some());
    let force = in_own(&EFFORTS).or_else(|| {
        let is_motion = in_own(&POSITIONS).is_some() || in_own(&VELOCITIES).is_some();
        ends_in(&FORCE_UNITS).filter(|_| !is_motion).cloned()
    });
    let (role, why) = if let Some(word) = force {
        let role = match &target {
            _ if is_feed => Role::FeedForward,
            Some(_) => Role::Command,
            None => Role::Effort,
        };
        (role, word)
    } else if let Some(word) = in_own(&VELOCITIES) {
        (if target.is_some() || is_feed { Role::TargetVelocity } else { Role::Velocity }, word)
    } else if let Some(word) = target {
        (Role::Target, word)
    } else {
        (
            Role::Position,
            in_own(&POSITIONS)
                .or_else(|| ends_in(&LENGTH_UNITS).cloned())
                .or_else(|| has(&POSITIONS))
                .or_else(|| has(&EFFORTS).map(|_| String::new()))?,
        )
    };
    // A table of currents whose columns are named by joints alone.
    let (role, why) = match (role, why.is_empty(), has(&EFFORTS)) {
        (Role::Position, true, Some(word)) => (Role::Effort, word),
        (role, ..) => (role, why),
    };
    Some((role, joint_of(item, &of_path, &of_item), why))
}

/// The joint of a column: the item in brackets without words of roles, or the rest of its name.
fn joint_of(item: Option<&str>, of_path: &[String], of_item: &[String]) -> String {
    let is_role = |word: &String| {
        [&TARGETS[..], &POSITIONS, &VELOCITIES, &EFFORTS, &FEEDS]
            .iter()
            .any(|list| list.contains(&word.as_str()))
    };
    if let Some(item) = item {
        let bare = item.rsplit_once('.').filter(|(_, last)| is_role(&last.to_lowercase()));
        return bare.map_or(item, |(bare, _)| bare).to_owned();
    }
    let own = if of_item.is_empty() { of_path } else { of_item };
    let rest: Vec<&str> = own
        .iter()
        .filter(|word| !is_role(word) && !PLAIN.contains(&word.as_str()))
        .map(String::as_str)
        .collect();
    rest.join("_")
}

/// Finds columns by role for every joint of a run; those stated by the user have priority.
pub(super) fn guess(run: &Run, stated: &[(Role, String)]) -> IndexMap<String, Guess> {
    let mut found: IndexMap<String, Guess> = IndexMap::new();
    let is_alone = run.tables.len() == 1;
    if !stated.is_empty() {
        let guess = found.entry(String::new()).or_default();
        for (role, column) in stated {
            if let Some((_, numbers)) = run.find(column) {
                let why = "it is stated".to_owned();
                let unit = unit(*role, numbers);
                guess.columns.insert(*role, Chosen { column: column.clone(), why, unit });
            }
        }
    }
    for table in if stated.is_empty() { run.tables.as_slice() } else { &[] } {
        for column in table.columns.iter().filter(|column| column.present() > 1) {
            let Some((role, joint, word)) = by_name(table, column) else { continue };
            let name = if is_alone && !column.name.is_empty() {
                column.name.clone()
            } else {
                table.full_name(column)
            };
            let chosen =
                Chosen { column: name, why: format!("`{word}` in its name"), unit: unit(role, column) };
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
    for guess in found.values_mut() {
        if stated.is_empty() {
            inputs_beside_target(run, guess);
        }
        let of = |role| guess.columns.get(&role).and_then(|chosen| run.find(&chosen.column));
        if let (Some(target), Some(position)) = (of(Role::Target), of(Role::Position)) {
            guess.follow = follow(target, position);
        }
    }
    found
}

/// Keeps the speed and the force beside a target that reach the servo with it: those of the same table that
/// change. A message with positions and efforts of targets gives the efforts as feed-forward.
fn inputs_beside_target(run: &Run, guess: &mut Guess) {
    let target = column_of(run, guess, Role::Target);
    let is_beside = |(table, column): &(&Table, &Column)| {
        let mut values = column.values.iter().filter(|x| x.is_finite());
        let first = values.next();
        target.is_some_and(|(of, _)| std::ptr::eq(of, *table)) && values.any(|x| Some(x) != first)
    };
    if let (Some(beside), Some((_, wanted))) =
        (column_of(run, guess, Role::Command).filter(is_beside), target)
        && beside.1.name.ends_with(']')
        && without_quantity(&beside.1.name) == without_quantity(&wanted.name)
        && !guess.columns.contains_key(&Role::FeedForward)
        && let Some(command) = guess.columns.shift_remove(&Role::Command)
    {
        guess.columns.insert(Role::FeedForward, command);
    }
    for role in [Role::TargetVelocity, Role::FeedForward] {
        if column_of(run, guess, role).is_none_or(|column| !is_beside(&column)) {
            guess.columns.shift_remove(&role);
        }
    }
    let of_target = guess.columns.get(&Role::Target).and_then(|chosen| chosen.unit.clone());
    if let (Some((unit, _)), Some(speed)) = (of_target, guess.columns.get_mut(&Role::TargetVelocity)) {
        speed.unit.get_or_insert_with(|| (unit.per_second(), "as its target is".into()));
    }
}

fn column_of<'a>(run: &'a Run, guess: &Guess, role: Role) -> Option<(&'a Table, &'a Column)> {
    run.find(&guess.columns.get(&role)?.column)
}

/// Words of a name besides those that say position or effort.
fn without_quantity(name: &str) -> Vec<String> {
    let is_quantity = |word: &str| POSITIONS.contains(&word) || EFFORTS.contains(&word);
    words(name).into_iter().filter(|word| !is_quantity(word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(table: &str, column: &str) -> Option<(Role, String)> {
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
            ("/joint_states", "position[elbow]", Role::Position, "elbow"),
            ("/joint_states", "effort[elbow]", Role::Effort, "elbow"),
            ("/arm_controller/controller_state", "reference.positions[elbow]", Role::Target, "elbow"),
            ("/arm_controller/controller_state", "feedback.positions[elbow]", Role::Position, "elbow"),
            ("/arm_controller/joint_trajectory", "points[0].positions[elbow]", Role::Target, "elbow"),
            (
                "/arm_controller/controller_state",
                "reference.velocities[elbow]",
                Role::TargetVelocity,
                "elbow",
            ),
            ("/arm_controller/controller_state", "reference.effort[elbow]", Role::Command, "elbow"),
            ("log", "qd_des_2", Role::TargetVelocity, "2"),
            ("log", "tau_ff_2", Role::FeedForward, "2"),
            ("log", "knee_feed_forward_torque", Role::FeedForward, "knee"),
            ("log", "feed_force", Role::Effort, ""),
            ("control", "positions[Elbow]", Role::Target, "Elbow"),
            ("state_motor", "positions[Elbow]", Role::Position, "Elbow"),
            ("state_motor", "torques[Elbow]", Role::Effort, "Elbow"),
            ("", "action[elbow_flex.pos]", Role::Target, "elbow_flex"),
            ("", "observation.state[elbow_flex.pos]", Role::Position, "elbow_flex"),
            ("log", "q_des_2", Role::Target, "2"),
            ("log", "q2", Role::Position, "2"),
            ("log", "elbowTarget", Role::Target, "elbow"),
            ("log", "tau_cmd", Role::Command, ""),
            ("log", "command_n", Role::Command, ""),
            ("log", "command_nm", Role::Command, ""),
            ("log", "elbow_nm", Role::Effort, "elbow"),
            ("log", "command_rad", Role::Target, ""),
            ("log", "encoder_m", Role::Position, ""),
            ("log", "slide_mm", Role::Position, "slide"),
            ("curr_data", "Joint_1", Role::Position, "1"),
        ] {
            // The name of a table of currents gives the role of columns named by joints.
            let expected = if table == "curr_data" { Role::Effort } else { role };
            let found = told(table, column);
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
            ("log", "tip_mps2"),
            ("log", "n"),
        ] {
            assert_eq!(told(table, column), None, "{table} {column}");
        }
    }

    #[test]
    fn truth_a_current_is_told_from_a_torque_by_its_name() {
        let named = ["knee_current_cmd", "cmd.amps[knee]", "/motor/curr_des"].map(is_current);
        assert_eq!(named, [true; 3]);
        assert_eq!(["knee_tau_cmd", "currently", "effort[knee]"].map(is_current), [false; 3]);
    }
}
