//! A campaign on the shaker from its files to its results.

mod documents;
mod explanation;

use self::explanation::explain;
use super::{Calibrate, heading};
use crate::delivery::Results;
use crate::shaker::inputs;
use crate::shaker::runs::{Observed, observe};
use crate::{Failure, Outcome};
use proofmass::calibration::shaker::monte_carlo::{self, Options};
use proofmass::calibration::shaker::published::MagnitudeBudget;
use proofmass::calibration::shaker::recording::{Quality, RunInput};
use proofmass::calibration::shaker::{
    Configuration, FrequencyCheck, Method, ShakerCalibration, ShakerCampaign, calibrate, check,
};
use proofmass::io::{Input, Software};
use proofmass::jobs::campaign::{
    Certificate, Mounting, RunTable, ShakerBudget, ShakerMethod, ShakerTriaxialCampaign,
};
use proofmass::report::ShakerReport;
use proofmass::uncertainty::{Finding, Refusal};
use std::ops::ControlFlow;

/// Everything the files of a campaign say.
struct Data {
    table: RunTable<Mounting>,
    observed: Observed,
    stated: ShakerCampaign,
    certificate: Option<Certificate>,
    /// Files beside the runs.
    inputs: Vec<Input>,
}

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &ShakerTriaxialCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(&campaign.source)?;
    let data = Data::read(campaign)?;
    let calibration = calibrate(&data.stated).map_err(|e| explain(e, &data))?;
    let checks: Vec<FrequencyCheck> = match campaign.method.trials {
        0 => Vec::new(),
        trials => {
            let mut options = Options::default();
            options.trials = trials;
            options.seed = campaign.method.seed;
            check(&data.stated, &options, &mut |_| ControlFlow::Continue(())).map_err(
                |refusal| match refusal {
                    Refusal::Core(e) => explain(e, &data),
                    other => Failure::new(other.to_string()),
                },
            )?
        }
    };
    let mut findings = findings(&data, &calibration);
    findings.extend(monte_carlo::findings(&checks, Options::default().digits));
    let runs = data.stated.runs.iter();
    let points: Vec<(f64, f64)> = runs
        .map(|r| (r.configuration.inclination, r.frequency))
        .collect();
    findings.extend(campaign.fixture_findings(&points)?);
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    let title = title(campaign);
    let text = ShakerReport {
        title: title.clone(),
        meta: meta(campaign, &data),
        inputs: data.listed_inputs(),
        findings: &findings,
        datasheet: campaign.datasheet,
        checks: &checks,
        footer: Software::default().to_string(),
    };
    let json = documents::result(&title, campaign, &data, &calibration, &checks, &findings)?;
    let mut files = documents::tables(&calibration)?;
    files.push(("phasors.csv", documents::phasors(&data)?.to_csv()?));
    if !checks.is_empty() {
        files.push((
            "monte-carlo.csv",
            documents::monte_carlo(&checks)?.to_csv()?,
        ));
    }
    if data.observed.runs.iter().any(|r| r.recorded.is_some()) {
        files.push(("recordings.csv", documents::recordings(&data)?.to_csv()?));
    }
    arguments.delivery.hand_over(
        Some(folder),
        &Results {
            json: json.to_json()?,
            summary: &|| text.summary(&calibration),
            report: &|| text.full(&calibration),
            files,
            findings: &findings,
        },
    )
}

