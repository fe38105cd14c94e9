//! The energy ledger: the energy that every element fed, dissipated and stores.

use feeler_plant::motion::{Ledger, MeterKind, Motion, Storage, StorageKind, Switch, dot};

use crate::solve::flow::Flow;

/// Nodes in `[0, 1]` and weights of eight-point Gauss-Legendre quadrature (Abramowitz and Stegun, table
/// 25.4), exact to degree 15.
pub(crate) const GAUSS_NODES: [(f64, f64); 8] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_63),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_63),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// Running sums of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EnergyLedger {
    /// Energy counted by each meter of the machine, J.
    pub(super) meters: Vec<f64>,
    pub(super) initial: Vec<Storage>,
    /// Work of each controller through its drive, J.
    pub(super) controllers: Vec<f64>,
}

impl EnergyLedger {
    /// Starts anew at a state.
    pub(crate) fn begin(&mut self, motion: &Motion, flow: &Flow, xi: &[f64]) {
        let initial = motion.storage(&flow.equations, xi);
        *self = Self { meters: vec![0.0; flow.ledger.meters.len()], initial, controllers: Vec::new() };
    }

    pub(crate) fn add_powers(&mut self, ledger: &Ledger, xi: &[f64], weight: f64) {
        for (sum, meter) in self.meters.iter_mut().zip(&ledger.meters) {
            *sum += weight * dot(&meter.force, xi) * dot(&meter.speed, xi);
        }
    }

    /// `switch` changes the machine from the first flow to the second. A contact or stop that switches while
    /// compressed loses (or regains) its stored energy, which is charged to its damping.
    pub(crate) fn switch(
        &mut self,
        motion: &Motion,
        [before, after]: [&Flow; 2],
        switch: Switch,
        xi: &[f64],
    ) {
        let (storage, kind, element) = match switch {
            Switch::Contact(i) => (StorageKind::Contact, MeterKind::ContactDamping, i),
            Switch::Stop(i, _) => (StorageKind::Link, MeterKind::LinkDamping, i),
            _ => return,
        };
        let stored = |flow: &Flow| {
            motion
                .storage(&flow.equations, xi)
                .iter()
                .filter(|s| s.kind == storage && s.element == element)
                .map(|s| s.joule)
                .sum::<f64>()
        };
        let lost = stored(before) - stored(after);
        if let Some(i) =
            before.ledger.meters.iter().position(|meter| meter.kind == kind && meter.element == element)
        {
            self.meters[i] += lost;
        }
    }
}

impl EnergyLedger {
    pub(crate) fn charge_controllers(&mut self, works: impl Iterator<Item = f64>) {
        for (i, work) in works.enumerate() {
            if i == self.controllers.len() {
                self.controllers.push(0.0);
            }
            self.controllers[i] += work;
        }
    }

    pub(crate) fn balance(
        &self,
        motion: &Motion,
        flow: &Flow,
        xi: &[f64],
        controllers: &[String],
    ) -> EnergyBalance {
        let assembly = motion.assembly();
        let name = |kind: MeterKind, element: usize| match kind {
            MeterKind::DriveWork => &assembly.drives[element].name,
            MeterKind::LoadWork | MeterKind::LinkDamping | MeterKind::Friction => {
                &assembly.links[element].name
            }
            MeterKind::FeedWork | MeterKind::ContactDamping => &assembly.contacts[element].name,
        };
        let mut meters: Vec<(MeterKind, String, f64)> = Vec::new();
        let mut last_of = None;
        for (meter, joule) in flow.ledger.meters.iter().zip(&self.meters) {
            let of = Some((meter.kind, meter.element));
            match meters.last_mut().filter(|_| of == last_of) {
                Some((_, _, sum)) => *sum += joule,
                None => meters.push((meter.kind, name(meter.kind, meter.element).clone(), *joule)),
            }
            last_of = of;
        }
        let last = motion.storage(&flow.equations, xi);
        let sum = |list: &[Storage], kinetic: bool| {
            list.iter().filter(|s| (s.kind == StorageKind::Kinetic) == kinetic).map(|s| s.joule).sum()
        };
        EnergyBalance {
            meters,
            controllers: controllers.iter().cloned().zip(self.controllers.iter().copied()).collect(),
            kinetic: [sum(&self.initial, true), sum(&last, true)],
            elastic: [sum(&self.initial, false), sum(&last, false)],
        }
    }
}

/// The balance of a finished run, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Energy of each meter: its kind, the element's name, and the amount.
    pub meters: Vec<(MeterKind, String, f64)>,
    /// Work of each controller's command through its drive, by name: the command times the stroke over which
    /// it was held. A velocity source has none.
    pub controllers: Vec<(String, f64)>,
    /// Kinetic energy at start and end.
    pub kinetic: [f64; 2],
    /// Elastic energy and the potential energy of weights, at start and end.
    pub elastic: [f64; 2],
}

impl EnergyBalance {
    /// Energy fed, less energy dissipated, less the growth of stored energy: zero except for errors of the
    /// method.
    pub fn residual(&self) -> f64 {
        let flow: f64 =
            self.meters.iter().map(|(kind, _, joule)| if kind.enters() { *joule } else { -joule }).sum();
        flow - (self.kinetic[1] + self.elastic[1] - self.kinetic[0] - self.elastic[0])
    }

    /// Sum of the magnitudes of all exchanged and stored energy: the scale for the residual.
    pub fn exchanged(&self) -> f64 {
        self.meters.iter().map(|(_, _, joule)| joule.abs()).sum::<f64>()
            + self.kinetic.iter().chain(&self.elastic).sum::<f64>()
    }
}
