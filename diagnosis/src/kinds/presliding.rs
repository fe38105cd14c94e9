//! `presliding`: fits allow for it beside every dry friction, so it is not tried as a cause.

use feeler_plant::effects::Presliding;

use super::Known;

impl Known for Presliding {
    const IS_CAUSE: bool = false;
}
