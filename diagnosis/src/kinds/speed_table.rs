//! `speed-table`: what is left when nothing else explains it, so no fit finds it as a cause.

use feeler_plant::effects::SpeedTable;

use super::Known;

impl Known for SpeedTable {
    const IS_CAUSE: bool = false;
}
