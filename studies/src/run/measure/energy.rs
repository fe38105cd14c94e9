//! The energy ledger as a table.

use feeler_engine::EnergyBalance;
use feeler_plant::motion::MeterKind;
use serde::Serialize;

/// Energy that one element fed or dissipated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnergyItem {
    /// `drive-work`, `load-work`, `feed-work`, `link-damping`, `friction`, `contact-damping`, or
    /// `controller-work`.
    pub what: &'static str,
    /// Name of the element.
    pub on: String,
    /// Energy, J; positive into the machine for works, out of it for losses.
    pub joule: f64,
}

/// Supplied, dissipated and stored energy.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EnergyTable {
    /// Work done on the machine, J.
    pub supplied: Vec<EnergyItem>,
    /// Energy dissipated, J.
    pub dissipated: Vec<EnergyItem>,
    /// Work of each controller's command through its drive, J, as a part of the drives' work. Controllers
    /// without work, and those of velocity sources, are omitted.
    pub controllers: Vec<EnergyItem>,
    /// Kinetic energy at start and end, J.
    pub kinetic: [f64; 2],
    /// Elastic energy, and the potential one of weights, at start and end, J.
    pub elastic: [f64; 2],
    /// Supplied less stored and dissipated energy, J: rounding.
    pub residual: f64,
    /// All energy exchanged and stored, in magnitude, J.
    pub exchanged: f64,
    /// The residual over `exchanged`.
    pub relative_residual: f64,
}

impl EnergyTable {
    /// The table of a balance.
    pub fn new(balance: &EnergyBalance) -> Self {
        let item = |what, on: &String, joule| EnergyItem { what, on: on.clone(), joule };
        let meters = |enters: bool| {
            let meant = balance.meters.iter().filter(move |(kind, ..)| kind.enters() == enters);
            meant.map(|(kind, on, joule)| item(name(*kind), on, *joule)).collect()
        };
        let (residual, exchanged) = (balance.residual(), balance.exchanged());
        Self {
            supplied: meters(true),
            dissipated: meters(false),
            controllers: balance
                .controllers
                .iter()
                .filter(|(_, joule)| *joule != 0.0)
                .map(|(on, joule)| item("controller-work", on, *joule))
                .collect(),
            kinetic: balance.kinetic,
            elastic: balance.elastic,
            residual,
            exchanged,
            relative_residual: if exchanged > 0.0 { residual.abs() / exchanged } else { 0.0 },
        }
    }
}

fn name(kind: MeterKind) -> &'static str {
    match kind {
        MeterKind::DriveWork => "drive-work",
        MeterKind::LoadWork => "load-work",
        MeterKind::FeedWork => "feed-work",
        MeterKind::LinkDamping => "link-damping",
        MeterKind::Friction => "friction",
        MeterKind::ContactDamping => "contact-damping",
    }
}
