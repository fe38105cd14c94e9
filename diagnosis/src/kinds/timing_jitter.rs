//! `timing-jitter`: it disturbs the controller; records hold the commands that came of it, and it is not tried.

use feeler_plant::effects::TimingJitter;

use super::Known;

impl Known for TimingJitter {}
