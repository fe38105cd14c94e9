//! Linear response of the controlled signal to a step of the reference, with the loop closed.

use feeler_lti::DiscreteStateSpace;
use feeler_plant::assembly::Source;
use nalgebra::DVector;

use crate::error::AnalysisError;
use crate::loops::closed_loop::{integrates, law_of_reference};
use crate::loops::control_loop::ControlLoop;
use crate::loops::late::LateResponse;

/// Largest number of samples of a response.
const MOST_SAMPLES: usize = 20_000;
/// A response ends when it has grown beyond this.
const FAR: f64 = 1e3;

/// The controlled signal after a unit step of the reference, at the samples of its controller.
#[derive(Clone, Debug, PartialEq)]
pub struct StepResponse {
    /// The controller's period, s.
    pub period_s: f64,
    /// Values from the step onwards, just before the controller acts.
    pub values: Vec<f64>,
}

impl StepResponse {
    /// The sampled loop of controller `controller` over `duration_s`; `None` if it reads nothing.
    ///
    /// # Errors
    /// Those of [`ControlLoop::open_loop`].
    pub fn new(
        whole: &ControlLoop,
        controller: usize,
        duration_s: f64,
    ) -> Result<Option<Self>, AnalysisError> {
        let own = &whole.controllers()[controller];
        let Some(sensor) = own.controlled() else { return Ok(None) };
        let reading = whole.plant().output(Source::Sensor(sensor))?;
        let mut plant = Line::new(whole.response_to(controller, reading)?);
        let mut around = Line::new(whole.open_loop(controller)?);
        let mut law = Line::prompt(law_of_reference(own)?);
        let period_s = own.spec.period_s;
        let samples = ((duration_s / period_s).ceil() as usize + 1).min(MOST_SAMPLES);
        let (mut values, mut sum) = (Vec::with_capacity(samples), 0.0);
        for _ in 0..samples {
            // Neither plant nor loop responds to a command before its next sample.
            let (value, fed_back) = (plant.output(), around.output());
            let command = law.step(1.0) - fed_back;
            plant.feed(command);
            around.feed(command);
            sum += value * period_s;
            let controlled = if integrates(own) { sum } else { value };
            values.push(controlled);
            if controlled.is_nan() || controlled.abs() >= FAR {
                break;
            }
        }
        Ok(Some(Self { period_s, values }))
    }
}

/// A system with one input and one output, stepped in time.
struct Line {
    system: DiscreteStateSpace,
    state: DVector<f64>,
    /// Outputs in the delay line.
    waiting: std::collections::VecDeque<f64>,
}

impl Line {
    fn new(response: LateResponse) -> Self {
        let waiting = std::iter::repeat_n(0.0, response.samples).collect();
        Self { waiting, ..Self::prompt(response.system) }
    }

    fn prompt(system: DiscreteStateSpace) -> Self {
        Self { state: DVector::zeros(system.states()), system, waiting: std::collections::VecDeque::new() }
    }

    fn own_output(&self) -> f64 {
        self.system.c().row(0).transpose().dot(&self.state)
    }

    /// The output before this sample's input acts.
    fn output(&self) -> f64 {
        self.waiting.front().copied().unwrap_or_else(|| self.own_output())
    }

    fn feed(&mut self, input: f64) {
        if !self.waiting.is_empty() {
            self.waiting.push_back(self.own_output());
            self.waiting.pop_front();
        }
        let mut next = self.system.b().column(0) * input;
        next.gemv(1.0, self.system.a(), &self.state, 1.0);
        self.state = next;
    }

    /// The output after this sample's input has acted.
    fn step(&mut self, input: f64) -> f64 {
        let output = self.own_output() + self.system.d()[(0, 0)] * input;
        self.feed(input);
        output
    }
}
