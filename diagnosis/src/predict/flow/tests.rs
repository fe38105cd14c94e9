//! Maps over spans, kept and computed afresh.

use feeler_files::Document;
use feeler_plant::assembly::assemble;

use super::*;

const MACHINE: [f64; 6] = [2.0, 9.0, 3.0, 1e5, 1e-3, 40.0];

/// A body that presses on a surface, against friction and within the limit of its drive.
fn motion([mass, damping, level, stiffness, gap, limit]: [f64; 6]) -> Motion {
    let text = format!(
        "[bodies.tip]\nmass = {mass:?}\nvelocity = 0.1\n[springs.guide]\n\
         between = [\"ground\", \"tip\"]\ndamping = {damping:?}\n\
         [springs.guide.effects.coulomb-friction]\nlevel = {level:?}\n\
         [contacts.tool]\nbetween = [\"tip\", \"ground\"]\nstiffness = {stiffness:?}\n\
         gap = {gap:?}\n\
         [actuators.drive]\non = \"tip\"\nkind = \"force\"\nlimit = {limit:?}\n"
    );
    let machine = Document::parse(&text, "axis.toml").unwrap().scenario.machine;
    Motion::new(assemble(&machine).unwrap()).unwrap()
}

/// Maps of machines that differ in the last bit of one number, in modes, spans and guard evaluations. Each is
/// met again after all others.
#[test]
fn prop_a_map_that_is_kept_is_that_of_a_fresh_computation_bit_for_bit() {
    let nearby = (0..MACHINE.len()).map(|i| {
        let mut values = MACHINE;
        values[i] = values[i].next_up();
        values
    });
    let machines: Vec<Motion> = std::iter::once(MACHINE).chain(nearby).map(motion).collect();
    let mut seen = Vec::new();
    for motion in machines.iter().chain(&machines) {
        for (spacing_s, checks) in [(1e-3, 1), (1e-3, 4), (1e-3_f64.next_up(), 4), (2e-3, 4)] {
            let mut flows = Flows::new(Vec::new(), spacing_s, checks);
            let mut xi = motion.initial_vector();
            let Ok(beginning) = motion.begin(&mut flows, Mode::default(), &mut xi);
            for index in [beginning.index, flows.number_of(motion, Mode::default())] {
                for span_s in [spacing_s, 0.5 * spacing_s, 0.3 * spacing_s] {
                    let kept = flows[index].exponential(span_s).unwrap();
                    let kept = format!("{:?}", flows[index].spans[kept].1);
                    assert_eq!(kept, format!("{:?}", flows[index].carried(span_s).unwrap()));
                    seen.push(kept);
                }
            }
        }
    }
    // Most machines have maps of their own. Without contact, its stiffness does not matter.
    let maps = seen.len() / 2;
    assert_eq!(seen[..maps], seen[maps..]);
    seen.sort_unstable();
    seen.dedup();
    assert!(2 * seen.len() > maps, "{} of {maps}", seen.len());
}
