//! The exponentials of all lanes side by side, and the check of their guards.

use feeler_lanes::{Blocks, Lane, LaneMask};

use crate::carry::abreast::Abreast;
use crate::carry::lane::LaneCore;
use crate::carry::peaks::Span;
use crate::error::EngineError;
use crate::solve::flow::{Flow, ROWS_PER_BEND, ROWS_PER_LINE};

/// Spans closer than this are equal on the grid of femtoseconds.
const SAME_SPAN_S: f64 = 0.49e-15;
/// Value for the time of a note if there is none.
const NO_NOTE_S: f64 = -1.0;

/// Modes whose rows a lone lane keeps. A guide that sticks and slips in contact returns to a few of them with
/// every switch.
const MODES_KEPT: usize = 16;

/// Carries every lane over the same span, each in its own mode.
#[derive(Debug)]
pub(crate) struct Transition<L: Lane> {
    pub(super) span_fs: u64,
    span_s: f64,
    /// Time from the start to the note; `None` if no late reading takes a signal on the way.
    pub(super) note_fs: Option<u64>,
    /// Time from the start to the note, s; negative without a note.
    note_s: f64,
    /// The signals to note.
    noted: Vec<usize>,
    /// Formation of the lanes (see [`crate::carry::formation`]) for which the rows were last checked.
    filled_at: u64,
    width: usize,
    states: usize,
    pub(crate) rows: Rows<L>,
    /// Rows of earlier modes of a lone lane, the last ones used last. Several lanes have none.
    kept: Vec<Rows<L>>,
}

/// The rows of all lanes in their modes, and what follows from these modes.
#[derive(Debug)]
pub(crate) struct Rows<L: Lane> {
    /// Flow of each lane for which the rows were filled in.
    filled_for: Vec<usize>,
    /// Number of equal parts into which each lane divides the span so that no event is missed between
    /// evaluations.
    pub(super) parts: Vec<u64>,
    pub(super) most_parts: u64,
    /// Part of the span of each lane that contains the note.
    pub(super) note_parts: Vec<u64>,
    /// Length of these parts, s.
    part_s: L,
    matrix: Blocks<L>,
    /// Largest number of lines that the matrix can hold.
    lines: usize,
    /// First rows of the signals, and of the noted signals.
    signals_from: usize,
    noted_from: usize,
    /// Lanes in which the first lines, those of contacts with peaks, are guards, and lanes in which they are
    /// forces.
    guarding: Vec<L::Mask>,
    pushing: Vec<L::Mask>,
    /// Lanes that travel farther in one part than [`Flow::evaluations`] allows, because they have no guards.
    rough: L::Mask,
}

impl<L: Lane> Rows<L> {
    fn new(width: usize) -> Self {
        Self {
            filled_for: vec![usize::MAX; L::WIDTH],
            parts: vec![1; L::WIDTH],
            most_parts: 1,
            note_parts: vec![0; L::WIDTH],
            part_s: L::zero(),
            matrix: Blocks::zeros(0, width),
            lines: 0,
            signals_from: 0,
            noted_from: 0,
            guarding: Vec::new(),
            pushing: Vec::new(),
            rough: L::Mask::splat(false),
        }
    }
}

impl<L: Lane> Transition<L> {
    /// A transition over a span. With a note, `signals` are those to note.
    pub(crate) fn new(span_fs: u64, note_fs: Option<u64>, signals: &[usize], lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let (states, width) = (layout.states(), layout.linear_width());
        Self {
            span_fs,
            span_s: span_fs as f64 * 1e-15,
            note_fs,
            note_s: note_fs.map_or(NO_NOTE_S, |note_fs| note_fs as f64 * 1e-15),
            noted: if note_fs.is_some() { signals.to_vec() } else { Vec::new() },
            filled_at: 0,
            width,
            states,
            rows: Rows::new(width),
            kept: Vec::new(),
        }
    }

    /// Whether a span and its note equal these on the grid of femtoseconds.
    #[inline(always)]
    pub(crate) fn is_over(&self, span_s: f64, note_s: Option<f64>) -> bool {
        (span_s - self.span_s).abs() < SAME_SPAN_S
            && (note_s.unwrap_or(NO_NOTE_S) - self.note_s).abs() < SAME_SPAN_S
    }

    /// Rows of the product, padded.
    pub(crate) fn padded_rows(&self) -> usize {
        self.rows.matrix.padded_rows()
    }

