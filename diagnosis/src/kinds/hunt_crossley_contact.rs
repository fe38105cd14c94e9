//! `hunt-crossley-contact`: a contact whose damping grows with its depth.

use feeler_plant::effects::HuntCrossleyContact;

use super::Known;

impl Known for HuntCrossleyContact {}
