//! The sweep files reproduce results of the paper. Tasks of a scheduler give the same bytes as one run.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read or run fails the test that asks for it")]

use std::path::{Path, PathBuf};

use feeler_analysis::ControlLoop;
use feeler_files::Setting;
use feeler_studies::operating_point::contact_view;
use feeler_studies::run::Outcome;
use feeler_studies::sweep::{DrawnAxis, Sweep, SweepColumn, SweepOptions, SweepTable, merge};

fn file(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios")).join("sweeps").join(name)
}

fn results(sweep: &Sweep) -> SweepTable {
    let folder = tempfile::tempdir().unwrap();
    let result = sweep.run(folder.path(), SweepOptions::default(), &|_| {}).unwrap();
    SweepTable::read(&result.table.unwrap()).unwrap()
}

/// Whether a variant comes to rest, or still decays.
fn rests(table: &SweepTable, row: usize) -> bool {
    let text = |column: &str| table.texts(column).unwrap()[row].clone().unwrap_or_default();
    let outcome = text("outcome");
    Outcome::ALL.iter().any(|(known, name)| *name == outcome && known.is_stable())
        || text("undecided") == "still-decaying"
}

/// For each value of the first axis: the index of the first gain that does not come to rest. With it the
/// first limit of linear theory, on the scale of this index.
fn edges(sweep: &Sweep, table: &SweepTable, rows: &[usize]) -> Vec<(f64, f64)> {
    let axes = DrawnAxis::of(&sweep.file);
    let [across, gain] = &axes[..] else { panic!("two axes") };
    let (sections, gains) = (across.points.unwrap() as usize, gain.points.unwrap() as usize);
    let of_section = |section: usize| {
        let at = across.value(section as f64 / (sections - 1) as f64);
        let clamped = ("contacts.tool.engagement", Setting::Text("clamped".into()));
        let scenario =
            sweep.document.with([(across.key.as_str(), Setting::Number(at)), clamped]).unwrap().scenario;
        let limit = ControlLoop::new(&scenario, &contact_view(&scenario))
            .unwrap()
            .sampled_bands(&gain.key)
            .unwrap()
            .first_upper();
        let edge = (0..gains).find(|i| !rests(table, rows[section * gains + i])).unwrap_or(gains);
        // A limit outside the map agrees if all gains of the map come to rest.
        (edge as f64, (gain.share(limit) * (gains - 1) as f64).min(gains as f64))
    };
    (0..sections).map(of_section).collect()
}

/// Claims 1, 2 and 3. If the tool is clamped, the first gain that does not come to rest lies within one cell
/// of the sampled linear limit.
#[test]
fn reference_the_simulated_boundary_is_within_a_cell_of_the_sampled_one() {
    for name in [
        "actuator-bandwidth",
        "transmission-stiffness",
        "base-damping",
        "workpiece-damping",
        "workpiece-stiffness",
    ] {
        let sweep = Sweep::load(&file(&format!("{name}.toml"))).unwrap();
        let table = results(&sweep);
        let rows: Vec<usize> = (0..table.rows).collect();
        let gains = DrawnAxis::of(&sweep.file)[1].points.unwrap() as f64;
        let mut met = 0;
        for (edge, theory) in edges(&sweep, &table, &rows) {
            // Even if both limits are equal, the first gain beyond them is up to a cell away.
            let distance = edge - theory;
            assert!(
                (-1.0..=1.0).contains(&distance),
                "{name}: gain number {edge} is the first not to rest, and the limit lies at {theory}"
            );
            met += usize::from(theory < gains - 1.0);
        }
        assert!(met >= 4, "{name}: the limit crosses the map at {met} places only");
    }
}

/// Chatter of a clamped tool begins at the limit. If the tool can leave the wall, it begins below the limit.
#[test]
fn truth_loss_of_contact_brings_chatter_below_the_linear_limit() {
    let sweep = Sweep::load(&file("loss-of-contact.toml")).unwrap();
    let table = results(&sweep);
    let engagements = table.texts("contacts.tool.engagement").unwrap();
    let below = |name: &str| {
        let rows: Vec<usize> =
            (0..table.rows).filter(|row| engagements[*row].as_deref() == Some(name)).collect();
        edges(&sweep, &table, &rows).into_iter().map(|(edge, theory)| theory - edge).collect::<Vec<_>>()
    };
    assert!(below("clamped").iter().all(|cells| cells.abs() <= 1.0), "{:?}", below("clamped"));
    // A cell is a fortieth of the limit, and chatter begins at four fifths of the limit.
    assert!(below("unilateral").iter().all(|cells| (6.0..11.0).contains(cells)), "{:?}", below("unilateral"));
}

