//! Requirements on every effect of the library: names, bounds, documentation, hosts, and that its null is the
//! ideal machine.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::Path;

use feeler_plant::assembly::{Assembly, assemble};
use feeler_plant::description::{
    Actuator, Body, Contact, Elements, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{
    BY_SYMPTOM, Change, Curve, Definition, EffectError, EffectUse, Host, HostKind, Kind, LIBRARY, Parameter,
    Place, find,
};

/// An axis on a base in front of a workpiece, with an element for every effect. It has bodies, rigid and
/// flexible springs, and sensors of all kinds.
fn machine() -> Machine {
    let body = |mass_kg| Body { mass_kg, ..Body::default() };
    let rigid = |a: &str, b: &str| Spring { between: [a.into(), b.into()], rigid: true, ..Spring::default() };
    let spring = |a: &str, b: &str, stiffness_n_per_m, damping_n_s_per_m| Spring {
        stiffness_n_per_m,
        damping_n_s_per_m,
        rigid: false,
        ..rigid(a, b)
    };
    let sensor = |element: &str, quantity| Sensor::ideal(SignalName::new(element, quantity));
    let tool = Contact { gap_m: 4e-3, ..Contact::kelvin_voigt("tip", "workpiece", 2e5, 120.0) };
    let drive = Actuator { limit_n: Some(400.0), ..Actuator::ideal("motor", "base") };
    Machine {
        name: "everything".into(),
        about: "an axis with an element for every effect".into(),
        bodies: elements([
            ("base", body(170.0)),
            ("motor", body(7.0)),
            ("wrist", body(3.0)),
            ("tip", body(4.0)),
            ("workpiece", body(2.5)),
        ]),
        springs: elements([
            ("mount", rigid(GROUND, "base")),
            ("guide", spring("base", "motor", 0.0, 55.0)),
            ("belt", spring("motor", "wrist", 1.1e6, 110.0)),
            ("flange", rigid("wrist", "tip")),
            ("fixture", rigid("base", "workpiece")),
            ("hose", spring(GROUND, "motor", 20.0, 1.0)),
        ]),
        contacts: elements([("tool", tool)]),
        actuators: elements([("drive", drive)]),
        sensors: elements([
            ("force", sensor("tool", Quantity::SpringForce)),
            ("encoder", sensor("motor", Quantity::Position)),
            ("monitor", sensor("drive", Quantity::Command)),
        ]),
        ..Machine::default()
    }
}

fn elements<T, const N: usize>(named: [(&str, T); N]) -> Elements<T> {
    named.into_iter().map(|(name, element)| (name.into(), element)).collect()
}

fn ideal() -> Assembly {
    assemble(&machine()).expect("the ideal machine is sound")
}

fn hosts(assembly: &Assembly) -> Vec<Host> {
    // Node 0 is ground, which is not an element.
    (1..assembly.nodes.len())
        .map(Host::Body)
        .chain((0..assembly.links.len()).map(Host::Spring))
        .chain((0..assembly.contacts.len()).map(Host::Contact))
        .chain((0..assembly.drives.len()).map(Host::Actuator))
        .chain((0..assembly.sensors.len()).map(Host::Sensor))
        .collect()
}

/// The effects that change a plant.
fn of_the_plant() -> impl Iterator<Item = &'static Definition> {
    LIBRARY.iter().copied().filter(|definition| matches!(definition.change, Change::Plant(_)))
}

fn typical(definition: &Definition) -> Vec<f64> {
    definition.parameters.iter().map(|parameter| parameter.default.unwrap_or(parameter.typical)).collect()
}

/// The machines that an effect with these values makes of the ideal one, by the hosts that accept it.
fn outcomes(definition: &Definition, values: &[f64]) -> Vec<(Host, Assembly)> {
    let ideal = ideal();
    let mut outcomes = Vec::new();
    for host in hosts(&ideal) {
        let mut changed = ideal.clone();
        match definition.apply(&mut changed, host, values) {
            Ok(()) => outcomes.push((host, changed)),
            Err(error) => {
                let refused = matches!(
                    error,
                    EffectError::WrongHost { .. }
                        | EffectError::WrongSite { .. }
                        | EffectError::MassExceeded { .. }
                );
                assert!(refused, "{} under {host:?}: {error}", definition.kind);
                assert_eq!(changed, ideal, "{} under {host:?} was refused but left a trace", definition.kind);
            }
        }
    }
    outcomes
}

