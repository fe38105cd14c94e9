//! The motion between two instants: lanes together by exponentials or fixed steps, and singly through events.

use std::collections::VecDeque;

use feeler_lanes::{Lane, LaneMask};

use crate::carry::bodies::BodyEngine;
use crate::carry::fixed_step::FixedStep;
use crate::carry::lane::{LaneCore, Passage};
use crate::carry::lanes::{Lanes, put_lane, take_lane};
use crate::carry::peaks::PeakWithin;
use crate::carry::transition::Transition;
use crate::error::{EngineError, RunEnd};
use crate::run::program::Program;
use crate::run::settings::Integrator;

/// Largest number of spans whose exponentials are kept; a span gets one when it appears a second time.
const SPANS_KEPT: usize = 32;
/// Femtoseconds per second: spans are rounded to this grid, so that equal intervals share an exponential even
/// if their ends are rounded differently.
const FEMTOSECONDS: f64 = 1e15;

/// How far a lane has come in a span when it leaves the others.
#[derive(Clone, Copy, Default)]
struct Gone {
    gone_s: f64,
    /// Whether the lane has passed the note.
    has_noted: bool,
}

/// Carries lanes from instant to instant.
#[derive(Debug)]
pub(crate) struct Carrier<L: Lane> {
    transitions: Vec<Transition<L>>,
    /// Index of the transition used last.
    last_transition: usize,
    /// Spans that have appeared, each with the time to its note.
    seen_spans: VecDeque<(u64, Option<u64>)>,
    product: Vec<L>,
    fixed: Option<FixedStep<L>>,
    /// Lanes that finish the interval on their own.
    alone: VecDeque<(usize, Passage)>,
    /// End of the interval, s; `None` between intervals.
    ends_s: Option<f64>,
    /// The signals that late readings take.
    noted: Vec<usize>,
    /// Instant within the interval at which late readings take their signals, s; `None` if none does.
    note_s: Option<f64>,
    /// Steps taken: intervals, parts of them, or fixed steps.
    steps: u64,
}

impl<L: Lane> Carrier<L> {
    /// For lanes of these programs; `bodies` are the engines of [`Integrator::External`], one per lane.
    /// `noted` are the signals that late readings take.
    pub(crate) fn new(
        programs: &[Program],
        bodies: Vec<Box<dyn BodyEngine>>,
        lanes: &Lanes<L>,
        noted: Vec<usize>,
    ) -> Result<Self, EngineError> {
        let run = &programs[0].run;
        let needed = if run.integrator == Integrator::External { L::WIDTH } else { 0 };
        if bodies.len() != needed {
            return Err(EngineError::BodyEngines { given: bodies.len(), needed });
        }
        let fixed = (run.integrator != Integrator::Exact)
            .then(|| FixedStep::new(run.integrator, run.step_s, &lanes.cores, bodies));
        Ok(Self {
            transitions: Vec::new(),
            last_transition: 0,
            seen_spans: VecDeque::new(),
            product: Vec::new(),
            fixed,
            alone: VecDeque::new(),
            ends_s: None,
            noted,
            note_s: None,
            steps: 0,
        })
    }

    /// Whether late readings may take signals within an interval. Fixed steps and the ledger stop there.
    #[inline(always)]
    pub(crate) fn takes_notes(&self, lanes: &Lanes<L>) -> bool {
        self.fixed.is_none() && !lanes.keeps_energy()
    }

    /// Instant of the note in the interval that has ended, s. The lanes store its signals.
    #[inline(always)]
    pub(crate) fn finished_note_s(&mut self) -> Option<f64> {
        self.note_s.take()
    }

    /// Steps taken: intervals, parts of them, or fixed steps.
    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// End of the present interval of the lanes, s.
    #[inline(always)]
    pub(crate) fn ends_s(&self) -> Option<f64> {
        self.ends_s
    }

    /// Time of the state of lane `l`, s.
    pub(crate) fn lane_time_s(&self, l: usize, lanes: &Lanes<L>) -> f64 {
        let own = self.alone.iter().find(|(lane, _)| *lane == l).map(|(_, passage)| passage.time_s());
        own.or(self.ends_s).unwrap_or(lanes.t_s)
    }