/// The static friction level must be above the level in motion. Two of four combinations are therefore rows
/// with errors.
#[test]
fn regress_values_that_only_some_combinations_allow_are_rows_with_errors() {
    let parse = |coulomb: &str| {
        let text = format!(
            "scenario = \"../chatter/stiction.toml\"\n[axes]\n\
             \"springs.guide.effects.stribeck-friction.static\" = [\"50 N\", \"20 N\"]\n\
             \"springs.guide.effects.stribeck-friction.coulomb\" = [{coulomb}]\n\
             \"run.duration\" = [\"20 ms\"]\n"
        );
        Sweep::parse(&text, &file("levels.toml").display().to_string())
    };
    let table = results(&parse("\"35 N\", \"45 N\"").unwrap());
    let errors: Vec<&str> =
        table.texts("error").unwrap().iter().map(|error| error.as_deref().unwrap_or_default()).collect();
    assert_eq!(
        errors.iter().map(|error| error.contains("below `coulomb`")).collect::<Vec<_>>(),
        [false, false, true, true],
        "{errors:?}"
    );
    // 60 N is above every static level of the sweep.
    let refused = parse("\"35 N\", \"60 N\"").unwrap_err().to_string();
    assert!(refused.contains("with \"60 N\"") && !refused.contains("35 N\":"), "{refused}");
}

#[test]
fn truth_refinement_finds_the_edge_of_the_fine_grid_for_a_part_of_its_runs() {
    let text = "scenario = \"../paper/flexible.toml\"\n[axes]\n\
                \"contacts.tool.stiffness\" = { log = [5e4, 2e6], points = 5 }\n\
                \"controllers.force.kp\" = { log = [0.1, 8.0], points = 5 }\n\
                [refine]\nlevels = 2\n";
    let name = file("refined.toml").display().to_string();
    let refined = Sweep::parse(text, &name).unwrap();
    let fine = text.replace("points = 5", "points = 17").replace("[refine]\nlevels = 2\n", "");
    let fine = Sweep::parse(&fine, &name).unwrap();
    let (few, all) = (results(&refined), results(&fine));
    assert_eq!(refined.runs_of_the_grid(), Some(all.rows as u64));
    assert!(few.rows < all.rows * 2 / 3, "{} of {}", few.rows, all.rows);
    // If two neighbours on the fine grid differ, the refined sweep has both with the same outcomes.
    let number = |table: &SweepTable, key: &str, row: usize| table.reals(key).unwrap()[row].unwrap();
    let known = |kp: f64, stiffness: f64| {
        (0..few.rows).find(|&row| {
            (number(&few, "controllers.force.kp", row) / kp - 1.0).abs() < 1e-9
                && (number(&few, "contacts.tool.stiffness", row) / stiffness - 1.0).abs() < 1e-9
        })
    };
    for row in 0..all.rows - 1 {
        if row % 17 == 16 || rests(&all, row) == rests(&all, row + 1) {
            continue;
        }
        for row in [row, row + 1] {
            let found = known(
                number(&all, "controllers.force.kp", row),
                number(&all, "contacts.tool.stiffness", row),
            )
            .unwrap();
            assert_eq!(rests(&few, found), rests(&all, row));
        }
    }
}