fn section(definition: &Definition, title: &str) -> String {
    let page = definition.documentation();
    let (_, text) = page
        .split_once(&format!("## {title}\n"))
        .unwrap_or_else(|| panic!("{} has no section {title}", definition.kind));
    text.split("\n## ").next().unwrap_or(text).trim().to_owned()
}

/// Every kind that a text names in backticks.
fn kinds_named(text: &str) -> impl Iterator<Item = &str> {
    let is_kind =
        |quoted: &&str| quoted.contains('-') && quoted.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    text.split('`').skip(1).step_by(2).filter(is_kind)
}

/// Sections of an effect's page.
const SECTIONS: [&str; 7] = [
    "Example",
    "Model",
    "Where it comes from",
    "How it shows",
    "How it is recognised",
    "Numerical treatment",
    "Source",
];

#[test]
fn prop_documentation_has_its_sections_in_order() {
    for definition in LIBRARY {
        let page = definition.documentation();
        let titles: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("## ")).collect();
        assert_eq!(titles, SECTIONS, "{}", definition.kind);
        for title in titles {
            let is_sentence = section(definition, title).ends_with('.');
            assert!(is_sentence, "{}: {title} is not a sentence", definition.kind);
        }
        let source = section(definition, "Source");
        let years =
            source.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse::<u32>().ok());
        assert!(
            years.into_iter().any(|year| (1900..2100).contains(&year)),
            "{} names no dated work",
            definition.kind
        );
    }
}

#[test]
fn prop_documentation_names_look_alikes_that_exist() {
    for definition in LIBRARY {
        for kind in kinds_named(definition.sections) {
            assert!(find(kind).is_some(), "{} speaks of `{kind}`, which is not an effect", definition.kind);
        }
        let others =
            kinds_named(&section(definition, "How it shows")).filter(|kind| *kind != definition.name).count();
        assert!(others > 0, "{} names nothing that it is confused with", definition.kind);
    }
}

#[test]
fn prop_the_table_of_symptoms_names_effects_that_exist() {
    let unknown: Vec<&str> = kinds_named(BY_SYMPTOM).filter(|kind| find(kind).is_none()).collect();
    assert!(unknown.is_empty() && kinds_named(BY_SYMPTOM).next().is_some(), "{unknown:?}");
}

#[test]
fn prop_the_model_speaks_of_every_parameter() {
    for definition in LIBRARY {
        for parameter in definition.parameters {
            let model = section(definition, "Model");
            let words = model.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            // A row of parameters is named by its ends: `force_1` to `force_9`.
            let row = parameter.name.rsplit_once('_').filter(|(_, number)| number.parse::<u8>().is_ok());
            let is_in_row = row.is_some_and(|(name, _)| model.contains(&format!("`{name}_1` to `{name}_9`")));
            assert!(
                is_in_row || words.into_iter().any(|word| word == parameter.name),
                "{}: the model lacks `{}`",
                definition.kind,
                parameter.name
            );
        }
    }
}

#[test]
fn prop_a_law_is_drawn_within_its_box_and_differs_from_the_machine_without() {
    for definition in LIBRARY {
        let law = &definition.law;
        let points =
            |curves: &[Curve]| curves.iter().map(|curve| curve.points(law.start)).collect::<Vec<_>>();
        let (with, without) = (points(law.with), points(law.without));
        assert!(law.axes.iter().all(|axis| !axis.is_empty()) && !with.is_empty(), "{}", definition.kind);
        let names = |text: &str| definition.parameters.iter().any(|parameter| text.contains(parameter.name));
        let is_named = law.labels.iter().any(|(.., text)| names(text));
        assert!(is_named, "{}: its drawing names no parameter", definition.kind);
        assert!(with.iter().all(|curve| !without.contains(curve)), "{}", definition.kind);
        for &(across, up) in with.iter().chain(&without).flatten() {
            let within = (law.start..=1.0).contains(&across) && (-1.0..=1.0).contains(&up);
            assert!(within, "{}: ({across}, {up})", definition.kind);
        }
    }
}

