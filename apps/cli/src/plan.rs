//! `proofmass plan`: what a campaign on the shaker will achieve, before anything is measured.

use crate::delivery::{Delivery, Results};
use crate::shaker::inputs;
use crate::{Failure, Outcome, clock};
use proofmass::calibration::shaker::geometry::published_plan;
use proofmass::calibration::shaker::plan::{
    Conditioning, PlanCost, Predicted, best, conditioning, costs, predict,
};
use proofmass::calibration::shaker::{Budget, Complex64, Configuration, with_certificate};
use proofmass::io::{Cell, Input, ResultDocument, Software, Table};
use proofmass::jobs::campaign::{Campaign, ShakerBudget, ShakerTriaxialCampaign};
use proofmass::report::PlanReport;
use proofmass::uncertainty::{Finding, Severity};
use std::path::PathBuf;

/// Predict the uncertainties of a campaign on the shaker, and find the best of fewer configurations.
///
/// Reads budget, certificate and plan of a campaign of kind `shaker-triaxial`; nothing needs to have been measured.
/// The candidates are the plan of the campaign, or else the configurations of its runs, or else the 44 published
/// ones.
#[derive(clap::Args)]
pub(crate) struct Plan {
    /// Campaign folder, or its campaign.toml
    campaign: PathBuf,
    /// Choose the best N of the candidates (largest determinant)
    #[arg(long, value_name = "N")]
    best: Option<usize>,
    /// Numbers of configurations to compare [default: 4 to all candidates]
    #[arg(long, value_name = "N,N,…", value_delimiter = ',')]
    sizes: Vec<usize>,
    /// Frequency whose uncertainty of the reference counts, Hz
    #[arg(long, value_name = "HZ", default_value_t = 160.0)]
    frequency: f64,
    #[command(flatten)]
    delivery: Delivery,
}

/// What the campaign says about its plan.
struct Stated {
    candidates: Vec<Configuration>,
    origin: &'static str,
    budget: Budget,
    inputs: Vec<Input>,
    /// Sensitivity that is expected, V/(m/s²), and acceleration, m/s².
    sensitivity: f64,
    amplitude: f64,
    findings: Vec<Finding>,
}

impl Plan {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(&[&self.campaign])?;
        let campaign = match Campaign::open(&self.campaign)? {
            Campaign::ShakerTriaxial(campaign) => campaign,
            other => {
                return Err(Failure::new(format!(
                    "a campaign of kind `{}` has no plan of configurations",
                    other.kind()
                ))
                .hint("plans are those of campaigns of kind `shaker-triaxial`"));
            }
        };
        let stated = Stated::read(&campaign, self.frequency)?;
        let count = stated.candidates.len();
        let hopeless = |e: proofmass::core::Error| {
            Failure::new(e.to_string())
                .detail(format!("{count} candidates, {}", stated.origin))
                .hint("three directions that span space are needed; add configurations to the plan, or check that [[budget]] has an additive noise (acts = \"output-additive\")")
        };
        let chosen = match self.best {
            Some(n) if !(3..=count).contains(&n) => {
                return Err(Failure::new(format!(
                    "--best {n}: there are {count} candidates, and three are needed"
                ))
                .hint(format!("give a number from 3 to {count}")));
            }
            Some(n) => Some(best(&stated.candidates, n).map_err(hopeless)?),
            None => None,
        };
        let plan: Vec<Configuration> = match &chosen {
            Some(list) => list.iter().map(|&k| stated.candidates[k]).collect(),
            None => stated.candidates.clone(),
        };
        let s = stated.matrix();
        let quality = conditioning(&plan).map_err(hopeless)?;
        let predicted = predict(&plan, &stated.budget, &s, stated.amplitude).map_err(hopeless)?;
        let sizes = self.sizes(count)?;
        let costs = costs(
            &stated.candidates,
            &sizes,
            &stated.budget,
            &s,
            stated.amplitude,
        )
        .map_err(hopeless)?;
        let title = campaign
            .title
            .clone()
            .unwrap_or_else(|| "Plan of a campaign on the shaker".to_owned());
        let text = PlanReport {
            title: title.clone(),
            meta: vec![
                (
                    "Candidates".to_owned(),
                    format!("{count}, {}", stated.origin),
                ),
                (
                    "Expected".to_owned(),
                    format!(
                        "{} mV/(m/s²) at {} m/s², reference as at {} Hz",
                        1e3 * stated.sensitivity,
                        stated.amplitude,
                        self.frequency
                    ),
                ),
                ("Evaluated on".to_owned(), clock::today()),
            ],
            inputs: stated
                .inputs
                .iter()
                .map(|i| (i.path.clone(), i.sha256.clone()))
                .collect(),
            findings: &stated.findings,
            candidates: &stated.candidates,
            chosen: chosen.as_deref(),
            costs: &costs,
            footer: Software::default().to_string(),
        };
        let json = result(&title, &stated, &plan, &quality, &predicted, &costs)?;
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.summary(&quality, &predicted),
                report: &|| text.full(&quality, &predicted),
                files: vec![
                    ("plan.csv", configurations(&plan)?.to_csv()?),
                    ("predicted.csv", prediction(&predicted)?.to_csv()?),
                    ("costs.csv", cost_table(&costs)?.to_csv()?),
                ],
                findings: &stated.findings,
            },
        )
    }

    fn sizes(&self, count: usize) -> Result<Vec<usize>, Failure> {
        if self.sizes.is_empty() {
            let mut sizes: Vec<usize> = [4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 60, 100]
                .into_iter()
                .filter(|&n| n < count)
                .collect();
            sizes.push(count);
            return Ok(sizes);
        }
        let mut sizes = self.sizes.clone();
        sizes.sort_unstable();
        sizes.dedup();
        match sizes.iter().find(|n| !(3..=count).contains(*n)) {
            Some(n) => Err(Failure::new(format!(
                "--sizes {n}: there are {count} candidates, and three are needed"
            ))
            .hint(format!("give numbers from 3 to {count}"))),
            None => Ok(sizes),
        }
    }
}

