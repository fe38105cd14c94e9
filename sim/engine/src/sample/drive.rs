//! The part of a drive's chain that acts on held commands: delay, deadband, gain and limit. All of it is
//! exact at any step.

use std::collections::VecDeque;

use feeler_lanes::Lane;
use feeler_plant::assembly::Drive;

/// One drive of every lane.
#[derive(Clone, Debug)]
pub struct DriveChain<L> {
    /// How late commands arrive.
    pub delay_s: f64,
    deadband: L,
    gain: L,
    /// Infinite for a velocity source, whose limit is on the force it builds up.
    limit: L,
    /// Commands under way: when they arrive, and what they are.
    pending: VecDeque<(f64, L)>,
    /// The command as the controllers issued it.
    pub command: L,
}

impl<L: Lane> DriveChain<L> {
    /// The drives must agree in their delay.
    pub fn new(of_lane: &[&Drive]) -> Self {
        let number = |f: &dyn Fn(&Drive) -> f64| L::from_fn(|lane| f(of_lane[lane]));
        Self {
            delay_s: of_lane[0].delay,
            deadband: number(&|drive| drive.deadband),
            gain: number(&|drive| drive.gain),
            limit: number(&|drive| if drive.velocity_source.is_some() { f64::INFINITY } else { drive.limit }),
            pending: VecDeque::new(),
            command: L::zero(),
        }
    }

    /// Takes a new command at `t_s`. Gives what the drive acts on from now, unless the command is delayed.
    pub fn issue(&mut self, t_s: f64, command: L) -> Option<L> {
        self.command = command;
        if self.delay_s > 0.0 {
            self.pending.push_back((t_s + self.delay_s, command));
            None
        } else {
            Some(self.effective(command))
        }
    }

    /// When the next delayed command arrives.
    pub fn next_arrival_s(&self) -> f64 {
        self.pending.front().map_or(f64::INFINITY, |(t, _)| *t)
    }

    /// The delayed command that is due, as the drive acts on it.
    pub fn arrive(&mut self) -> Option<L> {
        self.pending.pop_front().map(|(_, command)| self.effective(command))
    }

    fn effective(&self, command: L) -> L {
        let beyond = command - command.clamp_to(self.deadband);
        (beyond * self.gain).clamp_to(self.limit)
    }
}
