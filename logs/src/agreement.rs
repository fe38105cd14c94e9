//! One unit for the clocks of the tables of a run.

use crate::table::Table;

/// Clocks of one name in tables that belong together have one unit: that of the table with the most rows.
pub(crate) fn agree(tables: &mut [Table]) {
    let Some(longest) = tables.iter().filter(|table| table.clock.is_some()).max_by_key(|table| table.rows())
    else {
        return;
    };
    let (Some(known), name) = (longest.clock.clone(), longest.name.clone()) else { return };
    for table in tables {
        let Some(clock) = table.clock.as_mut().filter(|clock| clock.column == known.column) else { continue };
        if clock.unit == known.unit {
            continue;
        }
        let ratio = clock.unit.per_second() / known.unit.per_second();
        table.times_s.iter_mut().for_each(|t| *t *= ratio);
        clock.origin_s *= ratio;
        (clock.unit, clock.why) = (known.unit, format!("as in `{name}`"));
    }
}
