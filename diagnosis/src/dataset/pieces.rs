//! One long record cut into pieces, so that some are fitted and others scored.

use super::{Dataset, Fault, FaultKind, Record};

/// Number of pieces, of which every third is scored.
const PIECES: usize = 9;
/// Smallest number of rows of a piece.
const FEWEST_ROWS: usize = 100;

impl Dataset {
    /// Cuts a single experiment into pieces; several experiments stay unchanged. The second of every three
    /// pieces is scored and never fitted, whatever the role was.
    #[must_use]
    pub fn in_pieces(mut self) -> Self {
        let [whole] = self.records.as_slice() else { return self };
        let pieces = PIECES.min(whole.len() / FEWEST_ROWS);
        if pieces < 2 {
            return self;
        }
        let file = whole.name.clone();
        let cut: Vec<Record> = (0..pieces).map(|i| whole.piece(i, pieces)).collect();
        let checked = cut.iter().filter(|piece| piece.is_check).count();
        let kind = FaultKind::Cut { pieces, checked };
        self.warnings.push(Fault { file, column: None, row: None, kind });
        self.records = cut;
        self
    }
}

impl Record {
    fn piece(&self, index: usize, of: usize) -> Self {
        let rows = index * self.len() / of..(index + 1) * self.len() / of;
        let cut = |series: &Vec<f64>| series[rows.clone()].to_vec();
        let part = |gaps: &Vec<bool>| gaps.get(rows.clone()).unwrap_or_default().to_vec();
        let mut piece = Self {
            name: format!("{} ({} of {of})", self.name, index + 1),
            is_check: index % 3 == 1,
            start_s: self.times_s[rows.start],
            times_s: cut(&self.times_s),
            commands: self.commands.iter().map(cut).collect(),
            series: self.series.iter().map(cut).collect(),
            bridged: self.bridged.iter().map(part).collect(),
            ..self.clone()
        };
        // A channel without a reading in a piece says nothing there.
        for c in 0..piece.silent.len() {
            piece.silent[c] |= piece.is_unread(c);
        }
        piece
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::fs;

    use super::*;

    fn loaded(files: &[&str], rows: usize) -> Dataset {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write(
            "machine.toml",
            "[bodies.a]\nmass = 1.0\n[springs.g]\nbetween = [\"ground\", \"a\"]\ndamping = 1.0\n\
             [actuators.drive]\non = \"a\"\nreacts_on = \"ground\"\nkind = \"force\"\nlimit = 9.0\n",
        );
        let mut dataset = "machine = \"machine.toml\"\n[columns.u]\nsignal = \"drive.command\"\n\
                           [columns.x]\nsignal = \"a.position\"\n"
            .to_owned();
        for file in files {
            let _ = writeln!(dataset, "[[experiments]]\nfile = \"{file}\"");
            let mut text = "t_s,u,x\n".to_owned();
            for k in 0..rows {
                let t = 0.01 * k as f64;
                let _ = writeln!(text, "{t},{},{}", t.sin(), (1.3 * t).cos());
            }
            write(file, &text);
        }
        write("dataset.toml", &dataset);
        Dataset::load(folder.path()).unwrap()
    }

    #[test]
    fn truth_a_single_experiment_is_cut_into_pieces_without_a_row_lost() {
        let whole = loaded(&["a.csv"], 1005);
        let series = whole.records[0].series[0].clone();
        let cut = whole.in_pieces();
        assert_eq!(cut.records.len(), PIECES);
        assert_eq!(cut.records.iter().filter(|piece| piece.is_check).count(), 3);
        let joined: Vec<f64> = cut.records.iter().flat_map(|piece| piece.series[0].clone()).collect();
        assert_eq!(joined, series);
        let starts = cut
            .records
            .windows(2)
            .all(|pair| (pair[1].start_s - pair[0].start_s - 0.01 * pair[0].len() as f64).abs() < 1e-9);
        assert!(starts && cut.warnings.iter().any(|fault| matches!(fault.kind, FaultKind::Cut { .. })));
    }

    #[test]
    fn truth_several_experiments_and_short_ones_stay_whole() {
        assert_eq!(loaded(&["a.csv", "b.csv"], 1000).in_pieces().records.len(), 2);
        assert_eq!(loaded(&["a.csv"], 150).in_pieces().records.len(), 1);
    }
}
