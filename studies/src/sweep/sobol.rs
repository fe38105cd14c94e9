//! The Sobol sequence, a low-discrepancy sequence.
//!
//! Source: S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM
//! J. Sci. Comput. 30 (2008): primitive polynomials and initial direction numbers of the first dimensions.

use feeler_files::MOST_DIMENSIONS;

/// Degree and coefficients of each dimension's polynomial, and its initial direction numbers; the first
/// dimension, van der Corput's, has none.
const DIMENSIONS: [(u32, u32, &[u32]); 20] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
];

const _: () =
    assert!(MOST_DIMENSIONS == DIMENSIONS.len() + 1, "files allow as many axes as there are dimensions");
const BITS: u32 = 32;

/// The point of this index in one dimension, as a fraction of 2^32.
pub(crate) fn sobol(dimension: usize, index: u32) -> u32 {
    // In the order of Gray's code, which visits the same points.
    let gray = index ^ (index >> 1);
    let directions = directions(dimension);
    (0..BITS).filter(|bit| gray >> bit & 1 == 1).fold(0, |point, bit| point ^ directions[bit as usize])
}

fn directions(dimension: usize) -> [u32; BITS as usize] {
    let mut v: [u32; BITS as usize] = std::array::from_fn(|i| 1 << (BITS as usize - 1 - i));
    let Some(&(degree, coefficients, initial)) = dimension.checked_sub(1).and_then(|i| DIMENSIONS.get(i))
    else {
        return v;
    };
    let s = degree as usize;
    for (i, m) in initial.iter().enumerate() {
        v[i] = m << (BITS as usize - 1 - i);
    }
    for i in s..BITS as usize {
        v[i] = v[i - s] ^ (v[i - s] >> s);
        for k in 1..s {
            if coefficients >> (s - 1 - k) & 1 == 1 {
                v[i] ^= v[i - k];
            }
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Every dimension puts one of the first 2^10 points into each of as many slices.
    #[test]
    fn truth_each_dimension_is_stratified() {
        for dimension in 0..MOST_DIMENSIONS {
            let slices: HashSet<u32> = (0..1024).map(|i| sobol(dimension, i) >> 22).collect();
            assert_eq!(slices.len(), 1024, "dimension {dimension}");
        }
    }

    /// Any two of the first dimensions put one of the first 2^8 points into each box of 16 by 16 (a net of
    /// strength zero).
    #[test]
    fn reference_the_first_two_dimensions_are_a_net() {
        let boxes: HashSet<(u32, u32)> = (0..256).map(|i| (sobol(0, i) >> 28, sobol(1, i) >> 28)).collect();
        assert_eq!(boxes.len(), 256);
    }
}
