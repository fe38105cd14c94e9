//! The columns of one joint, compared with each other: which belong together, and their units.

use feeler_logs::{Column, Run, Table};
use indexmap::IndexMap;

use super::follow::follow;
use super::guess::Guess;
use super::role::ColumnRole;
use super::roles::without_quantity;
use super::units::{beside, stated};

/// Largest factor between a target and the position that follows: a loop too slow for its target moves less.
const APART: f64 = 5.0;
/// How much less every other pair of columns must be alike, for two to belong together by their motion.
const CLEARLY_LESS: f64 = 0.05;

/// Pairs targets and positions. Columns that the user chose (`is_chosen`) stay as they are.
pub(super) fn pair(run: &Run, found: &mut IndexMap<String, Guess>, is_chosen: bool) {
    if !is_chosen {
        pair_lone_columns(found);
        pair_by_motion(run, found);
    }
    for guess in found.values_mut() {
        if !is_chosen {
            inputs_beside_target(run, guess);
        }
        let (target, position) =
            (column_of(run, guess, ColumnRole::Target), column_of(run, guess, ColumnRole::Position));
        if let (Some(target), Some(position)) = (target, position) {
            guess.follow = follow(target, position);
            let are_stated = [(ColumnRole::Target, target.1), (ColumnRole::Position, position.1)]
                .map(|(role, column)| matches!(stated(role, column), Ok(Some(_))));
            unit_by_the_other(guess, are_stated);
        }
    }
}

/// If one joint has the only target, one other the only position, and either has no name, both are one.
fn pair_lone_columns(found: &mut IndexMap<String, Guess>) {
    let only = |role: ColumnRole| {
        let mut having = found.iter().filter(|(_, guess)| guess.columns.contains_key(&role));
        having.next().filter(|_| having.next().is_none()).map(|(joint, _)| joint.clone())
    };
    if let (Some(target), Some(position)) = (only(ColumnRole::Target), only(ColumnRole::Position))
        && target != position
        && (target.is_empty() || position.is_empty())
        && let Some(lone) = found.shift_remove(&target)
        && let Some(guess) = found.get_mut(&position)
    {
        for (role, chosen) in lone.columns {
            guess.columns.entry(role).or_insert(chosen);
        }
    }
}

/// Targets without names (`/commands.data[0]`) belong to the positions that follow each of them alone.
fn pair_by_motion(run: &Run, found: &mut IndexMap<String, Guess>) {
    let having = |role: ColumnRole, without: ColumnRole| {
        let has = |guess: &Guess, role: ColumnRole| guess.columns.contains_key(&role);
        let joints = found.iter().filter(|(_, guess)| has(guess, role) && !has(guess, without));
        joints.map(|(joint, _)| joint.clone()).collect::<Vec<String>>()
    };
    let mut targets = having(ColumnRole::Target, ColumnRole::Position);
    targets.retain(|joint| joint.chars().all(|c| c.is_ascii_digit()));
    let positions = having(ColumnRole::Position, ColumnRole::Target);
    let likeness = |target: &String, position: &String| {
        let target = column_of(run, &found[target], ColumnRole::Target)?;
        let motion = follow(target, column_of(run, &found[position], ColumnRole::Position)?)?;
        Some(motion.correlation.abs()).filter(|_| motion.is_of_one_motion())
    };
    let alike: Vec<Vec<f64>> = (targets.iter())
        .map(|target| positions.iter().map(|position| likeness(target, position).unwrap_or(0.0)).collect())
        .collect();
    let is_clear = |i: usize, j: usize| {
        let rivals = (0..alike.len()).flat_map(|k| (0..positions.len()).map(move |l| (k, l)));
        let mut rivals = rivals.filter(|(k, l)| (*k == i) != (*l == j));
        alike[i][j] > 0.0 && rivals.all(|(k, l)| alike[k][l] < alike[i][j] - CLEARLY_LESS)
    };
    for (i, target) in targets.iter().enumerate() {
        let Some(j) = (0..positions.len()).find(|j| is_clear(i, *j)) else { continue };
        let Some(mut chosen) = found[target].columns.get(&ColumnRole::Target).cloned() else { continue };
        chosen.why = format!("{}; it names no joint, and this one alone moves as it does", chosen.why);
        if let Some(guess) = found.get_mut(&positions[j]) {
            guess.columns.insert(ColumnRole::Target, chosen);
            found.shift_remove(target);
        }
    }
}

/// Of a target and what follows it, gives the one of no stated unit the unit that makes them one motion.
fn unit_by_the_other(guess: &mut Guess, are_stated: [bool; 2]) {
    let Some(follow) = guess.follow.filter(|follow| follow.is_of_one_motion()) else { return };
    let (Some(target), Some(position)) =
        (guess.columns.get(&ColumnRole::Target), guess.columns.get(&ColumnRole::Position))
    else {
        return;
    };
    let times = follow.times * position.in_si() / target.in_si();
    if (1.0 / APART..APART).contains(&times) {
        return;
    }
    let sides = [
        (ColumnRole::Position, are_stated[1], follow.times / target.in_si(), target.column.clone()),
        (ColumnRole::Target, are_stated[0], 1.0 / (follow.times * position.in_si()), position.column.clone()),
    ];
    let mut open = sides.into_iter().filter(|(_, is_stated, ..)| !is_stated);
    let is_straight = guess.is_straight();
    let paired = open.find_map(|(role, _, times, other)| Some((role, beside(times, &other, is_straight)?)));
    if let Some((role, unit)) = paired
        && let Some(chosen) = guess.columns.get_mut(&role)
    {
        chosen.unit = Some(unit);
    }
}

/// Keeps the speed and the force beside a target that reach the servo with it: those of the same table that
/// change. A message with positions and efforts of targets gives the efforts as feed-forward.
fn inputs_beside_target(run: &Run, guess: &mut Guess) {
    let target = column_of(run, guess, ColumnRole::Target);
    let is_beside = |(table, column): &(&Table, &Column)| {
        let mut values = column.values.iter().filter(|x| x.is_finite());
        let first = values.next();
        target.is_some_and(|(of, _)| std::ptr::eq(of, *table)) && values.any(|x| Some(x) != first)
    };
    if let (Some(beside), Some((_, wanted))) =
        (column_of(run, guess, ColumnRole::Command).filter(is_beside), target)
        && beside.1.name.ends_with(']')
        && without_quantity(&beside.1.name) == without_quantity(&wanted.name)
        && !guess.columns.contains_key(&ColumnRole::FeedForward)
        && let Some(command) = guess.columns.shift_remove(&ColumnRole::Command)
    {
        guess.columns.insert(ColumnRole::FeedForward, command);
    }
    for role in [ColumnRole::TargetVelocity, ColumnRole::FeedForward] {
        if column_of(run, guess, role).is_none_or(|column| !is_beside(&column)) {
            guess.columns.shift_remove(&role);
        }
    }
    let of_target = guess.columns.get(&ColumnRole::Target).and_then(|chosen| chosen.unit.clone());
    if let (Some((unit, _)), Some(speed)) = (of_target, guess.columns.get_mut(&ColumnRole::TargetVelocity)) {
        speed.unit.get_or_insert_with(|| (unit.per_second(), "as its target is".into()));
    }
}

fn column_of<'a>(run: &'a Run, guess: &Guess, role: ColumnRole) -> Option<(&'a Table, &'a Column)> {
    run.find(&guess.columns.get(&role)?.column)
}
