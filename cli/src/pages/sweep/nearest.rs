//! A map of variants with varying density: every place has the colour of the nearest variant.

/// A rectangle of places with the same nearest variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    /// First column, and number of columns.
    pub(super) columns: [usize; 2],
    /// First row from below, and number of rows.
    pub(super) rows: [usize; 2],
    /// Index of the variant.
    pub(super) of: usize,
}

/// Tiles of a raster with this many columns and rows, for variants at shares of its sides. `unit` is the
/// number of columns and rows with equal length, for distances.
pub(super) fn tiles(shares: &[[f64; 2]], [columns, rows]: [usize; 2], unit: [f64; 2]) -> Vec<Tile> {
    let at = |share: f64, count: usize| ((share * count as f64) as usize).min(count.saturating_sub(1));
    let mut seeds: Vec<Option<usize>> = vec![None; columns * rows];
    for (i, [x, y]) in shares.iter().enumerate() {
        seeds[at(*x, columns) * rows + at(*y, rows)].get_or_insert(i);
    }
    let nearest = nearest_of_columns(&seeds, rows);
    let square = |cells: usize, unit: f64| (cells as f64 / unit).powi(2);
    let of = |column: usize, row: usize| {
        let candidates = (0..columns).filter_map(|other| {
            let (found_row, found) = nearest[other * rows + row]?;
            Some((square(other.abs_diff(column), unit[0]) + square(found_row.abs_diff(row), unit[1]), found))
        });
        candidates.reduce(|a, b| if b.0 < a.0 { b } else { a }).map(|(_, found)| found)
    };
    let mut done: Vec<Tile> = Vec::new();
    // Tiles that extend up to the present row.
    let mut open: Vec<Tile> = Vec::new();
    for row in 0..rows {
        let mut runs: Vec<Tile> = Vec::new();
        for (column, found) in (0..columns).filter_map(|column| Some((column, of(column, row)?))) {
            match runs.last_mut() {
                Some(run) if run.of == found && run.columns[0] + run.columns[1] == column => {
                    run.columns[1] += 1;
                }
                _ => runs.push(Tile { columns: [column, 1], rows: [row, 1], of: found }),
            }
        }
        for run in &mut runs {
            if let Some(i) = open.iter().position(|tile| tile.of == run.of && tile.columns == run.columns) {
                let below = open.swap_remove(i);
                run.rows = [below.rows[0], below.rows[1] + 1];
            }
        }
        done.append(&mut open);
        open = runs;
    }
    done.append(&mut open);
    done
}

/// For each place the nearest variant of its column, and its row.
fn nearest_of_columns(seeds: &[Option<usize>], rows: usize) -> Vec<Option<(usize, usize)>> {
    let mut nearest: Vec<Option<(usize, usize)>> = vec![None; seeds.len()];
    for (column, seeds) in seeds.chunks(rows).enumerate() {
        let mut carry = |order: &mut dyn Iterator<Item = usize>| {
            let mut last: Option<(usize, usize)> = None;
            for row in order {
                last = seeds[row].map(|seed| (row, seed)).or(last);
                let place = &mut nearest[column * rows + row];
                let is_nearer = |(other, _): (usize, usize)| {
                    place.is_none_or(|(found, _)| other.abs_diff(row) < found.abs_diff(row))
                };
                if last.is_some_and(is_nearer) {
                    *place = last;
                }
            }
        };
        carry(&mut (0..rows));
        carry(&mut (0..rows).rev());
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of an L: coarse ones every four cells, and fine ones in one corner.
    fn shares() -> Vec<[f64; 2]> {
        let coarse = (0..3).flat_map(|x| (0..3).map(move |y| [4 * x, 4 * y]));
        let fine = (0..5).flat_map(|x| (0..5).map(move |y| [x, y]));
        coarse.chain(fine).map(|node| node.map(|i| (f64::from(i) + 0.5) / 9.0)).collect()
    }

    fn centre(share: f64) -> usize {
        (share * 9.0) as usize
    }

    #[test]
    fn truth_every_place_is_that_of_its_nearest_variant_and_covered_once() {
        let shares = shares();
        let mut covered = [[0; 9]; 9];
        for tile in tiles(&shares, [9, 9], [4.0, 4.0]) {
            for (x, y) in (tile.columns[0]..tile.columns[0] + tile.columns[1])
                .flat_map(|x| (tile.rows[0]..tile.rows[0] + tile.rows[1]).map(move |y| (x, y)))
            {
                covered[x][y] += 1;
                let distance = |[a, b]: [f64; 2]| centre(a).abs_diff(x).pow(2) + centre(b).abs_diff(y).pow(2);
                let least = shares.iter().map(|share| distance(*share)).min().unwrap();
                assert_eq!(distance(shares[tile.of]), least, "{x} {y}");
            }
        }
        assert!(covered.iter().flatten().all(|count| *count == 1), "{covered:?}");
    }

    /// Twice the distance along the first axis equals once that along the second.
    #[test]
    fn truth_distances_are_counted_in_the_units_of_the_axes() {
        let found = tiles(&[[0.05, 0.05], [0.95, 0.95]], [10, 10], [2.0, 1.0]);
        let of = |x: usize, y: usize| {
            let holds = |range: [usize; 2], at: usize| (range[0]..range[0] + range[1]).contains(&at);
            found.iter().find(|tile| holds(tile.columns, x) && holds(tile.rows, y)).unwrap().of
        };
        assert_eq!((of(9, 1), of(0, 8)), (0, 1));
    }
}
