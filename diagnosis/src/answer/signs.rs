//! Gains of a reversed sign: a fault of the records or of the wiring, and no gain of a machine.

use feeler_plant::assembly::Source;
use feeler_plant::description::ElementKind;
use feeler_plant::effects::Trait;

use crate::fit::candidates::Candidate;
use crate::fit::scored::Scored;
use crate::judge::Judge;

impl Judge<'_> {
    /// The columns whose sign an accepted gain reverses, in words.
    pub(super) fn reversed(&self, accepted: &Scored) -> Vec<String> {
        let of = |(i, cause): (usize, &Candidate)| {
            let gain = *accepted.values(i).first().filter(|gain| **gain < 0.0)?;
            cause.definition.has(Trait::LikeUnits).then_some(())?;
            Some(format!(
                "`{}`: has the opposite sign of what the machine file says, with a fitted gain of {gain:.3} \
                 (reverse the sign of this column, or the wiring)",
                self.column_at(cause)?
            ))
        };
        accepted.causes.iter().enumerate().filter_map(of).collect()
    }

    /// The column of the drive or sensor that has a cause.
    fn column_at(&self, cause: &Candidate) -> Option<&str> {
        let index = cause.site.index;
        match cause.site.table {
            ElementKind::Actuators => {
                let driven = self.dataset.drives.iter().find(|driven| driven.drive == index)?;
                Some(&driven.column)
            }
            ElementKind::Sensors => {
                let is_read = |source: Source| matches!(source, Source::Sensor(i) if i == index);
                let read = self.dataset.channels.iter().find(|channel| is_read(channel.source))?;
                Some(&read.column)
            }
            _ => None,
        }
    }
}
