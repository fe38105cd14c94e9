//! How guides yield before they slide, as an answer states it.

use feeler_catalogue::Tabled;
use feeler_plant::description::{Axis, Spring};
use feeler_plant::effects::Kind;

use crate::answer::causes::NINETY_PERCENT;
use crate::fit::scored::Scored;
use crate::fit::yielding::Yielding;
use crate::judge::Judge;
use crate::report::{Estimate, Presliding};

impl Judge<'_> {
    /// Presliding of the guides of an accepted set.
    pub(super) fn presliding(&self, accepted: &Scored) -> Vec<Presliding> {
        let machine = &self.dataset.machine;
        let parameters = Kind::Presliding.definition().parameters;
        let of = |Yielding { spring, presliding, sigma }: Yielding| {
            let (name, _) = machine.springs.get_index(spring)?;
            let estimate = |i: usize, value: f64| {
                let by = (NINETY_PERCENT * sigma[i]).exp();
                let unit = parameters[i].dimension.si_unit(machine.axis == Axis::Rotational).into_owned();
                Estimate { value, ci90: [value / by, value * by], unit }
            };
            let on = Spring::place(name);
            let [stiffness, damping_ratio] = [(0, presliding.stiffness), (1, presliding.damping_ratio)]
                .map(|(i, value)| estimate(i, value));
            Some(Presliding { on, stiffness, damping_ratio })
        };
        accepted.fitted.yielding().into_iter().filter_map(of).collect()
    }
}
