//! Measurement uncertainty after the GUM and its supplements, with correlation kept.

mod agreement;
mod budget_file;
mod covariance;
mod coverage;
mod distribution;
mod effective_dof;
mod estimate;
mod evaluation;
mod expression;
mod finding;
mod format;
mod implicit;
mod input;
mod monte_carlo;
mod number;
mod propagation;
mod refusal;
mod sampler;
mod student;

pub use agreement::En;
pub use budget_file::{
    Budget, CorrelationEntry, Equations, InputEntry, IntermediateEntry, OutputEntry,
    UncertaintyModel,
};
pub use covariance::Covariance;
pub use coverage::DegreesOfFreedom;
pub use distribution::Distribution;
pub use effective_dof::{CorrelatedGroup, GroupDof, welch_satterthwaite, willink, willink_hall};
pub use estimate::{
    BudgetInput, BudgetLine, Component, Effect, Estimate, Evaluation, Influence, Quantity,
};
pub use evaluation::{Evaluate, ModelResult, OutputResult};
pub use expression::Expression;
pub use finding::{Finding, Severity};
pub use format::{Alphabet, DecimalMark, Format, Formatted, Notation, Rounded, ShowDof};
pub use implicit::{Implicit, LeastSquares, propagate_implicit, propagate_least_squares};
pub use input::{Draw, Input, Inputs, JointInputs, Labels};
pub use monte_carlo::{
    Histogram, Interval, MonteCarlo, Progress, Region, Sampled, SampledOutput, Trials, Validation,
    Verdict, numerical_tolerance,
};
pub use number::{Complex, Dual, Number};
pub use propagation::{
    Linear, Model, SecondOrder, jacobian, linear, propagate, propagate_fixed,
    propagate_second_order,
};
pub use refusal::Refusal;
