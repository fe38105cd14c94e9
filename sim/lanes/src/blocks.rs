//! Small matrices of all lanes side by side, and their product with a vector.

use crate::Lane;

/// Rows of a block of a single variant: one AVX-512 register.
const ROWS_OF_ONE: usize = 8;
/// Rows of a block of packs: enough concurrent sums together with those of the next block, and little
/// padding.
const ROWS_OF_PACKS: usize = 4;

/// A matrix per lane. Rows are stored in blocks, each column by column, so that the sums of a block run side
/// by side.
#[derive(Clone, Debug, Default)]
pub struct Blocks<L> {
    entries: Vec<L>,
    width: usize,
    padded_rows: usize,
}

impl<L: Lane> Blocks<L> {
    const ROWS: usize = if L::WIDTH == 1 { ROWS_OF_ONE } else { ROWS_OF_PACKS };

    /// Zero matrices of at least `rows` rows.
    pub fn zeros(rows: usize, width: usize) -> Self {
        let padded_rows = rows.div_ceil(Self::ROWS) * Self::ROWS;
        Self { entries: vec![L::zero(); padded_rows * width], width, padded_rows }
    }

    /// Rows of the product, padded to whole blocks.
    pub fn padded_rows(&self) -> usize {
        self.padded_rows
    }

    /// Replaces row `i` of lane `l`; columns beyond the end of `row` become zero.
    ///
    /// # Panics
    /// If there is no such row or lane.
    pub fn set_row(&mut self, l: usize, i: usize, row: &[f64]) {
        let block = &mut self.entries[(i / Self::ROWS) * Self::ROWS * self.width..];
        for j in 0..self.width {
            block[j * Self::ROWS + i % Self::ROWS].set_lane(l, row.get(j).copied().unwrap_or(0.0));
        }
    }

    /// `y = matrix * xi` over the first columns of `xi`; `y` holds [`Self::padded_rows`]. It must be inlined
    /// into a dispatched kernel.
    #[inline(always)]
    pub fn apply(&self, xi: &[L], y: &mut [L]) {
        if L::WIDTH == 1 {
            self.apply_by::<ROWS_OF_ONE>(xi, y);
        } else {
            self.apply_by::<ROWS_OF_PACKS>(xi, y);
        }
    }

    #[inline(always)]
    fn apply_by<const ROWS: usize>(&self, xi: &[L], y: &mut [L]) {
        let xi = &xi[..self.width];
        for (block, out) in self.entries.chunks_exact(ROWS * self.width).zip(y.chunks_exact_mut(ROWS)) {
            let mut sum = [L::zero(); ROWS];
            for (column, &x) in block.chunks_exact(ROWS).zip(xi) {
                for i in 0..ROWS {
                    sum[i] = column[i].mul_add(x, sum[i]);
                }
            }
            out.copy_from_slice(&sum);
        }
    }
}
