//! `force-table`: a force over position that no law explains. It is not tried as a cause.

use feeler_plant::effects::ForceTable;

use super::{Known, Over};

impl Known for ForceTable {
    const IS_CAUSE: bool = false;
    const TABLE_OVER: Option<Over> = Some(Over::Position);
}
