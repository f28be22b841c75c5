//! `proofmass plan`: what a campaign on the shaker will achieve, before anything is measured; where to hold a sensor next.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::{Failure, Outcome, clock};
use proofmass::jobs::campaign::Campaign;
use proofmass::jobs::plan::PlanOutcome;
use proofmass::jobs::{Job, Outcome as _, Record, StoredResult};
use std::path::PathBuf;

/// Predict the uncertainties of a campaign before it is measured.
///
/// Of a campaign of kind `shaker-triaxial` it reads budget, certificate and plan, and finds the best of fewer
/// configurations; nothing needs to have been measured. The candidates are the plan of the campaign, or else the
/// configurations of its runs, or else the 44 published ones.
///
/// Of a campaign of kind `multi-position` it evaluates what there is so far, and lists the further positions that narrow
/// the intervals most, and to what.
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
    /// Refuse a campaign that names files outside of its folder: for campaigns that others made
    #[arg(long)]
    contained: bool,
    #[command(flatten)]
    delivery: Delivery,
}

impl Plan {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let toml = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("toml");
        if self.campaign.is_file() && !self.campaign.extension().is_some_and(toml) {
            return Err(Failure::new("a plan needs a campaign, and this is a file of another sort")
                .detail(self.campaign.display().to_string())
                .hint("for a recording: `proofmass init RECORDING` writes its campaign, and `proofmass calibrate RECORDING` lists the attitudes to add as well"));
        }
        let campaign = match self.contained {
            true => Campaign::open_contained(&self.campaign)?,
            false => Campaign::open(&self.campaign)?,
        };
        let kind = campaign.result_kind();
        if let Campaign::MultiPosition(campaign) = &campaign {
            if self.best.is_some() || !self.sizes.is_empty() {
                return Err(Failure::new(
                    "attitudes of a sensor held by hand are not chosen among configurations",
                )
                .hint("leave out --best and --sizes: the plan lists the attitudes to add"));
            }
            let folder = self.delivery.begin(kind, &[&self.campaign])?;
            let result = campaign.plan(Some(clock::today()), &Progress::new())?;
            return self.delivery.deliver(folder, &result);
        }
        let folder = self.delivery.begin(PlanOutcome::KIND, &[&self.campaign])?;
        let campaign = match campaign {
            Campaign::ShakerTriaxial(campaign) => campaign,
            other => {
                return Err(Failure::new(format!(
                    "a campaign of kind `{}` has no plan of configurations",
                    other.kind()
                ))
                .hint(
                    "plans are those of campaigns of kind `shaker-triaxial` and `multi-position`",
                ));
            }
        };
        let (mut job, inputs) = campaign.plan_job(self.frequency)?;
        (job.best, job.sizes) = (self.best, self.sizes);
        let outcome = job.answer(&(), &inputs, &Progress::new())?;
        let record = Record {
            title: campaign.title().map(str::to_owned),
            date: Some(clock::today()),
            inputs,
            ..Record::default()
        };
        self.delivery
            .deliver(folder, &StoredResult::new(record, &outcome)?)
    }
}