    /// Starts every lane on the interval to `ends_s`; [`Self::finish`] completes the lanes that go alone.
    /// On the way, at `note_s`, the signals of late readings are noted.
    #[inline(always)]
    pub(crate) fn start(
        &mut self,
        lanes: &mut Lanes<L>,
        ends_s: f64,
        note_s: Option<f64>,
    ) -> Result<(), EngineError> {
        self.ends_s = Some(ends_s);
        self.note_s = note_s;
        let span_s = ends_s - lanes.t_s;
        if self.fixed.is_some() {
            return self.fixed_steps(lanes, span_s);
        }
        if lanes.keeps_energy() {
            self.go_alone(lanes, span_s);
            return Ok(());
        }
        // Usually the same span as last time, or one of a few: comparisons are cheaper than rounding.
        let until_note_s = note_s.map(|note_s| note_s - lanes.t_s);
        let is_over = |known: &Transition<L>| known.is_over(span_s, until_note_s);
        let last = Some(self.last_transition).filter(|&i| self.transitions.get(i).is_some_and(is_over));
        if let Some(index) = last.or_else(|| self.transitions.iter().position(is_over)) {
            self.last_transition = index;
            return self.travel(lanes, index);
        }
        let (span_fs, note_fs) = (in_femtoseconds(span_s), until_note_s.map(in_femtoseconds));
        let is_known = |known: &Transition<L>| known.span_fs == span_fs && known.note_fs == note_fs;
        let known = self.transitions.iter().position(is_known);
        if let Some(index) = known.or_else(|| self.learn(lanes, span_fs, note_fs)) {
            self.last_transition = index;
            self.travel(lanes, index)
        } else {
            self.go_alone(lanes, span_s);
            Ok(())
        }
    }

    /// Carries lanes that go alone to the end of the interval or, with `pauses`, to the next event. Returns
    /// whether all have reached the end.
    #[inline(always)]
    pub(crate) fn finish(&mut self, lanes: &mut Lanes<L>, pauses: bool) -> Result<bool, EngineError> {
        if !self.alone.is_empty() && !self.advance_alone(lanes, pauses)? {
            return Ok(false);
        }
        self.ends_s = None;
        Ok(true)
    }

    /// Makes a transition for a span that has appeared before, and records a new one.
    #[cold]
    fn learn(&mut self, lanes: &Lanes<L>, span_fs: u64, note_fs: Option<u64>) -> Option<usize> {
        if span_fs == 0 || self.transitions.len() == SPANS_KEPT {
            return None;
        }
        if !self.seen_spans.contains(&(span_fs, note_fs)) {
            self.seen_spans.push_back((span_fs, note_fs));
            if self.seen_spans.len() > SPANS_KEPT {
                self.seen_spans.pop_front();
            }
            return None;
        }
        self.transitions.push(Transition::new(span_fs, note_fs, &self.noted, &lanes.cores));
        Some(self.transitions.len() - 1)
    }

    /// Moves all lanes together by the exponential of the span; lanes that meet an event continue alone.
    #[inline(always)]
    fn travel(&mut self, lanes: &mut Lanes<L>, index: usize) -> Result<(), EngineError> {
        self.transitions[index].refresh(lanes.formation.number, &mut lanes.cores)?;
        let travelling = lanes.formation.travelling;
        if lanes.formation.any_alone {
            self.leave_behind(lanes, index, !travelling);
        }
        let mut together = travelling;
        let most_parts = self.transitions[index].rows.most_parts;
        self.product.resize(self.transitions[index].padded_rows(), L::zero());
        for part in 0..most_parts {
            let transition = &self.transitions[index];
            let here = if most_parts == 1 {
                together
            } else {
                together & L::Mask::from_fn(|l| part < transition.rows.parts[l])
            };
            if !here.any() {
                break;
            }
            self.steps += 1;
            let stopped = transition.crossed(here, &lanes.xi, &mut self.product);
            let moved = here & !stopped;
            if !lanes.peaks.is_empty() {
                let with_maxima = transition.pass(moved, &self.product, part, lanes.t_s, &mut lanes.peaks);
                if with_maxima.any() {
                    self.find_maxima(lanes, index, part, with_maxima)?;
                }
            }
            let transition = &self.transitions[index];
            if transition.note_fs.is_some() {
                transition.note(moved, part, &self.product, &mut lanes.signals.noted);
            }
            transition.go(moved, &mut lanes.xi, &mut lanes.signals.values, &self.product);
            if stopped.any() {
                self.stop_before(lanes, index, part, stopped);
                together = together & !stopped;
            }
        }
        lanes.signals.are_fresh = together;
        lanes.settle(together);
        Ok(())
    }

