//! Gaps along feeds, each computed once, because most variants of a file keep its shapes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_geometry::{Feed, GeometryError, Placement, Shape, Touching};
use feeler_plant::description::Profile;

/// A tip that is fed along a workpiece: everything on which its gap depends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Travel {
    pub(crate) tip: (Shape, Placement),
    pub(crate) workpiece: (Shape, Placement),
    pub(crate) feed: Feed,
    pub(crate) duration_s: f64,
    pub(crate) error_m: f64,
}

impl Travel {
    fn profile(&self) -> Result<Arc<Profile>, GeometryError> {
        let ((tip, tip_place), (workpiece, workpiece_place)) = (&self.tip, &self.workpiece);
        let touching = Touching::new(tip, tip_place, workpiece, workpiece_place)?;
        let compiled = touching.profile(&self.feed, self.duration_s, self.error_m)?;
        Ok(Arc::new(compiled.profile))
    }
}

/// The last gap of each contact, by its name. Copies of a draft share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gaps(Arc<Mutex<Known>>);

type Known = HashMap<String, (Travel, Arc<Profile>)>;

impl Gaps {
    /// The gap of a contact.
    ///
    /// # Errors
    /// Those of the shapes and of the feed.
    pub(crate) fn of(&self, contact: &str, travel: Travel) -> Result<Arc<Profile>, GeometryError> {
        let known = self.known().get(contact).filter(|(of, _)| *of == travel).map(|(_, gap)| Arc::clone(gap));
        if let Some(gap) = known {
            return Ok(gap);
        }
        let gap = travel.profile()?;
        self.known().insert(contact.to_owned(), (travel, Arc::clone(&gap)));
        Ok(gap)
    }

    /// Each entry is complete, even if a holder of the lock has failed.
    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn travel(radius_m: f64) -> Travel {
        let at = |x_m: f64| Placement::at([x_m, 0.0, 0.0]);
        Travel {
            tip: (Shape::Ball { radius_m }, at(0.0)),
            workpiece: (Shape::Ball { radius_m: 0.05 }, at(0.1)),
            feed: Feed::line([-0.01, 0.0], [0.02, 0.0]),
            duration_s: 1.0,
            error_m: 1e-6,
        }
    }

    #[test]
    fn truth_a_gap_is_computed_anew_only_if_a_shape_changes() {
        let gaps = Gaps::default();
        let first = gaps.of("tool", travel(0.01)).unwrap();
        // A ball of 10 mm moves over the top of a ball of 50 mm at 100 mm, after a travel of 40 mm.
        assert!((first.at(0.5).0 - 0.04).abs() <= 1e-6, "{:?}", first.at(0.5));
        assert!(Arc::ptr_eq(&first, &gaps.clone().of("tool", travel(0.01)).unwrap()));
        let larger = gaps.of("tool", travel(0.02)).unwrap();
        assert!((larger.at(0.5).0 - 0.03).abs() <= 1e-6, "{:?}", larger.at(0.5));
        let again = gaps.of("tool", travel(0.01)).unwrap();
        assert!(!Arc::ptr_eq(&first, &again) && first == again, "the same gap, computed again");
    }
}
