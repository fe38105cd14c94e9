//! Springs of a machine that may be made rigid, by the mode that strains each most.

use feeler_lti::C64;
use feeler_plant::assembly::NodeId;

use crate::loops::control_loop::ControlLoop;
use crate::machine::modes::{ModeClass, ModeInPair, VibrationMode};

/// Largest number of rows for springs.
const MOST_ROWS: usize = 12;

/// Springs of one row.
pub(crate) struct Springs<'a> {
    pub(crate) name: String,
    pub(crate) links: &'a [(usize, ModeClass)],
}

/// The representative of each node after two nodes are joined.
fn merged(joined: &[NodeId], a: NodeId, b: NodeId) -> Vec<NodeId> {
    joined.iter().map(|&of| if of == joined[b] { joined[a] } else { of }).collect()
}

impl ControlLoop {
    /// Springs that can be made rigid while every drive can still move, with the class of the mode that
    /// strains each most. Sorted by the frequency of that mode.
    pub(crate) fn flexible_links(
        &self,
        modes: &[VibrationMode],
        pairs: &[ModeInPair],
    ) -> Vec<(usize, ModeClass)> {
        let plant = self.plant();
        let layout = plant.motion().layout();
        let strain = |i: usize, mode: &VibrationMode| {
            let row = &plant.equations().elongation[i][0];
            let e: C64 = (0..layout.coordinates()).map(|g| mode.vector[layout.q(g)] * row[layout.q(g)]).sum();
            let speed: f64 = (0..layout.coordinates()).map(|g| mode.vector[layout.v(g)].norm_sqr()).sum();
            e.norm_sqr() / speed
        };
        let mut links: Vec<(f64, usize, ModeClass)> = Vec::new();
        for (i, link) in plant
            .motion()
            .assembly()
            .links
            .iter()
            .enumerate()
            .filter(|(_, link)| !link.rigid && link.stiffness > 0.0)
        {
            let flexible = (0..modes.len()).filter(|&m| !pairs[m].rigid_body);
            let most = flexible.max_by(|&a, &b| {
                (link.stiffness * strain(i, &modes[a])).total_cmp(&(link.stiffness * strain(i, &modes[b])))
            });
            if let Some(m) = most {
                links.push((modes[m].frequency_hz(), i, pairs[m].class));
            }
        }
        links.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut joined = self.joined_by_rigid_links();
        // Starting with the stiffest: with all of them rigid, the drive must still be able to move.
        let mut kept = vec![true; links.len()];
        for (kept, (_, i, _)) in kept.iter_mut().zip(&links).rev() {
            let link = &self.assembly().links[*i];
            let after = merged(&joined, link.a, link.b);
            *kept = self
                .controllers()
                .iter()
                .all(|c| self.drive_moves(c.drive, &after) || !self.drive_moves(c.drive, &joined));
            if *kept {
                joined = after;
            }
        }
        links.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|((_, i, class), _)| (i, class)).collect()
    }

    /// Springs by rows of the waterfall: one each, or neighbours in frequency together if there are many.
    pub(crate) fn in_rows<'a>(&self, flexible: &'a [(usize, ModeClass)]) -> Vec<Springs<'a>> {
        let row = |links: &'a [(usize, ModeClass)]| {
            let first = &self.assembly().links[links[0].0].name;
            let others =
                if links.len() > 1 { format!(" and {} more", links.len() - 1) } else { String::new() };
            Springs { name: format!("springs.{first}{others}"), links }
        };
        flexible.chunks(flexible.len().div_ceil(MOST_ROWS).max(1)).map(row).collect()
    }

    /// For each node, the representative of the nodes that move with it as one.
    fn joined_by_rigid_links(&self) -> Vec<NodeId> {
        let apart: Vec<NodeId> = (0..self.assembly().nodes.len()).collect();
        self.assembly()
            .links
            .iter()
            .filter(|link| link.rigid)
            .fold(apart, |joined, link| merged(&joined, link.a, link.b))
    }

    fn drive_moves(&self, drive: usize, joined: &[NodeId]) -> bool {
        let drive = &self.assembly().drives[drive];
        joined[drive.on] != joined[drive.reacts_on]
    }
}
