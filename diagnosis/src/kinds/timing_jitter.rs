//! `timing-jitter`: the recorded commands already contain its effect, so it is not tried.

use feeler_plant::effects::TimingJitter;

use super::Known;

impl Known for TimingJitter {}
