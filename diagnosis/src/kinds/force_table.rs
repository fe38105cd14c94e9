//! `force-table`: the force that no law explains, so no fit finds it as a cause.

use feeler_plant::effects::ForceTable;

use super::Known;

impl Known for ForceTable {
    const IS_CAUSE: bool = false;
}
