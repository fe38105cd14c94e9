//! Consecutive records: one long record is cut into pieces, of which some are fitted and others scored.

use std::sync::Arc;

use super::{Dataset, Fault, FaultKind, Record};

/// Number of pieces, of which every third is scored.
const PIECES: usize = 9;
/// Smallest number of rows of a piece.
const FEWEST_ROWS: usize = 100;
/// Distance from the last row of a record to the first row of the next one, in rows.
const NEXT_ROW: std::ops::Range<f64> = 0.5..1.5;

impl Dataset {
    /// Cuts a single experiment into pieces; several experiments stay unchanged. The second of every three
    /// pieces is scored and never fitted, whatever the role of the experiment.
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
        self.join();
        self
    }

    /// Links each record to the previous one on its clock. Records that do not overlap share one clock, and
    /// any pause may lie between them.
    pub(super) fn join(&mut self) {
        let mut order: Vec<usize> = (0..self.records.len()).collect();
        order.sort_by(|a, b| self.records[*a].start_s.total_cmp(&self.records[*b].start_s));
        let rows_after = |last: usize, next: usize| self.records[next].rows_after(&self.records[last]);
        let is_one_clock = order.windows(2).all(|pair| rows_after(pair[0], pair[1]) >= NEXT_ROW.start);
        let follows = if is_one_clock { NEXT_ROW.start..f64::INFINITY } else { NEXT_ROW };
        for (n, &next) in order.iter().enumerate() {
            let goes_on =
                |&&last: &&usize| follows.contains(&self.records[next].rows_after(&self.records[last]));
            if let Some(&last) = order[..n].iter().rev().find(goes_on) {
                self.records[next].before = Some(Arc::new(self.records[last].clone()));
            }
        }
    }
}

impl Record {
    /// Time from the last row of another record to the first row of this one, in rows of the other record.
    fn rows_after(&self, last: &Self) -> f64 {
        (self.start_s - last.end_s()) / last.spacing_s
    }

    fn end_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(f64::NAN)
    }

    /// Pause between the previous record and the first row of this one, s.
    pub(crate) fn pause_s(&self) -> f64 {
        let last = self.before.as_deref().filter(|last| self.rows_after(last) >= NEXT_ROW.end);
        last.map_or(0.0, |last| self.start_s - last.end_s() - last.spacing_s)
    }

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
        // A channel without a reading in a piece is ignored there.
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
        let goes_on = |pair: &[Record]| pair[1].before.as_ref().is_some_and(|last| last.name == pair[0].name);
        assert!(cut.records[0].before.is_none() && cut.records.windows(2).all(goes_on));
        assert!(starts && cut.warnings.iter().any(|fault| matches!(fault.kind, FaultKind::Cut { .. })));
    }

    #[test]
    fn truth_a_record_goes_on_from_the_one_that_ends_a_row_before() {
        let mut several = loaded(&["a.csv"], 1005).in_pieces();
        several.records.iter_mut().for_each(|record| record.before = None);
        several.records = [4, 1, 0, 2].map(|i| several.records[i].clone()).to_vec();
        several.join();
        let earlier = |record: &Record| record.earlier().map(|other| other.start_s).collect::<Vec<_>>();
        let found: Vec<Vec<f64>> = several.records.iter().map(earlier).collect();
        let [_, one, zero, two] = [0, 1, 2, 3].map(|i: usize| several.records[i].start_s);
        // The fourth piece is missing before the first record listed here.
        assert_eq!(found, [vec![two, one, zero], vec![zero], vec![], vec![one, zero]]);
    }

    /// Without the third piece there is a pause of its length. Records that overlap have separate clocks.
    #[test]
    fn truth_records_on_one_clock_follow_each_other_over_a_pause() {
        let mut parts = loaded(&["a.csv"], 1005).in_pieces();
        let missing = parts.records.remove(2);
        parts.join();
        let last = parts.records[1].name.clone();
        let next = &parts.records[2];
        assert_eq!(next.before.as_ref().map(|record| &record.name), Some(&last));
        assert!((next.pause_s() - missing.duration_s()).abs() < 1e-9, "{}", next.pause_s());
        assert!(parts.records[1].pause_s() == 0.0 && parts.records[0].pause_s() == 0.0);
        let mut other = parts.records[0].clone();
        other.start_s += 0.5 * other.duration_s();
        parts.records.iter_mut().for_each(|record| record.before = None);
        parts.records.push(other);
        parts.join();
        assert!(parts.records[2].before.is_none());
    }

    #[test]
    fn truth_several_experiments_and_short_ones_stay_whole() {
        let both = loaded(&["a.csv", "b.csv"], 1000).in_pieces().records;
        assert!(both.len() == 2 && both.iter().all(|record| record.before.is_none()));
        assert_eq!(loaded(&["a.csv"], 150).in_pieces().records.len(), 1);
    }
}
