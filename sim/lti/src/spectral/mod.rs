//! Estimation of spectra and frequency responses from records, as an analyst would do it on the robot.
//!
//! The estimator for each excitation:
//!
//! | excitation | function |
//! |---|---|
//! | noise, many averages | [`cross_spectra`] then [`CrossSpectra::response`] |
//! | noise, one short record | [`local_polynomial`] |
//! | chirp | [`smoothed_spectra`] then [`CrossSpectra::response`] |
//! | multisine, several periods | [`periodic_response`] |
//! | random-phase multisine, several realisations | [`best_linear_approximation`] |
//! | stepped sine | [`stepped_sine`] |
//! | sum of sines of any frequencies | [`response_at_sines`] |
//!
//! [`recognise_excitation`] finds the kind of a recorded command. [`common_poles`] finds the resonances that
//! several estimated responses share.
//!
//! Records are uniformly sampled; spectra are one-sided; cross spectra are conj(input) times output.

mod amplitude;
mod distortion;
mod estimate;
mod evidence;
mod fft;
mod local_polynomial;
mod multisine;
mod periodic;
mod rational;
mod recognise;
mod sine;
mod sum_of_sines;
mod welch;
mod window;

pub use amplitude::{AmplitudeSpectrum, amplitude_spectrum, dominant_frequency};
pub use distortion::{
    BestLinearApproximation, DistortionBeside, Realisation, best_linear_approximation, distortion_beside,
};
pub use estimate::{ResponseBand, ResponseEstimate};
pub use evidence::{ComplexDegrees, Evidence};
pub use local_polynomial::{LocalPolynomialSettings, local_polynomial};
pub use multisine::Multisine;
pub use periodic::{PeriodicRecord, periodic_response};
pub use rational::common_poles;
pub use recognise::{RecordedExcitation, excited_lines, recognise_excitation};
pub use sine::{SineFit, SteppedSinePoint, fit_sine, stepped_sine};
pub use sum_of_sines::{SineSum, find_sines, response_at_sines};
pub use welch::{CrossSpectra, Estimator, WelchSettings, cross_spectra, smoothed_spectra};
pub use window::Window;
