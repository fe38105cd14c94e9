//! A scale of colours.

/// Cividis (Nuñez, Anderton and Renslow, PLOS ONE 13, 2018), interpolated between these colours. Its
/// lightness rises evenly for all types of colour vision.
const STONES: [[f64; 3]; 6] = [
    [0.0, 34.0, 78.0],
    [49.0, 68.0, 107.0],
    [102.0, 105.0, 112.0],
    [148.0, 142.0, 119.0],
    [200.0, 184.0, 102.0],
    [254.0, 232.0, 56.0],
];

/// The colour at a share of the scale, from low to high.
pub(crate) fn of_share(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (STONES.len() - 1) as f64;
    let below = (at.floor() as usize).min(STONES.len() - 2);
    let part = at - below as f64;
    let [r, g, b] = std::array::from_fn(|i| {
        (STONES[below][i] + part * (STONES[below + 1][i] - STONES[below][i])).round() as u8
    });
    format!("#{r:02x}{g:02x}{b:02x}")
}
