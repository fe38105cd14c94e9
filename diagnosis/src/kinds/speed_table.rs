//! `speed-table`: a force over speed that no law explains. It is not tried as a cause.

use feeler_plant::effects::SpeedTable;

use super::{Known, Over};

impl Known for SpeedTable {
    const IS_CAUSE: bool = false;
    const TABLE_OVER: Option<Over> = Some(Over::Speed);
}