impl Data {
    fn read(campaign: &ShakerTriaxialCampaign) -> Result<Self, Failure> {
        let table = campaign.read_runs()?;
        // Small tables before the large recordings: their mistakes are told at once.
        let certificate = campaign.read_reference()?;
        let corrections = campaign.read_corrections()?;
        let budget = campaign.read_budget()?;
        let plan = campaign.read_plan()?;
        let mut inputs = vec![campaign.source.input.clone()];
        inputs.extend(certificate.iter().map(|c| c.input.clone()));
        inputs.extend(corrections.iter().filter_map(|c| c.input.clone()));
        if let ShakerBudget::Inputs(_, Some(input)) = &budget {
            inputs.push(input.clone());
        }
        inputs.extend(plan.iter().filter_map(|(_, input)| input.clone()));
        let observed = observe(&table, campaign.recording.as_ref(), || {
            campaign.waveform_options()
        })?;
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| RunInput {
                run: run.run.clone(),
                frequency: run.frequency_hz,
                configuration: Configuration {
                    inclination: run.seat.inclination,
                    rotation: run.seat.rotation,
                },
                reference: seen.phasors[0],
                outputs: [seen.phasors[1], seen.phasors[2], seen.phasors[3]],
                covariance: std::array::from_fn(|k| seen.covariances[k]),
                quality: match &seen.recorded {
                    Some(recorded) => recorded.phasors.quality(run.seat.transverse),
                    None => Quality {
                        transverse: run.seat.transverse,
                        ..Quality::default()
                    },
                },
            })
            .collect();
        let mut stated = ShakerCampaign::new(runs, inputs::budget(&budget, certificate.is_some())?);
        stated.reference = certificate.as_ref().map(inputs::reference).transpose()?;
        stated.corrections = corrections.iter().map(inputs::correction).collect();
        stated.methods = campaign
            .method
            .methods
            .iter()
            .copied()
            .map(method)
            .collect();
        let published = &campaign.published;
        stated.magnitude_budget = MagnitudeBudget {
            reference: published.reference,
            inclination: published.inclination_deg.to_radians() / 3f64.sqrt(),
            rotation: published.rotation_deg.to_radians() / 3f64.sqrt(),
            ..MagnitudeBudget::published(published.output)
        };
        stated.plan = plan.as_ref().map(|(plan, _)| inputs::plan(plan));
        for run in &table.runs {
            if let Some(target) = run.seat.target
                && !stated.targets.iter().any(|t| t.0 == run.frequency_hz)
            {
                stated.targets.push((run.frequency_hz, target));
            }
        }
        stated.datasheet = campaign.datasheet;
        stated.excluded = campaign
            .runs
            .as_ref()
            .map(|r| r.exclude.clone())
            .unwrap_or_default();
        Ok(Self {
            table,
            observed,
            stated,
            certificate,
            inputs,
        })
    }

    /// Files for the report: hundreds of recordings stand in result.json, one by one.
    fn listed_inputs(&self) -> Vec<(String, String)> {
        let recordings = self.observed.inputs.len() - 1;
        let mut list: Vec<(String, String)> = self
            .inputs
            .iter()
            .chain(self.observed.inputs.first())
            .map(|i| (i.path.clone(), i.sha256.clone()))
            .collect();
        if recordings > 0 {
            list.push((
                format!("{recordings} recordings"),
                "each in result.json".to_owned(),
            ));
        }
        list
    }
}

fn method(method: ShakerMethod) -> Method {
    match method {
        ShakerMethod::Published => Method::PublishedMagnitude,
        ShakerMethod::Complex => Method::Complex,
        ShakerMethod::Joint => Method::Joint,
    }
}

/// Doubts about files, runs and the first result, the gravest first.
fn findings(data: &Data, calibration: &ShakerCalibration) -> Vec<Finding> {
    let mut findings: Vec<Finding> = data
        .certificate
        .iter()
        .flat_map(|c| c.findings.clone())
        .collect();
    findings.extend(data.observed.findings.iter().cloned());
    findings.extend(calibration.findings.iter().cloned());
    findings.extend(
        calibration
            .results
            .first()
            .into_iter()
            .flat_map(|r| r.findings.clone()),
    );
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings
}

fn title(campaign: &ShakerTriaxialCampaign) -> String {
    heading::title(
        campaign.title.as_ref(),
        &campaign.device,
        "Calibration of a triaxial accelerometer on a shaker",
    )
}

fn meta(campaign: &ShakerTriaxialCampaign, data: &Data) -> Vec<(String, String)> {
    let mut meta = heading::meta(&campaign.device, &campaign.ambient);
    if let Some(text) = data
        .certificate
        .as_ref()
        .and_then(|c| c.description.clone())
    {
        meta.push(("Reference".to_owned(), text));
    }
    meta.push(("Runs".to_owned(), data.table.runs.len().to_string()));
    meta
}