#[test]
fn prop_bounds_contain_null_typical_and_default() {
    for definition in LIBRARY {
        assert!(!definition.parameters.is_empty(), "{}", definition.kind);
        for parameter in definition.parameters {
            let (low, high) = parameter.bounds;
            for value in [Some(parameter.typical), parameter.null, parameter.default].into_iter().flatten() {
                assert!(
                    (low..=high).contains(&value),
                    "{}.{}: {value} is out of bounds",
                    definition.kind,
                    parameter.name
                );
            }
            // A fit steps in units of the typical value.
            assert!(
                parameter.default.is_some() || parameter.typical != 0.0,
                "{}.{}",
                definition.kind,
                parameter.name
            );
            assert!(parameter.typical.is_finite() && low < high);
        }
    }
}

#[test]
fn prop_names_are_kebab_and_snake_case_and_unique() {
    let well_formed = |name: &str, joint: char| {
        name.split(joint).all(|word| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        })
    };
    let kinds: BTreeSet<&str> = LIBRARY.iter().map(|definition| definition.name).collect();
    assert_eq!(kinds.len(), LIBRARY.len());
    for definition in LIBRARY {
        assert!(well_formed(definition.name, '-'), "{}", definition.kind);
        let names: BTreeSet<&str> = definition.parameters.iter().map(|parameter| parameter.name).collect();
        assert_eq!(names.len(), definition.parameters.len(), "{}", definition.kind);
        assert!(names.iter().all(|name| well_formed(name, '_')), "{}", definition.kind);
    }
}

/// The effects as listed in the design: kind, places, and parameters with their units.
type Row = (String, BTreeSet<String>, Vec<(String, String)>);

fn rows_of_the_table(text: &str) -> Vec<Row> {
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let rows = text.lines().filter(|line| line.starts_with('|')).skip(2).map(cells);
    rows.map(|row| {
        (row[1].clone(), row[2].split(" or ").map(Into::into).collect(), parameters_of_a_cell(&row[3]))
    })
    .collect()
}

fn parameters_of_a_cell(cell: &str) -> Vec<(String, String)> {
    // "mass kg, on a body" ends with a remark on the host.
    let entries = cell.split(", ").filter(|entry| !entry.starts_with("on "));
    let with_unit = |entry: &str| {
        let (name, unit) = entry.split_once(' ').unwrap_or((entry, ""));
        // The library counts a phase as a number and any exponent as `n`.
        (name.to_owned(), unit.replace("rad", "").replace("^exponent", "^n"))
    };
    entries.map(with_unit).collect()
}

fn row_of(definition: &Definition) -> Row {
    let places =
        definition.hosts.iter().map(|&host| definition.place_under(host).name().to_owned()).collect();
    // A parameter with a default is a choice of the model, in addition to the table.
    let required = definition.parameters.iter().filter(|parameter| parameter.default.is_none());
    let with_unit =
        |parameter: &Parameter| (parameter.name.to_owned(), parameter.dimension.si_unit(false).into_owned());
    (definition.name.into(), places, required.map(with_unit).collect())
}

#[test]
fn reference_kinds_places_parameters_and_units_are_those_of_the_design() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/design/effects.md");
    let Ok(text) = std::fs::read_to_string(&path) else {
        // Not by the macro for errors, whose output a passing test hides.
        let _ = writeln!(std::io::stderr(), "skipped: {} is not here", path.display());
        return;
    };
    let designed = rows_of_the_table(&text);
    // The library has since grown beyond that table.
    let library: Vec<Row> = LIBRARY.iter().map(|definition| row_of(definition)).collect();
    let kept: Vec<Row> =
        library.into_iter().filter(|row| designed.iter().any(|other| other.0 == row.0)).collect();
    assert_eq!(kept, designed);
}

#[test]
fn truth_the_null_is_the_ideal_machine() {
    let ideal = ideal();
    for definition in of_the_plant()
        .filter(|definition| definition.parameters.iter().any(|parameter| parameter.null.is_some()))
    {
        let at_null =
            |parameter: &Parameter| parameter.null.or(parameter.default).unwrap_or(parameter.typical);
        let values: Vec<f64> = definition.parameters.iter().map(at_null).collect();
        let mut tried = 0;
        for (host, mut changed) in outcomes(definition, &values) {
            if let (Host::Spring(i), HostKind::RigidSpring) = (host, ideal.host_kind(host)) {
                // Backlash turns a rigid spring into a stiff one even at zero width.
                assert_eq!((definition.kind, changed.links[i].rigid), (Kind::Backlash, false));
                assert!(changed.links[i].stiffness > 0.0);
                changed.links[i] = ideal.links[i].clone();
            }
            assert_eq!(changed, ideal, "{} under {host:?}", definition.kind);
            tried += 1;
        }
        assert!(tried > 0, "{} has no host", definition.kind);
    }
}

