//! The part of a drive's chain that acts on held commands: noise, delay, deadband, gain and limit. It is
//! exact at any step.

use std::collections::VecDeque;

use feeler_catalogue::Tabled;
use feeler_control::{Draws, Stream};
use feeler_lanes::Lane;
use feeler_plant::assembly::Drive;
use feeler_plant::description::Actuator;

use crate::sample::sensing::noise_index;

/// One drive of every lane.
#[derive(Clone, Debug)]
pub struct DriveChain<L> {
    pub delay_s: f64,
    deadband: L,
    gain: L,
    /// Infinite if the limit applies to the force after its dynamics.
    limit: L,
    /// Standard deviation of the noise on each command, and its random numbers; `None` without noise.
    noise: Option<(L, Draws)>,
    /// Commands in transit: arrival time and value.
    pending: VecDeque<(f64, L)>,
    /// The command as the controllers issued it.
    pub command: L,
}

impl<L: Lane> DriveChain<L> {
    /// The drives must have the same delay.
    pub fn new(of_lane: &[&Drive], seed: u64) -> Self {
        let number = |f: &dyn Fn(&Drive) -> f64| L::from_fn(|lane| f(of_lane[lane]));
        // A target has its own delay and gain; deadband and limit act in the loop of the servo.
        let target = |drive: &Drive| drive.sampling().map(|sampling| sampling.target);
        let of = |drive: &Drive, target_has: f64, held: f64| target(drive).map_or(held, |_| target_has);
        Self {
            delay_s: target(of_lane[0]).map_or(of_lane[0].delay, |target| target.delay),
            deadband: number(&|drive| of(drive, 0.0, drive.held_deadband())),
            gain: number(&|drive| target(drive).map_or(drive.gain, |target| target.gain)),
            limit: number(&|drive| of(drive, f64::INFINITY, drive.held_limit())),
            noise: of_lane.iter().any(|drive| drive.noise > 0.0).then(|| {
                let stream = Stream::new(seed, &Actuator::place(&of_lane[0].name));
                (number(&|drive| drive.noise), Draws::new(stream))
            }),
            pending: VecDeque::new(),
            command: L::zero(),
        }
    }

    /// Takes a new command at `t_s`. Returns the command on which the drive now acts, unless it is delayed.
    pub fn issue(&mut self, t_s: f64, command: L) -> Option<L> {
        self.command = command;
        let command = match &mut self.noise {
            Some((sigma, draws)) => command + *sigma * L::splat(draws.normal_at(noise_index(t_s))),
            None => command,
        };
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

    /// The delayed command that is due, as the drive applies it.
    pub fn arrive(&mut self) -> Option<L> {
        self.pending.pop_front().map(|(_, command)| self.effective(command))
    }

    fn effective(&self, command: L) -> L {
        let beyond = command - command.clamp_to(self.deadband);
        (beyond * self.gain).clamp_to(self.limit)
    }
}
