//! Measurement uncertainty after the GUM and its supplements, with correlation kept.

mod covariance;
mod coverage;
mod estimate;
mod finding;

pub use covariance::Covariance;
pub use coverage::{DegreesOfFreedom, welch_satterthwaite};
pub use estimate::{
    BudgetInput, BudgetLine, Component, Effect, Estimate, Evaluation, Influence, Quantity,
};
pub use finding::{Finding, Severity};
