//! Measurement uncertainty after the GUM and its supplements, with correlation kept.

mod agreement;
mod covariance;
mod coverage;
mod effective_dof;
mod estimate;
mod finding;
mod format;
mod student;

pub use agreement::En;
pub use covariance::Covariance;
pub use coverage::DegreesOfFreedom;
pub use effective_dof::{CorrelatedGroup, GroupDof, welch_satterthwaite, willink, willink_hall};
pub use estimate::{
    BudgetInput, BudgetLine, Component, Effect, Estimate, Evaluation, Influence, Quantity,
};
pub use finding::{Finding, Severity};
pub use format::{Alphabet, DecimalMark, Format, Formatted, Notation, Rounded, ShowDof};
