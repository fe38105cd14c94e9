//! Frequency responses as an analyst measures them, with the response of linear theory beside them.
//!
//! [`simulate`] excites the simulated machine. [`choose`] and [`evaluate`] evaluate records of a real one and
//! recognise the excitation of the command. Both give a [`FrequencyResponse`] with the agreement between
//! theory and measurement.

mod agreement;
mod between;
mod distortion;
mod error;
mod evaluate;
mod recognise;
mod request;
mod response;
mod rows;
mod simulated;

pub use agreement::{COHERENT, INCOHERENT, Incoherent, KNOWN_DEG, LinearAgreement};
pub use between::{between, require_path, sensed};
pub use distortion::{DistortionBand, Separated};
pub use error::{FrfError, require};
pub use evaluate::{Evaluated, evaluate};
pub use recognise::{Method, MethodChoice, RecordPair, SEGMENTS, choose};
pub use request::{ExcitationKind, FrfRequest, NoiseEstimator};
pub use response::{FrequencyResponse, Levels};
pub use rows::{FrfRow, csv, json, row};
pub use simulated::simulate;
