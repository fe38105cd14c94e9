//! From records to causes: datasets, faults, predictions, answers.

mod adequacy;
mod beginning;
mod bristles;
mod contradictions;
mod drives;
mod emps;
mod faults;
mod fuzz;
mod import;
mod import_inputs;
mod import_units;
mod inputs;
mod joint;
mod one_machine;
mod recovery;
mod slow;
mod small_joint;
mod so101;
mod surface;
mod tx40;
mod units;
mod warming;
mod weight;

/// Uniform noise of unit deviation, equal in every run.
struct Noise(u64);

impl Noise {
    fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }
}
