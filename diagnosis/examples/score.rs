//! x
#![expect(clippy::print_stdout, reason = "a table is what this example is for")]
use std::time::Instant;
use feeler_diagnosis::dataset::Dataset;
fn main() {
    for case in std::env::args().skip(1) {
        let data = Dataset::load(std::path::Path::new(&case)).unwrap();
        let t = Instant::now();
        let r = feeler_diagnosis::search::ranking(&data).unwrap();
        println!("{case} {:.1} s", t.elapsed().as_secs_f64());
        for (i, (name, score, text)) in r.iter().enumerate() { if i < 4 || name.is_empty() { println!("   {i:2} {score:8.1} {name:60} {text}"); } }
    }
}