    /// Finds where the forces of lanes peak within one part. Their motion does not change.
    #[cold]
    fn find_maxima(
        &mut self,
        lanes: &mut Lanes<L>,
        index: usize,
        part: u64,
        here: L::Mask,
    ) -> Result<(), EngineError> {
        let transition = &self.transitions[index];
        for (l, core) in lanes.cores.iter_mut().enumerate().filter(|(l, _)| here.test(*l)) {
            for i in 0..lanes.peaks.len() {
                let Some(span) = transition.span(l, i, &self.product) else { continue };
                let from_s = lanes.t_s + part as f64 * span.length_s;
                match span.peak() {
                    PeakWithin::None => {}
                    PeakWithin::At { s, force_n } => lanes.peaks[i].rise_to(l, from_s + s, force_n),
                    PeakWithin::Unclear => {
                        take_lane(&lanes.xi, l, &mut lanes.scratch);
                        let part_fs = transition.span_fs / transition.rows.parts[l];
                        core.exchange_peaks(&mut lanes.peaks, l, |core| {
                            core.peak(&mut lanes.scratch, from_s, part_fs)
                        })?;
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Lanes without exponentials go through the span alone.
    #[cold]
    fn leave_behind(&mut self, lanes: &Lanes<L>, index: usize, behind: L::Mask) {
        let span_s = self.transitions[index].span_fs as f64 / FEMTOSECONDS;
        self.send_alone(lanes, behind, span_s, |_| Gone::default());
    }

    /// Lanes that may have met an event in one part of a span go through the rest of it alone.
    #[cold]
    fn stop_before(&mut self, lanes: &Lanes<L>, index: usize, part: u64, stopped: L::Mask) {
        let transition = &self.transitions[index];
        let span_s = transition.span_fs as f64 / FEMTOSECONDS;
        let (parts, note_parts) = (transition.rows.parts.clone(), transition.rows.note_parts.clone());
        self.send_alone(lanes, stopped, span_s, |l| Gone {
            gone_s: span_s * part as f64 / parts[l] as f64,
            has_noted: part > note_parts[l],
        });
    }

    #[cold]
    fn go_alone(&mut self, lanes: &mut Lanes<L>, span_s: f64) {
        self.steps += 1;
        lanes.signals.are_fresh = L::Mask::splat(false);
        self.send_alone(lanes, L::Mask::splat(true), span_s, |_| Gone::default());
    }

    /// Sends lanes alone to the end of a span, past its note if that is still ahead.
    fn send_alone(&mut self, lanes: &Lanes<L>, mask: L::Mask, span_s: f64, gone: impl Fn(usize) -> Gone) {
        for l in (0..L::WIDTH).filter(|&l| mask.test(l) && !lanes.cores[l].has_ended()) {
            let Gone { gone_s, has_noted } = gone(l);
            let until_note_s =
                self.note_s.filter(|_| !has_noted).map(|note_s| (note_s - lanes.t_s - gone_s).max(0.0));
            self.alone.push_back((l, Passage::new(lanes.t_s + gone_s, span_s - gone_s, until_note_s)));
        }
    }

    /// See [`Self::finish`].
    #[cold]
    fn advance_alone(&mut self, lanes: &mut Lanes<L>, pauses: bool) -> Result<bool, EngineError> {
        let mut changed = false;
        let mut is_through = true;
        while is_through && let Some((l, passage)) = self.alone.front_mut() {
            take_lane(&lanes.xi, *l, &mut lanes.scratch);
            let (core, xi) = (&mut lanes.cores[*l], &mut lanes.scratch);
            let mode = core.current;
            core.exchange_peaks(&mut lanes.peaks, *l, |core| core.advance(xi, passage, pauses))?;
            changed |= core.current != mode || core.has_ended();
            put_lane(&mut lanes.xi, *l, &lanes.scratch);
            if passage.is_through() || core.has_ended() {
                if passage.has_note() {
                    lanes.signals.note(*l, core, &self.noted);
                }
                self.alone.pop_front();
            }
            is_through = !pauses || core.events.is_empty();
        }
        lanes.note_events();
        if changed {
            lanes.formation.form(&lanes.cores);
        }
        Ok(self.alone.is_empty())
    }

    fn fixed_steps(&mut self, lanes: &mut Lanes<L>, span_s: f64) -> Result<(), EngineError> {
        if let Some(fixed) = &mut self.fixed {
            let t_s = lanes.t_s;
            self.steps += fixed.run(&mut lanes.cores, &mut lanes.formation, &mut lanes.xi, t_s, span_s)?;
            lanes.note_events();
        }
        Ok(())
    }
}

fn in_femtoseconds(span_s: f64) -> u64 {
    (span_s * FEMTOSECONDS).round() as u64
}

impl<L: Lane> Lanes<L> {
    /// After a shared step: joins bodies that stick together, and ends lanes whose state has diverged.
    #[inline(always)]
    fn settle(&mut self, travelled: L::Mask) {
        let states = self.cores[0].motion.layout().states();
        let mut size = L::zero();
        for x in &self.xi[..states] {
            size += x.abs();
        }
        let fine = size.lt(L::splat(LaneCore::BOUND));
        if (travelled & !fine).any() {
            self.diverge(travelled & !fine);
        }
        if self.formation.any_joined {
            self.join(travelled);
        }
    }

    #[cold]
    fn diverge(&mut self, lost: L::Mask) {
        for l in (0..L::WIDTH).filter(|&l| lost.test(l)) {
            self.cores[l].end = Some(RunEnd::Diverged { t_s: self.t_s });
        }
        self.formation.form(&self.cores);
    }

    fn join(&mut self, mask: L::Mask) {
        for l in (0..L::WIDTH).filter(|&l| mask.test(l) && self.cores[l].joins_bodies()) {
            take_lane(&self.xi, l, &mut self.scratch);
            self.cores[l].join(&mut self.scratch);
            put_lane(&mut self.xi, l, &self.scratch);
        }
        self.signals.are_fresh = self.signals.are_fresh & L::Mask::from_fn(|l| !self.cores[l].joins_bodies());
    }
}
