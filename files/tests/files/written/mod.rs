//! Written scenarios, schemas, the manual, and templates.

use feeler_control::reference::{Between, ChirpSweep, Lines};
use feeler_control::{
    AntiWindup, ForceGains, ImpedanceGains, Law, LeadSpec, LowPassSpec, NotchSpec, PositionGains,
    ReferenceSpec,
};
use feeler_engine::{Integrator, Scenario};
use feeler_files::{
    Document, TEMPLATES, dataset_schema, machine_to_toml, schema, sweep_schema, template, to_toml,
};
use feeler_plant::description::{ActuatorKind, Axis, ContactLaw, Engagement, LowPass};
use feeler_plant::effects::{EffectUse, HostKind, LIBRARY, Place};
use proptest::prelude::*;

use crate::COMPLETE;

/// Scenarios that together have every element.
#[expect(clippy::unwrap_used, reason = "the templates have a test of their own")]
fn originals() -> Vec<Scenario> {
    let texts = TEMPLATES.iter().map(|template| template.text).chain([COMPLETE]);
    let scenarios = texts.map(|text| Document::parse(text, "original.toml").unwrap().scenario);
    scenarios.filter(|scenario| !scenario.machine.contacts.is_empty()).collect()
}

fn positive() -> impl Strategy<Value = f64> {
    (-9.0..9.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent))
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), positive(), positive().prop_map(|value| -value)]
}

fn points() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((positive(), any_number()), 1..5).prop_map(|steps| {
        let mut time = -1.0;
        steps
            .into_iter()
            .map(|(step, value)| {
                time += 1e-6 + step;
                (time, value)
            })
            .collect()
    })
}

fn reference() -> impl Strategy<Value = ReferenceSpec> {
    let band = || (0.1..10.0_f64, 20.0..100.0_f64);
    prop_oneof![
        any_number().prop_map(ReferenceSpec::Constant),
        points().prop_map(ReferenceSpec::Steps),
        points().prop_map(ReferenceSpec::PiecewiseLinear),
        (any::<bool>(), any_number(), band(), positive(), any_number()).prop_map(
            |(log, amplitude, (start_hz, end_hz), duration_s, offset)| {
                let sweep = if log { ChirpSweep::Logarithmic } else { ChirpSweep::Linear };
                ReferenceSpec::Chirp { sweep, amplitude, start_hz, end_hz, duration_s, offset }
            }
        ),
        (
            prop_oneof![Just(Lines::All), Just(Lines::Odd), Just(Lines::OddSparse)],
            band(),
            positive(),
            any_number()
        )
            .prop_map(|(lines, (low_hz, high_hz), rms, offset)| ReferenceSpec::Multisine {
                lines,
                low_hz,
                high_hz,
                period_s: 2.0,
                rms,
                offset
            }),
        (band(), positive(), any_number()).prop_map(|((low_hz, high_hz), rms, offset)| {
            ReferenceSpec::WhiteNoise { low_hz, high_hz, rms, offset }
        }),
        (2..=10_u32, positive(), any_number(), any_number()).prop_map(
            |(order, clock_period_s, amplitude, offset)| ReferenceSpec::Prbs {
                order,
                clock_period_s,
                amplitude,
                offset
            }
        ),
        (points(), any::<bool>(), any_number()).prop_map(|(points, hold, offset)| {
            let (times_s, values) = points.into_iter().unzip();
            ReferenceSpec::Table {
                times_s,
                values,
                between: if hold { Between::Hold } else { Between::Linear },
                offset,
            }
        }),
    ]
}