#[test]
fn prop_typical_values_change_the_machine_under_every_kind_of_host() {
    let ideal = ideal();
    for definition in of_the_plant() {
        let mut kinds = Vec::new();
        for (host, changed) in outcomes(definition, &typical(definition)) {
            assert_ne!(changed, ideal, "{} under {host:?}", definition.kind);
            kinds.push(ideal.host_kind(host));
        }
        for kind in definition.hosts {
            assert!(kinds.contains(kind), "{} was never tried under {}", definition.kind, kind.phrase());
        }
        assert!(kinds.iter().all(|kind| definition.hosts.contains(kind)), "{}", definition.kind);
    }
}

#[test]
fn prop_masses_stay_positive_and_ends_stay_apart() {
    for definition in of_the_plant() {
        for (host, changed) in outcomes(definition, &typical(definition)) {
            assert!(
                changed.nodes.iter().all(|node| node.mass_kg > 0.0),
                "{} under {host:?}",
                definition.kind
            );
            assert!(changed.links.iter().all(|link| link.a != link.b), "{} under {host:?}", definition.kind);
            assert!(
                changed.contacts.iter().all(|contact| contact.a != contact.b),
                "{} under {host:?}",
                definition.kind
            );
        }
    }
}

#[test]
fn prop_values_out_of_bounds_and_wrong_counts_are_refused() {
    let ideal = ideal();
    for definition in LIBRARY {
        let host = hosts(&ideal)[0];
        let mut values = typical(definition);
        values[0] = f64::NAN;
        let refused = definition.apply(&mut ideal.clone(), host, &values);
        assert!(matches!(refused, Err(EffectError::OutOfBounds { .. })), "{}: {refused:?}", definition.kind);
        values.push(1.0);
        let refused = definition.apply(&mut ideal.clone(), host, &values);
        assert!(matches!(refused, Err(EffectError::Count { .. })), "{}: {refused:?}", definition.kind);
    }
}

fn used(kind: &str) -> EffectUse {
    let definition = find(kind).expect("the library has it");
    EffectUse { definition, values: typical(definition) }
}

#[test]
fn prop_a_wrong_host_is_told_which_elements_take_the_effect() {
    let mut machine = machine();
    machine.springs["flange"].effects.push(used("hardening-stiffness"));
    machine.sensors["encoder"].effects.push(used("force-bias"));
    machine.actuators["drive"].effects.push(used("timing-jitter"));
    let problems: Vec<String> = assemble(&machine).unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(
        problems,
        [
            "springs.flange.effects.hardening-stiffness: `hardening-stiffness` does not sit under a rigid \
             spring; \
             it goes under a spring that is not rigid or a contact (move it under a spring that is not \
             rigid or a contact)",
            "actuators.drive.effects.timing-jitter: this effect disturbs a controller, not the plant (move \
             it under a controller)",
            "sensors.encoder.effects.force-bias: `force-bias` does not sit under a sensor that reads a \
             motion; \
             it goes under a sensor that reads a force (move it under a sensor that reads a force)",
        ]
    );
}

#[test]
fn prop_the_order_in_a_file_does_not_matter() {
    let with = |kinds: [&str; 3]| {
        let mut machine = machine();
        machine.springs["flange"].effects = kinds.into_iter().map(used).collect();
        assemble(&machine).unwrap()
    };
    let machine = with(["transmission-flexibility", "backlash", "hardening-stiffness"]);
    assert_eq!(machine, with(["hardening-stiffness", "backlash", "transmission-flexibility"]));
    assert!(machine.links[3].play > 0.0 && machine.links[3].cubic > 0.0);
}

/// The build script reads these numbers from the text of the files.
#[test]
fn truth_the_library_has_the_order_of_its_definitions() {
    assert!(LIBRARY.is_sorted_by(|before, after| before.order < after.order));
}

#[test]
fn prop_every_place_has_an_effect() {
    for (place, name) in Place::ALL {
        assert!(LIBRARY.iter().any(|definition| definition.place == place), "{name}");
    }
}