impl Stated {
    fn read(campaign: &ShakerTriaxialCampaign, frequency: f64) -> Result<Self, Failure> {
        let mut inputs = vec![campaign.source.input.clone()];
        let (candidates, origin) = match campaign.read_plan()? {
            Some((plan, input)) => {
                inputs.extend(input);
                (inputs::plan(&plan), "the plan of the campaign")
            }
            None if campaign.runs.is_some() => {
                let table = campaign.read_runs()?;
                let mut list: Vec<Configuration> = Vec::new();
                for run in &table.runs {
                    let c = Configuration {
                        inclination: run.seat.inclination,
                        rotation: run.seat.rotation,
                    };
                    if !list.iter().any(|o| o.same_as(&c)) {
                        list.push(c);
                    }
                }
                inputs.push(table.input);
                (list, "those of the runs")
            }
            None => (published_plan(), "the published ones"),
        };
        let certificate = campaign.read_reference()?;
        let budget = campaign.read_budget()?;
        if let ShakerBudget::Inputs(_, Some(input)) = &budget {
            inputs.push(input.clone());
        }
        inputs.extend(certificate.iter().map(|c| c.input.clone()));
        let reference = certificate.as_ref().map(inputs::reference).transpose()?;
        let budget = inputs::budget(&budget, certificate.is_some())?;
        let budget = with_certificate(&budget, reference.as_ref(), [frequency]).map_err(|e| {
            Failure::new(e.to_string())
                .detail(format!("--frequency {frequency}"))
                .hint("give a frequency that the certificate of the reference reaches")
        })?;
        let mut findings = Vec::new();
        if campaign.datasheet.is_none() {
            findings.push(
                Finding::new(
                    Severity::Note,
                    "sensitivity-assumed",
                    "the expected sensitivity is not stated, so 10 mV/(m/s²) was reckoned with",
                )
                .evidence("the campaign has no [datasheet]")
                .advice("it matters where additive noise does; add [datasheet] with sensitivity, tolerance and unit"),
            );
        }
        let points: Vec<(f64, f64)> = candidates
            .iter()
            .map(|c| (c.inclination, frequency))
            .collect();
        findings.extend(campaign.fixture_findings(&points)?);
        Ok(Self {
            candidates,
            origin,
            budget,
            inputs,
            sensitivity: campaign.datasheet.map_or(0.01, |d| d.0),
            amplitude: campaign
                .plan
                .as_ref()
                .and_then(|p| p.amplitude)
                .unwrap_or(10.0),
            findings,
        })
    }

    /// Equal main terms and cross terms of 1 %: what a sound device has.
    fn matrix(&self) -> [[Complex64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                Complex64::new(self.sensitivity * if i == j { 1.0 } else { 0.01 }, 0.0)
            })
        })
    }
}

fn result(
    title: &str,
    stated: &Stated,
    plan: &[Configuration],
    quality: &Conditioning,
    predicted: &[Predicted],
    costs: &[PlanCost],
) -> Result<Vec<u8>, Failure> {
    let mut document = ResultDocument::new("plan")
        .title(title)
        .findings(&stated.findings);
    for input in &stated.inputs {
        document = document.input(input.clone());
    }
    Ok(document
        .section("date", &clock::today())?
        .section("budget", &stated.budget)?
        .section("candidates", &stated.candidates)?
        .section("configurations", &plan)?
        .section("conditioning", quality)?
        .section("predicted", &predicted)?
        .section("costs", &costs)?
        .to_json()?)
}

/// The plan as a campaign reads it.
fn configurations(plan: &[Configuration]) -> Result<Table, Failure> {
    let mut table = Table::new(["configuration", "inclination_deg", "rotation_deg"]);
    for (i, c) in plan.iter().enumerate() {
        // Radians of whole degrees come back with rounding in the last digit.
        let degrees = |angle: f64| Cell::from((angle.to_degrees() * 1e9).round() / 1e9);
        table.push([
            Cell::from(i + 1),
            degrees(c.inclination),
            degrees(c.rotation),
        ])?;
    }
    Ok(table)
}

fn prediction(predicted: &[Predicted]) -> Result<Table, Failure> {
    let mut table = Table::new(["term", "u_real_%", "u_imaginary_%"]);
    for p in predicted {
        table.push([
            Cell::from(p.term.as_str()),
            Cell::from(100.0 * p.relative_real),
            Cell::from(100.0 * p.relative_imaginary),
        ])?;
    }
    Ok(table)
}

fn cost_table(costs: &[PlanCost]) -> Result<Table, Failure> {
    let mut table = Table::new([
        "configurations",
        "u_main_%",
        "u_cross_%",
        "condition",
        "D_efficiency",
        "A_efficiency",
        "candidates",
    ]);
    for c in costs {
        let chosen: Vec<String> = c.chosen.iter().map(|k| (k + 1).to_string()).collect();
        table.push([
            Cell::from(c.conditioning.count),
            Cell::from(100.0 * c.main),
            Cell::from(100.0 * c.cross),
            Cell::from(c.conditioning.condition),
            Cell::from(c.conditioning.d_efficiency),
            Cell::from(c.conditioning.a_efficiency),
            Cell::Text(chosen.join(" ")),
        ])?;
    }
    Ok(table)
}
