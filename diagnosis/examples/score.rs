//! x
#![expect(clippy::print_stdout, reason = "a table is what this example is for")]
use std::time::Instant;
use feeler_diagnosis::dataset::Dataset;
use feeler_diagnosis::predict::Predictor;
fn main() {
    for case in std::env::args().skip(1) {
        let data = Dataset::load(std::path::Path::new(&case)).unwrap();
        for w in &data.warnings { println!("{w}"); }
        let a = feeler_plant::assembly::assemble(&data.machine).unwrap();
        for r in &data.records {
            let t = Instant::now();
            let p = Predictor::new(a.clone(), &data, r).unwrap().anchored().unwrap();
            let el = t.elapsed();
            print!("{case} {:22} {:6.1} ms", r.name, el.as_secs_f64()*1e3);
            for (i, c) in data.channels.iter().enumerate() {
                let n = r.len() as f64;
                let e = (r.series[i].iter().zip(&p.series[i]).map(|(a,b)|(a-b).powi(2)).sum::<f64>()/n).sqrt();
                let m = r.series[i].iter().sum::<f64>()/n;
                let s = (r.series[i].iter().map(|a|(a-m).powi(2)).sum::<f64>()/n).sqrt();
                print!(" | {} {e:.3e}/{s:.2e}", &c.column[..6]);
            }
            println!();
        }
    }
}
