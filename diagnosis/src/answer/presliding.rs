//! How guides yield before they slide, as an answer and its machine state it.

use feeler_catalogue::Tabled;
use feeler_plant::description::{Axis, Machine, Spring};
use feeler_plant::effects::{EffectUse, Kind};

use crate::adequacy::Adequacy;
use crate::answer::causes::{NINETY_PERCENT, OF_BLOCKS};
use crate::answer::intervals::BESIDE_FRICTION;
use crate::fit::scored::Scored;
use crate::fit::search::finest;
use crate::fit::yielding::Yielding;
use crate::judge::Judge;
use crate::report::{Estimate, GuidePresliding};

impl Judge<'_> {
    /// The guides of a fitted set that surely yield as fitted. Empty if the answer is inadequate or causes
    /// were left untried: then the guide may yield in place of another cause.
    fn yielding(&self, scored: &Scored, adequacy: &Adequacy) -> Vec<Yielding> {
        if adequacy.is_short() || adequacy.has_untried() {
            return Vec::new();
        }
        let early = &scored.fitted.sigma;
        let widened = |sigma: &[f64]| sigma.iter().map(|sigma| BESIDE_FRICTION * sigma).collect::<Vec<_>>();
        let finest_m = finest(self.dataset, |channel| channel.resolution.max(channel.noise));
        let is_seen = |yielding: &Yielding| yielding.deflection_m > finest_m;
        // The cautious deviations take time, and are never smaller.
        if !scored.fitted.yielding(&widened(early)).iter().any(is_seen) {
            return Vec::new();
        }
        let sure = scored.fitted.yielding(&widened(&self.deviations(scored).cautious));
        sure.into_iter().filter(is_seen).collect()
    }

    /// The machine of a fitted set. Its guides state how they yield.
    pub(super) fn machine_of(&self, scored: &Scored, adequacy: &Adequacy) -> Machine {
        let mut machine = scored.fitted.model.machine(&scored.fitted.theta);
        for Yielding { spring, presliding, .. } in self.yielding(scored, adequacy) {
            let values = vec![presliding.stiffness, presliding.damping_ratio];
            let definition = Kind::Presliding.definition();
            machine.springs[spring].effects.push(EffectUse { definition, values });
        }
        machine
    }

    /// Presliding of the guides of an accepted set, as far as the proposed machine states it.
    pub(super) fn presliding(
        &self,
        accepted: &Scored,
        adequacy: &Adequacy,
        machine: &Machine,
    ) -> Vec<GuidePresliding> {
        let parameters = Kind::Presliding.definition().parameters;
        let of = |Yielding { spring, presliding, sigma, .. }: Yielding| {
            let (name, stated) = machine.springs.get_index(spring)?;
            let values = [presliding.stiffness, presliding.damping_ratio];
            let is_it =
                |effect: &EffectUse| effect.definition.kind == Kind::Presliding && effect.values == values;
            stated.effects.iter().find(|effect| is_it(effect))?;
            let [stiffness, damping_ratio] = [0, 1].map(|i| {
                let by = (OF_BLOCKS * NINETY_PERCENT * sigma[i]).exp();
                let unit = parameters[i].dimension.si_unit(machine.axis == Axis::Rotational).into_owned();
                Estimate { value: values[i], ci90: [values[i] / by, values[i] * by], unit }
            });
            Some(GuidePresliding { on: Spring::place(name), stiffness, damping_ratio })
        };
        self.yielding(accepted, adequacy).into_iter().filter_map(of).collect()
    }
}
