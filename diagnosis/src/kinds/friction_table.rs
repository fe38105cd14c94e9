//! `friction-table`: friction over position that no law explains. It is not tried as a cause.

use feeler_plant::effects::FrictionTable;

use super::{Known, Over};

impl Known for FrictionTable {
    const IS_CAUSE: bool = false;
    const TABLE_OVER: Option<Over> = Some(Over::PositionAndDirection);
}