fn law() -> impl Strategy<Value = Law> {
    let anti_windup = || {
        prop_oneof![
            Just(AntiWindup::Conditional),
            Just(AntiWindup::Off),
            positive().prop_map(|tracking_time_s| AntiWindup::BackCalculation { tracking_time_s })
        ]
    };
    let gains = || (any_number(), any_number(), any_number(), any_number());
    let lead = proptest::option::of(
        (positive(), positive()).prop_map(|(zero_hz, pole_hz)| LeadSpec { zero_hz, pole_hz }),
    );
    prop_oneof![
        Just(Law::OpenLoop),
        (gains(), any_number(), positive(), lead, anti_windup()).prop_map(
            |((kp, ki, kd, damping), feed_forward, filter, lead, anti_windup)| {
                Law::ExplicitForce(ForceGains {
                    feed_forward,
                    kp,
                    ki,
                    kd,
                    damping,
                    derivative_filter_s: filter,
                    lead,
                    anti_windup,
                })
            }
        ),
        (gains(), positive(), anti_windup()).prop_map(
            |((kp, ki, kd, damping), derivative_filter_s, anti_windup)| {
                Law::Position(PositionGains { kp, ki, kd, damping, derivative_filter_s, anti_windup })
            }
        ),
        (any_number(), any_number(), any_number()).prop_map(|(stiffness, damping, force_gain)| {
            Law::Impedance(ImpedanceGains { stiffness, damping, force_gain })
        }),
    ]
}