/// Every part starts twice, as under a scheduler that restarts tasks. Whole runs and merges run at the same
/// time.
#[test]
fn prop_parts_runs_and_merges_at_once_in_one_folder_all_end_with_the_same_bytes() {
    let text = "scenario = \"../paper/rigid.toml\"\n[axes]\n\
                \"controllers.force.kp\" = { linear = [0.1, 1.0], points = 64 }\n\
                \"run.duration\" = [\"20 ms\"]\n[keep]\ntail = 0\n";
    let sweep = Sweep::parse(text, &file("shards.toml").display().to_string()).unwrap();
    let alone = tempfile::tempdir().unwrap();
    let bytes = |folder: &Path| std::fs::read(folder.join("sweep.parquet")).unwrap();
    sweep.run(alone.path(), SweepOptions::default(), &|_| {}).unwrap();
    for _ in 0..5 {
        let shared = tempfile::tempdir().unwrap();
        let folder = shared.path();
        let run = |shard: Option<&str>| {
            let shard = shard.map(|shard| shard.parse().unwrap());
            sweep.run(folder, SweepOptions { threads: Some(1), shard }, &|_| {}).unwrap()
        };
        std::thread::scope(|scope| {
            for shard in ["1/4", "2/4", "3/4", "4/4"].into_iter().cycle().take(8) {
                scope.spawn(move || run(Some(shard)));
            }
            for _ in 0..2 {
                scope.spawn(|| assert!(run(None).table.is_some()));
                // A merge is an error until all chunks exist.
                scope.spawn(|| while merge(&[folder.into()], folder).is_err() {});
            }
        });
        assert!(
            bytes(folder) == bytes(alone.path()),
            "the parts in one folder do not give the bytes of one run"
        );
        assert!(!folder.join("chunks").exists());
        merge(&[folder.into()], &folder.join("elsewhere")).unwrap();
        assert!(
            bytes(&folder.join("elsewhere")) == bytes(folder),
            "a merge of a finished sweep takes its results"
        );
        let late = run(Some("2/4"));
        assert_eq!((late.progress.done, late.table), (0, Some(folder.join("sweep.parquet"))));
    }
}

/// Values without a valid machine become rows with their error. The other variants run.
#[test]
fn truth_a_variant_that_fails_is_a_row() {
    let text = "scenario = \"../paper/rigid.toml\"\nsampling = \"latin-hypercube\"\nsamples = 20\n[axes]\n\
                \"bodies.motor.mass\" = { uniform = [1.0, 12.0] }\n\
                \"controllers.force.low_pass\" = { uniform = [1.0, 499.0] }\n";
    let sweep = Sweep::parse(text, &file("failing.toml").display().to_string()).unwrap();
    let mut failing = sweep.clone();
    failing.file.axes["bodies.motor.mass"] = feeler_files::SweepAxis::Uniform { from: -12.0, to: 12.0 };
    let table = results(&failing);
    let SweepColumn::Real(masses) = &table.columns["bodies.motor.mass"] else { panic!("numbers") };
    for (mass, error) in masses.iter().zip(table.texts("error").unwrap()) {
        assert_eq!(mass.unwrap() <= 0.0, error.is_some(), "{mass:?}: {error:?}");
    }
    assert_eq!(table.texts("error").unwrap().iter().flatten().count(), 10);
}

/// The gain has a tolerance of a thousandth of its range, the stiffness one that its coarse grid already
/// meets. Only the gain is bisected, at the three values of the stiffness. The coarse grid has 15 variants.
/// Each of eight bisections adds at most two columns of three variants at each of three stiffnesses.
#[test]
fn regress_an_axis_at_its_tolerance_is_not_made_finer() {
    let text = "scenario = \"../paper/flexible.toml\"\n[axes]\n\
                \"contacts.tool.stiffness\" = { log = [1e5, 4e5], points = 3, tolerance = 2.0 }\n\
                \"controllers.force.kp\" = { linear = [0.5, 4.5], points = 5, tolerance = 0.004 }\n\
                [refine]\n";
    let sweep = Sweep::parse(text, &file("refined.toml").display().to_string()).unwrap();
    let table = results(&sweep);
    assert!(table.rows <= 15 + 2 * 3 * 3 * 8, "{}", table.rows);
    let number = |key: &str, row: usize| table.reals(key).unwrap()[row].unwrap();
    for stiffness in [1e5, 2e5, 4e5] {
        let mut column: Vec<usize> = (0..table.rows)
            .filter(|&row| (number("contacts.tool.stiffness", row) / stiffness - 1.0).abs() < 1e-9)
            .collect();
        column.sort_by(|&a, &b| {
            number("controllers.force.kp", a).total_cmp(&number("controllers.force.kp", b))
        });
        let edge = column.windows(2).find(|pair| rests(&table, pair[0]) != rests(&table, pair[1])).unwrap();
        let width = number("controllers.force.kp", edge[1]) - number("controllers.force.kp", edge[0]);
        assert!(width <= 0.004, "{stiffness}: {width}");
    }
}
