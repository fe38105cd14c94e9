//! `timing-jitter`: it changes the commands of the controller, which the records contain, so it is not tried.

use feeler_plant::effects::TimingJitter;

use super::Known;

impl Known for TimingJitter {}