    /// Fills in the rows of lanes whose mode has changed since the last call.
    #[inline(always)]
    pub(crate) fn refresh(&mut self, formation: u64, lanes: &mut [LaneCore]) -> Result<(), EngineError> {
        if self.filled_at == formation {
            return Ok(());
        }
        self.filled_at = formation;
        self.fill(lanes)
    }

    /// A lone lane changes its rows for those of its mode. Returns whether they are known.
    fn recall(&mut self, lane: &LaneCore) -> bool {
        if lane.has_ended() || self.rows.filled_for[0] == lane.current {
            return false;
        }
        let known = self.kept.iter().position(|rows| rows.filled_for[0] == lane.current);
        let next = known.map_or_else(|| Rows::new(self.width), |i| self.kept.remove(i));
        if self.kept.len() == MODES_KEPT {
            self.kept.remove(0);
        }
        self.kept.push(std::mem::replace(&mut self.rows, next));
        known.is_some()
    }

    #[cold]
    fn fill(&mut self, lanes: &mut [LaneCore]) -> Result<(), EngineError> {
        if L::WIDTH == 1 && self.recall(&lanes[0]) {
            return Ok(());
        }
        let most = lanes.iter().map(|lane| lane.flow().lines.len()).max().unwrap_or(0);
        if most > self.rows.lines || self.rows.signals_from == 0 {
            self.rows.lines = most;
            let flow = lanes[0].flow();
            self.rows.signals_from = self.states + ROWS_PER_LINE * most + ROWS_PER_BEND * flow.pushing.len();
            self.rows.noted_from = self.rows.signals_from + flow.signals.len();
            self.rows.matrix = Blocks::zeros(self.rows.noted_from + self.noted.len(), self.width);
            self.rows.filled_for.fill(usize::MAX);
        }
        let mut rough: Vec<bool> = (0..L::WIDTH).map(|l| self.rows.rough.test(l)).collect();
        for (l, lane) in lanes.iter_mut().enumerate() {
            if self.rows.filled_for[l] == lane.current || lane.has_ended() {
                continue;
            }
            self.rows.filled_for[l] = lane.current;
            let flow = lane.flow_mut();
            if !flow.linear {
                continue;
            }
            let span_s = self.span_s;
            // Without guards only peaks need evaluations, and these have their own check.
            let is_guarded = flow.lines.iter().any(|line| line.is_guard);
            let evaluations = flow.evaluations(span_s)?;
            self.rows.parts[l] = if is_guarded { evaluations } else { 1 };
            rough[l] = !is_guarded && evaluations > 1;
            self.rows.part_s.set_lane(l, span_s / self.rows.parts[l] as f64);
            let own = self.states + ROWS_PER_LINE * flow.lines.len();
            let room = self.states + ROWS_PER_LINE * self.rows.lines;
            for (i, row) in
                flow.transition(self.span_fs / self.rows.parts[l])?.chunks_exact(self.width).enumerate()
            {
                self.rows.matrix.set_row(l, if i < own { i } else { room + i - own }, row);
            }
            if let Some(note_fs) = self.note_fs {
                let part_fs = self.span_fs / self.rows.parts[l];
                let part = (note_fs / part_fs).min(self.rows.parts[l] - 1);
                self.rows.note_parts[l] = part;
                let rows = flow.noted(note_fs - part * part_fs, &self.noted)?;
                for (i, row) in rows.chunks_exact(self.width).enumerate() {
                    self.rows.matrix.set_row(l, self.rows.noted_from + i, row);
                }
            }
            // Lines that this lane does not have read 1 at both ends.
            let mut one = vec![0.0; self.width];
            one[self.width - 1] = 1.0;
            for i in own..room {
                let is_value = matches!((i - self.states) % ROWS_PER_LINE, 0 | 3);
                self.rows.matrix.set_row(l, i, if is_value { &one } else { &[] });
            }
        }
        self.rows.rough = L::Mask::from_fn(|l| rough[l]);
        let of_contacts = |is: &dyn Fn(&Flow, usize) -> bool| {
            let contacts = lanes[0].flow().pushing.len();
            (0..contacts).map(|c| L::Mask::from_fn(|l| is(lanes[l].flow(), c))).collect()
        };
        self.rows.guarding = of_contacts(&|flow, c| flow.lines[c].is_guard);
        self.rows.pushing = of_contacts(&|flow, c| flow.pushing[c]);
        self.rows.most_parts = self.rows.parts.iter().copied().max().unwrap_or(1);
        Ok(())
    }

