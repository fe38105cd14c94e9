//! `presliding`: every dry friction has it, so that fits allow for it and it is no cause.

use feeler_plant::effects::Presliding;

use super::Known;

impl Known for Presliding {
    const IS_CAUSE: bool = false;
}
