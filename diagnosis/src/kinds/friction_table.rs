//! `friction-table`: what is left when nothing else explains it, so no fit finds it as a cause.

use feeler_plant::effects::FrictionTable;

use super::Known;

impl Known for FrictionTable {
    const IS_CAUSE: bool = false;
}