    /// Lanes in which a guard may have been crossed on the way. Either it is not positive at the end, or it
    /// was negative at the start, or its slopes allow a dip below zero in between.
    #[inline(always)]
    fn suspects(&self, y: &[L]) -> L::Mask {
        let zero = L::zero();
        let mut suspect = L::Mask::splat(false);
        for (i, line) in y[self.states..].chunks_exact(ROWS_PER_LINE).take(self.rows.lines).enumerate() {
            let [end, slope_start, slope_end, start] = [line[0], line[1], line[2], line[3]];
            // The tangents at both ends meet below zero (see `polynomial::Polynomial::dip`).
            let below =
                (slope_end * start - slope_start * end + slope_start * slope_end * self.rows.part_s).lt(zero);
            let dips = slope_start.lt(zero) & slope_end.gt(zero) & below;
            let crossed = end.le(zero) | start.lt(zero) | dips;
            suspect = suspect | self.rows.guarding.get(i).map_or(crossed, |guarding| crossed & *guarding);
        }
        suspect
    }

    /// Computes the state of the lanes of `here` after one part, and returns those that may have met an event
    /// on the way.
    #[inline(always)]
    pub(crate) fn crossed(&self, here: L::Mask, xi: &[L], y: &mut [L]) -> L::Mask {
        self.rows.matrix.apply(xi, y);
        here & self.suspects(y)
    }

    /// Records the largest forces of the lanes of `moved` in part `part` of a span from `t_s`. Returns those
    /// whose force may be larger in between.
    #[inline(always)]
    pub(crate) fn pass(
        &self,
        moved: L::Mask,
        y: &[L],
        part: u64,
        t_s: f64,
        peaks: &mut [Abreast<L>],
    ) -> L::Mask {
        let from_s = L::splat(t_s) + self.rows.part_s * L::splat(part as f64);
        let mut with_maxima = L::Mask::splat(false);
        for ((line, pushing), peak) in
            y[self.states..].chunks_exact(ROWS_PER_LINE).zip(&self.rows.pushing).zip(peaks)
        {
            let [end, slope_start, slope_end, start] = [line[0], line[1], line[2], line[3]];
            let here = moved & *pushing;
            with_maxima = with_maxima
                | peak.pass(here, [start, end], [slope_start, slope_end], from_s, self.rows.part_s);
            if self.rows.rough.any() {
                with_maxima = with_maxima
                    | (here
                        & self.rows.rough
                        & peak.is_near([start, end], [slope_start, slope_end], self.rows.part_s));
            }
        }
        with_maxima
    }

    /// One part of the span of a lane, as seen by contact `i`; `None` if it does not push.
    pub(crate) fn span(&self, l: usize, i: usize, y: &[L]) -> Option<Span> {
        let line = &y[self.states + ROWS_PER_LINE * i..];
        let bends = &y[self.states + ROWS_PER_LINE * self.rows.lines + ROWS_PER_BEND * i..];
        let of = |values: [L; 2]| values.map(|value| value.lane(l));
        self.rows.pushing[i].test(l).then(|| Span {
            ends: of([line[3], line[0]]),
            slopes: of([line[1], line[2]]),
            bends: of([bends[0], bends[1]]),
            length_s: self.rows.part_s.lane(l),
            is_rough: self.rows.rough.test(l),
        })
    }

    /// Notes the signals of the lanes of `moved` whose note lies in part `part`.
    #[inline(always)]
    pub(crate) fn note(&self, moved: L::Mask, part: u64, y: &[L], noted: &mut [L]) {
        let here = if self.rows.most_parts == 1 {
            moved
        } else {
            moved & L::Mask::from_fn(|l| self.rows.note_parts[l] == part)
        };
        for (&signal, &y) in self.noted.iter().zip(&y[self.rows.noted_from..]) {
            noted[signal] = L::select(here, y, noted[signal]);
        }
    }

    /// Moves the lanes of `moved` to their computed states, and returns their signals there.
    #[inline(always)]
    pub(crate) fn go(&self, moved: L::Mask, xi: &mut [L], signals: &mut [L], y: &[L]) {
        let signals = signals.iter_mut().zip(&y[self.rows.signals_from..]);
        if moved.all() {
            xi[..self.states].copy_from_slice(&y[..self.states]);
            signals.for_each(|(signal, &y)| *signal = y);
            return;
        }
        signals.for_each(|(signal, &y)| *signal = L::select(moved, y, *signal));
        for (x, &y) in xi.iter_mut().zip(y.iter()).take(self.states) {
            *x = L::select(moved, y, *x);
        }
    }
}
