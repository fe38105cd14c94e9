//! Removes or fixes the switching parts of a machine before it is linearised.

use feeler_plant::assembly::{Assembly, Friction, GROUND_NODE};
use feeler_plant::description::Engagement;

/// The state of the contacts in a linear view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactView {
    /// Clamped and free contacts as in the machine; a unilateral one touches, without preload.
    #[default]
    AsDescribed,
    /// All contacts attached, without preload: where the bodies stand, or where a unilateral one touches.
    Clamped,
    /// All in contact; the first one carries this force (N), and drives hold it.
    Pressed {
        /// On the first contact, N.
        preload_n: f64,
    },
    /// All absent.
    Free,
}

/// The treatment of dry friction, which has no linear counterpart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrictionView {
    /// Everything slides in one direction: a constant force, which small motions do not feel.
    #[default]
    Ignored,
    /// Every guide with friction sticks: its two bodies move as one.
    Stuck,
}

/// The treatment of free play.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlayView {
    /// Closed on one side, so that the link acts.
    #[default]
    Closed,
    /// Open: the link does not act.
    Open,
}

/// A drive under a command that does not change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldCommand {
    /// The drive, a force drive.
    pub drive: usize,
    /// Its command, in its unit.
    pub command: f64,
}

/// The view of a machine about which it is linearised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    pub contact: ContactView,
    pub friction: FrictionView,
    pub play: PlayView,
    /// The single command under which the machine rests, with all other drives at zero. `None` if drives hold
    /// the machine as needed.
    pub held: Option<HeldCommand>,
}

impl View {
    /// All contacts clamped, as the paper's linear models assume.
    pub const CLAMPED: Self = Self {
        contact: ContactView::Clamped,
        friction: FrictionView::Ignored,
        play: PlayView::Closed,
        held: None,
    };
    /// No contact.
    pub const FREE: Self = Self { contact: ContactView::Free, ..Self::CLAMPED };

    /// Force on the first contact at the operating point.
    pub fn preload_n(&self) -> f64 {
        if let ContactView::Pressed { preload_n } = self.contact { preload_n } else { 0.0 }
    }
}

/// The machine without switches: limits are not reached, deadbands are crossed, and bodies start at rest.
pub(crate) fn without_switches(assembly: &Assembly, view: &View) -> Assembly {
    let mut frozen = assembly.clone();
    for node in &mut frozen.nodes {
        node.velocity_m_per_s = 0.0;
    }
    for contact in &mut frozen.contacts {
        // Motion of a surface is a disturbance and not part of the linear machine.
        contact.profile = None;
        contact.engagement = match (view.contact, contact.engagement) {
            (ContactView::Free, _) | (ContactView::AsDescribed, Engagement::Free) => Engagement::Free,
            // In contact a unilateral law equals the clamped one about its operating point.
            _ => Engagement::Clamped,
        };
    }
    for link in &mut frozen.links {
        if link.friction.acts() && view.friction == FrictionView::Stuck {
            match link.presliding {
                Some(presliding) => {
                    link.stiffness += presliding.stiffness;
                    link.damping += presliding.damping(assembly.sliding_mass_kg(link));
                }
                None => link.rigid = true,
            }
        }
        link.friction = Friction::NONE;
        // At rest asymmetry does not act, drag has no slope, and bristles are a spring and a damper.
        (link.asymmetry, link.drag) = (0.0, 0.0);
        if let Some(bristle) = link.bristle.take() {
            link.stiffness += bristle.stiffness;
            link.damping += bristle.damping;
        }
        let is_open = (link.play > 0.0 && view.play == PlayView::Open) || link.stop.is_some();
        (link.play, link.stop) = (0.0, None);
        if is_open {
            (link.stiffness, link.damping, link.cubic) = (0.0, 0.0, 0.0);
        }
    }
    if frozen.depends_on_position() {
        close_gaps(&mut frozen, assembly);
    }
    for drive in &mut frozen.drives {
        drive.limit = f64::INFINITY;
        drive.command_limit = f64::INFINITY;
        drive.line = None;
        drive.warming = None;
        drive.rate_limit = f64::INFINITY;
        drive.interval = 0.0;
        drive.deadband = 0.0;
    }
    frozen
}

/// Moves the tip of each unilateral contact that counts as attached to the place where it touches. The last
/// contact comes first, so a tip still touches if its workpiece moves to another contact.
fn close_gaps(frozen: &mut Assembly, described: &Assembly) {
    for (i, contact) in described.contacts.iter().enumerate().rev() {
        let is_attached = frozen.contacts[i].engagement == Engagement::Clamped;
        let moving = frozen.reached(vec![contact.a], &[], |link| link.rigid);
        if contact.engagement != Engagement::Unilateral || !is_attached || moving.contains(&GROUND_NODE) {
            continue;
        }
        let missing = contact.gap + frozen.nodes[contact.b].position_m - frozen.nodes[contact.a].position_m;
        for node in moving {
            frozen.nodes[node].position_m += missing;
        }
    }
}
