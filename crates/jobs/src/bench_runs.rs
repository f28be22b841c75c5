//! Runs of a bench, whatever is made of them: as phasors for a job, and as the files of a campaign say them.

use crate::observed::Observed;
use proofmass_io::Input;
use proofmass_uncertainty::Finding;
use std::path::Path;

/// The runs as phasors.
#[derive(Debug)]
pub struct BenchRuns<'a, R> {
    /// Runs in the order of the campaign.
    pub(crate) runs: &'a [R],
    /// What reading them found.
    pub(crate) findings: &'a [Finding],
    /// What the table of runs is called in messages.
    pub(crate) name: &'a str,
    /// How many of the last inputs of the record are recordings.
    pub(crate) recordings: usize,
}

impl<R> Clone for BenchRuns<'_, R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Copy for BenchRuns<'_, R> {}

impl<'a, R> BenchRuns<'a, R> {
    /// Ready phasors.
    pub fn new(runs: &'a [R]) -> Self {
        Self {
            runs,
            findings: &[],
            name: "the runs",
            recordings: 0,
        }
    }

    /// Runs in the order of the campaign.
    pub fn runs(&self) -> &'a [R] {
        self.runs
    }
}

/// Everything the files of a campaign say: the question and its runs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BenchFiles<J, R> {
    /// The question.
    pub job: J,
    pub(crate) runs: Vec<R>,
    pub(crate) findings: Vec<Finding>,
    pub(crate) name: String,
    pub(crate) inputs: Vec<Input>,
    pub(crate) recordings: usize,
}

impl<J, R> BenchFiles<J, R> {
    /// A question and its runs, with what the tables and the recordings said: the recordings come last.
    pub(crate) fn new(
        (job, runs): (J, Vec<R>),
        name: &Path,
        (mut findings, mut inputs): (Vec<Finding>, Vec<Input>),
        observed: Observed,
    ) -> Self {
        let recordings = observed.inputs.len() - 1;
        findings.extend(observed.findings);
        inputs.extend(observed.inputs);
        Self {
            job,
            runs,
            findings,
            name: name.display().to_string(),
            inputs,
            recordings,
        }
    }

    /// The runs, for the job.
    pub fn data(&self) -> BenchRuns<'_, R> {
        BenchRuns {
            runs: &self.runs,
            findings: &self.findings,
            name: &self.name,
            recordings: self.recordings,
        }
    }
}
