//! M1, M2 and M4 against independent event-located integration.

use crate::common::{reference_file, reference_machine, run};
use feeler_engine::EventKind;

/// Requirement: events within 1e-9 s and forces within 1e-6 N over the first 0.3 s.
const EVENT_TOLERANCE_S: f64 = 1e-9;
const FORCE_TOLERANCE_N: f64 = 1e-6;

/// Elements of a JSON array of numbers or strings, under `"machine": { ... "key": [`.
fn array<'a>(json: &'a str, machine: &str, key: &str) -> Vec<&'a str> {
    let from = json.find(&format!("\"{machine}\"")).unwrap();
    let rest = &json[from..];
    let rest = &rest[rest.find(&format!("\"{key}\"")).unwrap()..];
    let body = &rest[rest.find('[').unwrap() + 1..rest.find(']').unwrap()];
    body.split(',').map(|item| item.trim().trim_matches('"')).collect()
}

#[test]
fn reference_events_and_forces_of_all_machines_at_both_steps() {
    let Some(json) = reference_file("contact-events.json") else { return };
    for masses in [1, 2, 4] {
        let csv = reference_file(&format!("contact-m{masses}.csv")).unwrap();
        for step_s in [1e-3, 1e-4] {
            let mut scenario = reference_machine(masses, 0.3);
            scenario.run.step_s = step_s;
            scenario.run.record_rate_hz = Some(1e4);
            let (trace, _) = run(&scenario);
            let machine = format!("M{masses}");
            let times = array(&json, &machine, "events_s");
            let kinds = array(&json, &machine, "kind");
            assert_eq!(trace.events.len(), times.len(), "{machine}");
            for ((event, time), kind) in trace.events.iter().zip(times).zip(kinds) {
                let error = (event.t_s - time.parse::<f64>().unwrap()).abs();
                assert!(error < EVENT_TOLERANCE_S, "{machine}: {kind} off by {error:.1e} s");
                assert_eq!(event.kind, if kind == "touch" { EventKind::Touch } else { EventKind::Lift });
            }
            let force = trace.column("tool.force").unwrap();
            let mut worst: f64 = 0.0;
            for (row, f) in csv.lines().skip(1).zip(force) {
                let expected: f64 = row.split(',').nth(1).unwrap().parse().unwrap();
                worst = worst.max((f - expected).abs());
            }
            println!("{machine}: step {step_s} s, worst force error {worst:.2e} N");
            assert!(worst < FORCE_TOLERANCE_N, "{machine}: force off by {worst:.1e} N");
        }
    }
}
