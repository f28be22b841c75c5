//! A result of whatever job: read by its kind, rendered again.

use crate::outcome::{Filed, Outcome};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use crate::{
    apply, comparison, deconvolution, free_living, inspect, linearity, modes, motion,
    multi_position, noise, plan, response, shaker_single, shaker_triaxial, shock, simulate,
    spurious_motion, static_test, step, temperature, uncertainty, validation, velocity,
};
use proofmass_io::{ResultDocument, StatedQuantity};
use proofmass_report::Report;
use proofmass_uncertainty::Finding;

/// A filed outcome of any kind, for callers that treat all alike: a viewer, a server, an archive.
pub trait AnyResult {
    /// Kind of the result, as in result.json.
    fn kind(&self) -> &'static str;
    /// What it is filed with.
    fn record(&self) -> &Record;
    /// The principal result.
    fn quantities(&self) -> Vec<StatedQuantity>;
    /// What to doubt.
    fn findings(&self) -> &[Finding];
    /// Whether a finding needs a decision before the result is used.
    fn needs_decision(&self) -> bool;
    /// What is worth a look in a terminal.
    fn summary(&self) -> Report;
    /// Bytes of result.json.
    ///
    /// # Errors
    /// A number that is not finite.
    fn to_json(&self) -> Result<Vec<u8>>;
    /// Every file of the result, by name.
    ///
    /// # Errors
    /// A number that is not finite.
    fn files(&self) -> Result<Vec<(String, Vec<u8>)>>;
}

impl<O: Outcome> AnyResult for Filed<O> {
    fn kind(&self) -> &'static str {
        O::KIND
    }

    fn record(&self) -> &Record {
        &self.record
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.outcome.quantities()
    }

    fn findings(&self) -> &[Finding] {
        self.outcome.findings()
    }

    fn needs_decision(&self) -> bool {
        self.outcome.needs_decision()
    }

    fn summary(&self) -> Report {
        Filed::summary(self)
    }

    fn to_json(&self) -> Result<Vec<u8>> {
        Filed::to_json(self)
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        Filed::files(self)
    }
}

type Reader = fn(&[u8]) -> Result<Box<dyn AnyResult>>;

fn reader<O: Outcome + 'static>() -> (&'static str, Reader) {
    (O::KIND, |bytes| Ok(Box::new(Filed::<O>::from_json(bytes)?)))
}

/// Every kind that can be read again.
fn readers() -> Vec<(&'static str, Reader)> {
    vec![
        reader::<multi_position::MultiPositionOutcome>(),
        reader::<free_living::FreeLivingOutcome>(),
        reader::<validation::ValidationOutcome>(),
        reader::<apply::ApplyOutcome>(),
        reader::<inspect::InspectOutcome>(),
        reader::<temperature::TemperatureOutcome>(),
        reader::<simulate::SimulateOutcome>(),
        reader::<static_test::StaticTestOutcome>(),
        reader::<shaker_triaxial::ShakerTriaxialOutcome>(),
        reader::<shaker_single::ShakerSingleOutcome>(),
        reader::<spurious_motion::SpuriousMotionOutcome>(),
        reader::<shock::ShockOutcome>(),
        reader::<linearity::LinearityOutcome>(),
        reader::<step::StepOutcome>(),
        reader::<comparison::ComparisonOutcome>(),
        reader::<deconvolution::DeconvolutionOutcome>(),
        reader::<motion::MotionOutcome>(),
        reader::<response::ResponseOutcome>(),
        reader::<plan::PlanOutcome>(),
        reader::<modes::ModesOutcome>(),
        reader::<noise::NoiseOutcome>(),
        reader::<uncertainty::UncertaintyOutcome>(),
        reader::<velocity::VelocityEstimate>(),
        reader::<velocity::VelocityComparison>(),
        reader::<velocity::VelocityTuning>(),
    ]
}

/// Reads a result.json of whatever kind.
///
/// ```
/// use proofmass_jobs::{Filed, Job, Record, Unwatched, read_result, uncertainty::UncertaintyJob};
///
/// let text = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
///             [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2 * m\"\n";
/// let job = UncertaintyJob { model: proofmass_io::read_model(text).unwrap(), ..Default::default() };
/// let filed = Filed::new(Record::default(), job.evaluate(&(), &Unwatched)?);
/// let read = read_result(&filed.to_json()?)?;
/// assert_eq!(read.kind(), "uncertainty");
/// assert_eq!(read.files()?, filed.files()?);
/// # Ok::<(), proofmass_jobs::Trouble>(())
/// ```
///
/// # Errors
/// Another kind of file, a kind this version does not know, a damaged file.
pub fn read_result(bytes: &[u8]) -> Result<Box<dyn AnyResult>> {
    let kind = ResultDocument::from_json(bytes)?.kind;
    let readers = readers();
    match readers.iter().find(|(name, _)| *name == kind) {
        Some((_, read)) => read(bytes),
        None => {
            let known: Vec<&str> = readers.iter().map(|(name, _)| *name).collect();
            Err(Trouble::data(format!(
                "the result is of kind `{kind}`, which cannot be read again"
            ))
            .with_hint(format!("kinds that can: {}", known.join(", "))))
        }
    }
}
