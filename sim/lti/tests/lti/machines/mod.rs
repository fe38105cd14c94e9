//! Linear theory of robot axes in contact, against printed figures and closed forms.

mod axis;
mod closed_forms;
mod critical_gains;
mod margins;
mod paper_models;