prop_compose! {
    fn scenario()(
        original in prop::sample::select(originals()),
        rotational in any::<bool>(),
        velocity in any_number(),
        stiffness in positive(),
        contact_law in prop_oneof![
            Just(ContactLaw::KelvinVoigt),
            Just(ContactLaw::Hertz),
            (positive(), 1.0..3.0_f64)
                .prop_map(|(alpha_s_per_m, exponent)| ContactLaw::HuntCrossley { alpha_s_per_m, exponent }),
        ],
        engagement in prop_oneof![
            Just(Engagement::Clamped),
            Just(Engagement::Unilateral),
            Just(Engagement::Free),
        ],
        limits in (
            proptest::option::of(positive()),
            proptest::option::of(positive()),
            proptest::option::of(positive()),
        ),
        filter in proptest::option::of(prop_oneof![
            positive().prop_map(|corner_hz| LowPass::FirstOrder { corner_hz }),
            (positive(), positive())
                .prop_map(|(corner_hz, damping_ratio)| LowPass::SecondOrder { corner_hz, damping_ratio }),
        ]),
        law in law(),
        reference in reference(),
        timing in (positive(), positive(), any::<bool>()),
        seed in any::<u64>(),
        integrator in prop_oneof![
            prop::sample::select(Integrator::ALL.map(|(integrator, _)| integrator).to_vec()),
            Just(Integrator::External),
        ],
    ) -> Scenario {
        let mut scenario = original;
        let machine = &mut scenario.machine;
        machine.axis = if rotational { Axis::Rotational } else { Axis::Translational };
        machine.about = "quotes \" and \\ and\nlines".into();
        machine.bodies[0].velocity_m_per_s = velocity;
        let contact = &mut machine.contacts[0];
        (contact.law, contact.stiffness, contact.engagement) = (contact_law, stiffness, engagement);
        if matches!(contact_law, ContactLaw::HuntCrossley { .. }) {
            contact.damping_n_s_per_m = 0.0;
        }
        let actuator = &mut machine.actuators[0];
        (actuator.limit_n, actuator.rate_limit_per_s) = (limits.0, limits.1);
        if let ActuatorKind::Force { bandwidth_hz } = &mut actuator.kind {
            *bandwidth_hz = limits.2;
        }
        machine.sensors[0].low_pass = filter;
        let controller = &mut scenario.controllers[0];
        let position = matches!(law, Law::Position(_));
        controller.reads = match law {
            Law::OpenLoop => None,
            _ => Some(if position { "encoder" } else { "force" }.into()),
        };
        if matches!(law, Law::OpenLoop | Law::Position(_)) {
            controller.spec.approach = None;
        }
        controller.spec.law = law;
        controller.spec.reference = reference;
        controller.spec.delay_s = timing.0.min(1e3);
        controller.spec.output_limit = Some(timing.1);
        if timing.2 {
            let low_pass = LowPassSpec { cutoff_hz: 100.0, damping_ratio: Some(0.7) };
            let notch = NotchSpec { frequency_hz: 90.0, damping_ratio: 0.4, depth: 0.2 };
            controller.spec.reading_low_pass = Some(low_pass);
            controller.spec.reading_notch = Some(notch);
        }
        scenario.run.seed = seed;
        scenario.run.integrator = integrator;
        if integrator == Integrator::External && rotational {
            // Rapier cannot follow a rotation of more than a part of a turn per step.
            let most = 0.5 / scenario.run.step_s;
            scenario.machine.bodies[0].velocity_m_per_s = velocity.clamp(-most, most);
        }
        scenario
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn prop_a_written_scenario_is_read_as_it_was(scenario in scenario()) {
        let text = to_toml(&scenario);
        let document = Document::parse(&text, "written.toml")
            .map_err(|error| TestCaseError::fail(format!("{error}\n{text}")))?;
        prop_assert_eq!(document.scenario, scenario);
    }
}

#[test]
fn prop_every_effect_is_read_as_it_was_written() {
    for definition in LIBRARY {
        let mut scenario = originals().pop().unwrap();
        let machine = &mut scenario.machine;
        machine.actuators[0].effects.clear();
        let values: Vec<f64> = definition.parameters.iter().map(|parameter| parameter.typical).collect();
        let effects = vec![EffectUse { definition, values: values.clone() }];
        match definition.hosts[0] {
            HostKind::Body => machine.bodies["tip"].effects = effects,
            HostKind::Spring => {
                let spring = if definition.place == Place::Transmission { "transmission" } else { "guide" };
                machine.springs[spring].effects = effects;
            }
            HostKind::RigidSpring => {
                let joint = if definition.place == Place::Transmission { "transmission" } else { "mount" };
                let spring = &mut machine.springs[joint];
                (spring.rigid, spring.stiffness_n_per_m, spring.damping_n_s_per_m) = (true, 0.0, 0.0);
                machine.springs[joint].effects = effects;
            }
            HostKind::Contact => machine.contacts["tool"].effects = effects,
            HostKind::Actuator => machine.actuators["drive"].effects = effects,
            HostKind::MotionSensor => machine.sensors["encoder"].effects = effects,
            HostKind::ForceSensor | HostKind::OtherSensor => machine.sensors["force"].effects = effects,
            HostKind::Controller => scenario.controllers["force"].effects = effects,
        }
        let text = to_toml(&scenario);
        let document = Document::parse(&text, "written.toml")
            .unwrap_or_else(|error| panic!("{}: {error}\n{text}", definition.kind));
        assert_eq!(document.scenario, scenario, "{}", definition.kind);
    }
}

#[test]
fn truth_tolerances_are_written_with_the_document() {
    let text = format!(
        "{COMPLETE}\n[tolerance]\n\"bodies.motor.mass\" = 0.05\n\"springs.guide.stiffness\" = \"10 %\"\n"
    );
    let document = Document::parse(&text, "document.toml").unwrap();
    let again = Document::parse(&document.to_toml(), "again.toml").unwrap();
    assert_eq!(again.tolerance, document.tolerance);
    assert_eq!(again.scenario, document.scenario);
}

/// Every key of the drives other than the force drive.
#[test]
fn truth_every_kind_of_actuator_is_read_as_it_was_written() {
    let servo = template("servo").unwrap().text;
    let kinds = [
        (
            "position-servo",
            "kp = 12.0\nkd = 0.3\nki = 4.0\nlimit = 3.0\nvelocity_limit = \"60 rpm\"\n\
             delay = \"8 ms\"\nerror_deadband = \"0.2 deg\"\nperiod = \"2 ms\"\n\
             compute_delay = \"1 ms\"\nresolution = \"0.1 deg\"\n\
             output_resolution = \"1 mN m\"",
        ),
        (
            "dc-motor",
            "input = \"duty\"\nresistance = \"1.5 ohm\"\ntorque_constant = \"50 mN m/A\"\n\
             back_emf_constant = \"0.06 V s/rad\"\ngear_ratio = 20\nsupply_voltage = \"12 V\"\n\
             current_limit = \"2 A\"\nrotor_inertia = \"1e-5 kg m2\"\ninductance = \"0.2 mH\"",
        ),
        ("imposed", ""),
    ];
    let (before, rest) = servo.split_once("kind = ").unwrap();
    let (_, after) = rest.split_once("\n\n").unwrap();
    for (kind, keys) in kinds {
        let text = format!("{before}kind = \"{kind}\"\n{keys}\n\n{after}").replace("\"servo.target\", ", "");
        let read = Document::parse(&text, "kinds.toml").unwrap_or_else(|error| panic!("{error}")).scenario;
        let written = to_toml(&read);
        let again =
            Document::parse(&written, "again.toml").unwrap_or_else(|error| panic!("{error}\n{written}"));
        assert_eq!(again.scenario, read, "{written}");
        // The output must have every key.
        for line in keys.lines() {
            let key = line.split(' ').next().unwrap_or_default();
            assert!(written.contains(&format!("\n{key} = ")), "{kind} lacks {key}:\n{written}");
        }
    }
}

#[test]
fn truth_a_moving_gap_is_written_out() {
    let text = COMPLETE.replacen(
        "[contacts.tool]",
        "[contacts.tool.profile]\noffset = [[0.0, 0.0], [0.25, 1e-3], [0.7, \"0.3 mm\"]]\n[contacts.tool]",
        1,
    );
    let read = Document::parse(&text, "moving.toml").unwrap().scenario;
    assert_eq!(read.machine.profiles["tool"].knots().len(), 3);
    assert_eq!(Document::parse(&to_toml(&read), "again.toml").unwrap().scenario, read);
}

#[test]
fn truth_a_machine_is_written_without_its_run() {
    for scenario in originals() {
        let text = machine_to_toml(&scenario.machine);
        assert!(!text.contains("[run]"));
        let read = Document::parse(&text, "machine.toml").unwrap().scenario;
        assert_eq!(read.machine, scenario.machine);
        assert!(read.controllers.is_empty());
    }
}

#[test]
fn truth_templates_are_named_as_their_files_and_run() {
    for template in TEMPLATES {
        let document =
            Document::parse(template.text, template.name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(document.scenario.machine.name, template.name);
        assert!(!document.scenario.controllers.is_empty());
    }
}

#[test]
fn truth_schemas_describe_every_key() {
    fn undescribed(root: &serde_json::Value, at: &str, value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(object) => {
                for (name, property) in
                    object.get("properties").and_then(|p| p.as_object()).into_iter().flatten()
                {
                    let defined = property.get("$ref").and_then(|name| name.as_str());
                    let property =
                        defined.map_or(property, |name| root.pointer(name.trim_start_matches('#')).unwrap());
                    if property.get("description").and_then(|text| text.as_str()).is_none_or(str::is_empty) {
                        found.push(format!("{at}.{name}"));
                    }
                }
                for (name, inner) in object {
                    undescribed(root, &format!("{at}.{name}"), inner, found);
                }
            }
            serde_json::Value::Array(items) => {
                for item in items {
                    undescribed(root, at, item, found);
                }
            }
            _ => {}
        }
    }
    for schema in [schema(), sweep_schema(), dataset_schema()] {
        assert_eq!(schema["$schema"], "http://json-schema.org/draft-07/schema#");
        let mut found = Vec::new();
        undescribed(&schema, "", &schema, &mut found);
        assert!(found.is_empty(), "{found:?}");
    }
    let text = schema().to_string();
    for definition in LIBRARY {
        assert!(text.contains(&format!("\"{}\"", definition.kind)), "{}", definition.kind);
    }
}
