//! A sensor as read by a controller or a recorder.

use feeler_control::Draws;
use feeler_lanes::Lane;

use crate::run::wanted::Tapped;
use crate::sample::clock::due;
use crate::sample::sensing::Sensing;
use crate::sample::taps::Tap;

/// One reader of one sensor.
#[derive(Clone, Debug)]
pub(crate) struct Reading<L> {
    tapped: Tapped,
    /// Past values of the signal; `None` without a delay.
    tap: Option<Tap<L>>,
    draws: Draws,
}

impl<L: Lane> Reading<L> {
    /// A reader whose first reading is at `first_s`.
    pub(crate) fn new(tapped: Tapped, sensors: &[Sensing<L>], first_s: f64) -> Self {
        let delay_s = sensors[tapped.sensor].delay_s;
        let tap = (delay_s > 0.0).then(|| Tap::new(tapped.signal, delay_s, first_s));
        Self { tapped, tap, draws: sensors[tapped.sensor].draws() }
    }

    pub(crate) fn is_delayed(&self) -> bool {
        self.tap.is_some()
    }

    /// The signal that it takes before it reads; `None` without a delay.
    pub(crate) fn delayed_signal(&self) -> Option<usize> {
        self.tap.as_ref().map(|tap| tap.signal)
    }

    /// When the next signal for a later reading is due, s.
    #[inline(always)]
    pub(crate) fn next_s(&self) -> f64 {
        self.tap.as_ref().map_or(f64::INFINITY, |tap| tap.next_s)
    }

    /// When the first signal later than `t_s` is due, s; not later than `t_s` if that is not known yet.
    #[inline(always)]
    pub(crate) fn next_after_s(&self, t_s: f64) -> f64 {
        let of = |tap: &Tap<L>| if due(tap.next_s, t_s) { tap.after_s } else { tap.next_s };
        self.tap.as_ref().map_or(f64::INFINITY, of)
    }

    /// Takes the signal for every later reading that needs it now; `instant_of(k)` is the time of reading
    /// `k`.
    #[inline(always)]
    pub(crate) fn take(&mut self, t_s: f64, signals: &[L], instant_of: impl Fn(u64) -> f64) {
        if let Some(tap) = &mut self.tap {
            tap.take(t_s, signals[tap.signal], instant_of);
        }
    }

    /// The reading at `t_s`.
    #[inline(always)]
    pub(crate) fn read(&mut self, t_s: f64, signals: &[L], sensors: &[Sensing<L>]) -> L {
        let signal = match &mut self.tap {
            Some(tap) => tap.pop(),
            None => signals[self.tapped.signal],
        };
        sensors[self.tapped.sensor].read_ahead(t_s, signal, &mut self.draws)
    }
}
