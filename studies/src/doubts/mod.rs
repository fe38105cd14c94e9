//! Doubtful values in a file without mistakes.

mod asked;
mod contact;
mod distance;
mod gains;
mod timing;

use feeler_analysis::ControlLoop;
use feeler_engine::Scenario;
use feeler_problem::Problem;

use crate::operating_point::contact_view;
use asked::Asked;

/// Implausible values of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Doubts {
    /// All of them: keys with the doubt, and the probable intention.
    pub all: Vec<Problem>,
    /// Index of the first one that can prevent contact. A soft wall or a slow sample cannot.
    preventing: Option<usize>,
}

impl Doubts {
    /// The first one that can prevent contact.
    pub fn preventing_contact(&self) -> Option<&Problem> {
        self.all.get(self.preventing?)
    }

    fn add(&mut self, found: impl IntoIterator<Item = Problem>) {
        self.all.extend(found);
    }

    fn add_preventing(&mut self, found: impl IntoIterator<Item = Problem>) {
        let first = self.all.len();
        self.add(found);
        self.preventing = self.preventing.or((self.all.len() > first).then_some(first));
    }
}

/// Implausible values. Linear theory contributes if it applies.
pub fn doubts(scenario: &Scenario) -> Doubts {
    let mut found = Doubts::default();
    found.add_preventing(gains::without_gains(scenario));
    found.add_preventing(gains::shared_drives(scenario));
    if let Some(asked) = Asked::find(scenario) {
        found.add_preventing(contact::pull(&asked));
        found.add(contact::soft(&asked));
        found.add(asked.doubts());
    }
    found.add_preventing(contact::gaps(scenario));
    if let Ok(whole) = ControlLoop::new(scenario, &contact_view(scenario)) {
        found.add(timing::slow_loops(scenario, &whole));
        found.add_preventing(gains::off_in_contact(scenario, &whole));
    }
    found
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;

    use super::*;

    const AXIS: &str = r#"
[bodies.m]
mass = 6.0
[springs.g]
between = ["ground", "m"]
damping = 60.0
[contacts.tool]
between = ["m", "ground"]
stiffness = 100000.0
damping = 120.0
[actuators.drive]
on = "m"
[sensors.force]
reads = "tool.spring_force"
[controllers.f]
law = "explicit-force"
reads = "force"
drives = "drive"
period = 0.001
feed_forward = 1.0
kp = 0.4
reference = 20.0
"#;

    fn keys(text: &str) -> Vec<String> {
        let document = Document::parse(text, "axis.toml").unwrap();
        doubts(&document.scenario).all.into_iter().map(|doubt| doubt.key).collect()
    }

    /// 20.5 Hz in contact.
    #[test]
    fn truth_nonsense_is_doubted_and_sense_is_not() {
        assert_eq!(keys(AXIS), Vec::<String>::new());
        assert_eq!(keys(&AXIS.replace("period = 0.001", "period = 0.03")), ["controllers.f.period"]);
        let idle = AXIS.replace("kp = 0.4", "kp = 0.0").replace("feed_forward = 1.0", "feed_forward = 0.0");
        assert_eq!(keys(&idle), ["controllers.f"]);
        assert_eq!(keys(&AXIS.replace("kp = 0.4", "kp = 0.0")), ["controllers.f"]);
        let sensed = |text: &str| format!("{text}[sensors.encoder]\nreads = \"m.velocity\"\n");
        assert_eq!(keys(&sensed(&idle.replace("kp = 0.0", "damping = 60.0"))), ["controllers.f"]);
        assert_eq!(
            keys(&sensed(&AXIS.replace("kp = 0.4", "damping = 60.0\nkp = 0.4"))),
            Vec::<String>::new()
        );
        assert_eq!(keys(&AXIS.replace("kp = 0.4", "ki = 4.0")), Vec::<String>::new());
        let reversed =
            AXIS.replace("between = [\"m\", \"ground\"]\nstiff", "between = [\"ground\", \"m\"]\nstiff");
        assert_eq!(keys(&reversed), ["contacts.tool.between"]);
        let turned = AXIS.replace("kp = 0.4", "kp = -0.4");
        assert_eq!(keys(&turned), ["controllers.f.kp"]);
        // A sensor that falls as the tool pushes takes a negative gain.
        let falling = turned.replace("_force\"", "_force\"\ngain = -1.0");
        assert_eq!(keys(&falling.replace("reference = 20.0", "reference = -20.0")), Vec::<String>::new());
    }

    /// A stiff velocity drive has a mode of its own, here at 6.5 kHz. The loop is an integrator with a gain
    /// of kp k / (2 pi f): 0.14 at half of 200 Hz, and 141 at half of 0.2 Hz.
    #[test]
    fn truth_the_mode_of_a_velocity_drive_asks_for_no_faster_samples_than_its_loop() {
        let kind = "kind = \"velocity-source\"\ndamping = 1e6\ntime_constant = 1e-4\n";
        let source = AXIS.replace("on = \"m\"\n", &format!("on = \"m\"\n{kind}"));
        let source = source.replace("feed_forward = 1.0\nkp = 0.4", "kp = 0.0009");
        let every = |period: &str| keys(&source.replace("period = 0.001", &format!("period = {period}")));
        assert_eq!(every("0.005"), Vec::<String>::new());
        assert_eq!(every("5.0"), ["controllers.f.period"]);
    }

    /// 8.2 cycles of the 20.5 Hz in contact; 20 ms are 0.4 of one, and 8 ms are 8 samples. The loop gain of
    /// the velocity drive above is 11 at 1.25 Hz.
    #[test]
    fn truth_a_delay_of_many_samples_and_cycles_is_doubted() {
        let late =
            |delay: &str| keys(&AXIS.replace("period = 0.001", &format!("period = 0.001\ndelay = {delay}")));
        assert_eq!(late("0.4"), ["controllers.f.delay"]);
        for plausible in ["0.0004", "0.008", "0.02"] {
            assert_eq!(late(plausible), Vec::<String>::new(), "{plausible}");
        }
        let sensed =
            AXIS.replace("reads = \"tool.spring_force\"", "reads = \"tool.spring_force\"\ndelay = 0.4");
        assert_eq!(keys(&sensed), ["sensors.force.delay"]);
        let kind = "kind = \"velocity-source\"\ndamping = 1e6\ntime_constant = 1e-4\n";
        let source = AXIS.replace("on = \"m\"\n", &format!("on = \"m\"\n{kind}"));
        let source = source.replace("feed_forward = 1.0\nkp = 0.4", "kp = 0.0009\ndelay = 0.4");
        assert_eq!(keys(&source), ["controllers.f.delay"]);
        assert_eq!(keys(&source.replace("delay = 0.4", "delay = 0.02")), Vec::<String>::new());
    }

    #[test]
    fn truth_a_tool_that_starts_inside_the_wall_is_doubted() {
        let gap =
            |gap: &str| keys(&AXIS.replace("damping = 120.0", &format!("damping = 120.0\ngap = {gap}")));
        assert_eq!(gap("-0.001"), ["contacts.tool.gap"]);
        assert_eq!(gap("0.001"), Vec::<String>::new());
        // 1 mm of 100 kN/m.
        let inside = Document::parse(&AXIS.replace("damping = 120.0", "damping = 120.0\ngap = -0.001"), "it");
        let found = doubts(&inside.unwrap().scenario).all;
        assert!(found[0].message.ends_with("a push of 100 N"), "{found:?}");
    }

    #[test]
    fn truth_only_what_can_prevent_contact_explains_its_absence() {
        let preventing = |text: &str| {
            let found = doubts(&Document::parse(text, "axis.toml").unwrap().scenario);
            found.preventing_contact().map(|doubt| doubt.key.clone())
        };
        let soft = AXIS.replace("stiffness = 100000.0", "stiffness = 200.0");
        assert_eq!(keys(&soft), ["contacts.tool.stiffness"]);
        assert_eq!(preventing(&soft), None);
        let far = soft.replace("damping = 120.0", "damping = 120.0\ngap = 5.0");
        assert_eq!(preventing(&far), Some("contacts.tool.gap".to_owned()));
        assert_eq!(
            preventing(&AXIS.replace("reference = 20.0", "reference = -20.0")),
            Some("controllers.f.reference".to_owned())
        );
    }

    /// 20 N sink 100 mm into 200 N/m, and 10 mm into 2 kN/m.
    #[test]
    fn truth_a_pull_and_a_wall_of_foam_are_doubted() {
        let pulls = AXIS.replace("reference = 20.0", "reference = -20.0");
        assert_eq!(keys(&pulls), ["controllers.f.reference"]);
        assert_eq!(
            keys(&pulls.replace("stiffness", "engagement = \"clamped\"\nstiffness")),
            Vec::<String>::new()
        );
        // A sensor whose reading falls as the tool pushes.
        let turned = pulls.replace("spring_force\"", "spring_force\"\ngain = -1.0");
        assert!(!keys(&turned).contains(&"controllers.f.reference".to_owned()));
        let of = |stiffness: &str| {
            keys(&AXIS.replace("stiffness = 100000.0", &format!("stiffness = {stiffness}")))
        };
        assert_eq!(of("200.0"), ["contacts.tool.stiffness"]);
        assert_eq!(of("2000.0"), Vec::<String>::new());
    }

    /// 20 N asked for, 0.2 mm of compression under it, and no gap.
    #[test]
    fn truth_what_is_too_weak_or_coarse_for_the_force_is_doubted() {
        let with = |from: &str, to: &str| keys(&AXIS.replace(from, to));
        let limit = |limit: &str| with("on = \"m\"", &format!("on = \"m\"\nlimit = {limit}"));
        assert_eq!(limit("10.0"), ["actuators.drive.limit"]);
        assert_eq!(limit("20.0"), Vec::<String>::new());
        let output = |limit: &str| with("kp = 0.4", &format!("kp = 0.4\noutput_limit = {limit}"));
        assert_eq!(output("10.0"), ["controllers.f.output_limit"]);
        assert_eq!(output("30.0"), Vec::<String>::new());
        let until = |until: &str| {
            let approach = format!("kp = 0.4\napproach = {{ speed = 0.02, until = {until} }}");
            keys(&format!("{}[sensors.e]\nreads = \"m.position\"\n", AXIS.replace("kp = 0.4", &approach)))
        };
        assert_eq!(until("40.0"), ["controllers.f.approach.until"]);
        assert_eq!(until("4.0"), Vec::<String>::new());
        let force = |key: &str| with("_force\"", &format!("_force\"\n{key}"));
        assert_eq!(force("noise = 50.0"), ["sensors.force.noise"]);
        assert_eq!(force("noise = 0.5"), Vec::<String>::new());
        assert_eq!(force("resolution = 25.0"), ["sensors.force.resolution"]);
        assert_eq!(force("resolution = 0.1"), Vec::<String>::new());
        let encoder =
            |step: &str| keys(&format!("{AXIS}[sensors.e]\nreads = \"m.position\"\nresolution = {step}\n"));
        assert_eq!(encoder("0.001"), ["sensors.e.resolution"]);
        assert_eq!(encoder("1e-6"), Vec::<String>::new());
        let gap = |gap: &str| with("damping = 120.0", &format!("damping = 120.0\ngap = {gap}"));
        assert_eq!(gap("5.0"), ["contacts.tool.gap"]);
        assert_eq!(gap("0.05"), Vec::<String>::new());
    }

    /// A damper, whose reference stays zero, only adds damping.
    #[test]
    fn truth_two_references_on_one_drive_are_doubted() {
        let second = |keys: &str| {
            format!(
                "{AXIS}[sensors.e]\nreads = \"m.position\"\n[controllers.second]\ndrives = \"drive\"\n\
                 period = 0.001\n{keys}\n"
            )
        };
        let recorded = second("law = \"open-loop\"\nreference = 5.0");
        assert_eq!(keys(&recorded), ["controllers.second.drives"]);
        let damper = second("law = \"impedance\"\nreads = \"force\"\ndamping = 100.0");
        assert_eq!(keys(&damper), Vec::<String>::new());
    }
}
