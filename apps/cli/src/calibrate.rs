//! `proofmass calibrate`: any campaign, its kind read from it.

use crate::console::Progress;
use crate::delivery::Delivery;
use crate::draft_arguments::DraftArguments;
use crate::number_arguments::coverage_factor;
use crate::{Failure, Outcome, clock, host};
use proofmass::documents::ResultDocument;
use proofmass::io::is_lent;
use proofmass::jobs::RESULT;
use proofmass::jobs::campaign::Campaign;
use std::path::{Path, PathBuf};

/// Calibrate a sensor from a campaign folder, or from one recording.
///
/// A campaign is a folder with `campaign.toml` and the recordings it names. Its `kind` says what is calibrated:
/// `multi-position`, `single-axis`, `free-living`, `shaker-triaxial`, `shaker-single`, `shaker-primary`,
/// `transverse-sensitivity` or `spurious-motion`. A recording alone, with static intervals in many positions, needs the place (`--latitude`) or
/// local gravity; `proofmass init` writes a campaign for it.
/// Results go to a folder: result.json (everything, covariance included), report.html (one file, opens without
/// network), calibration.json (what `proofmass apply` needs) and CSV tables.
#[derive(clap::Args)]
#[command(mut_arg("output", |a| a.help("Folder for the results [default: `result` beside campaign.toml]")))]
pub(crate) struct Calibrate {
    /// Campaign folder, its campaign.toml, or a recording
    campaign: PathBuf,
    /// Refuse a campaign that names files outside of its folder: for campaigns that others made
    #[arg(long)]
    contained: bool,
    /// Shaker campaigns: coverage factor of U, such as 2; its probability is stated [default: that of 95 %]
    #[arg(short = 'k', long, alias = "coverage", value_name = "K", value_parser = coverage_factor)]
    coverage_factor: Option<f64>,
    #[command(flatten)]
    recording: DraftArguments,
    #[command(flatten)]
    delivery: Delivery,
}

impl Calibrate {
    /// Whether a campaign is named, and not a recording.
    pub(crate) fn is_of_a_campaign(&self) -> bool {
        let toml = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("toml");
        let is_recording = is_lent(&self.campaign) || self.campaign.is_file();
        !is_recording || self.campaign.extension().is_some_and(toml)
    }

    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let of_recording = !self.is_of_a_campaign();
        if self.campaign == Path::new("-") {
            return Err(
                Failure::new("a calibration reads its recording more than once, and standard input can be read once")
                    .hint("write it to a file first, then: proofmass calibrate FILE"),
            );
        }
        let mut campaign = if of_recording {
            let draft = self.recording.draft();
            draft.campaign(&self.campaign)?
        } else {
            // What is not there is no campaign either, and that is what has to be said.
            if self.campaign.exists() {
                self.recording.refuse_with_a_campaign()?;
            }
            match self.contained {
                true => Campaign::open_contained(&self.campaign)?,
                false => Campaign::open(&self.campaign)?,
            }
        };
        if let Some(k) = self.coverage_factor {
            campaign.state_with(k)?;
        }
        let beside = || campaign.source().resolve("result");
        if of_recording && self.delivery.output.is_none() && host::host().is_none() {
            refuse_of_another(&beside(), &self.campaign)?;
        }
        let place = match self.delivery.output.clone() {
            // A host asks for files where it wants them.
            None if host::host().is_some() => None,
            place => Some(place.unwrap_or_else(beside)),
        };
        let mut outcome = Outcome::Done;
        let mut each = Vec::new();
        // Every folder is begun before the work: a place that is taken is told before, not after it.
        for (name, campaign) in campaign.of_each_device() {
            let own = |place: PathBuf| name.map_or(place.clone(), |name| place.join(name));
            let source = campaign.source();
            let begin = |place| {
                self.delivery
                    .begin_at(own(place), campaign.result_kind(), &[&source.path])
            };
            each.push((place.clone().map(begin).transpose()?, campaign));
        }
        for (folder, campaign) in each {
            let result = campaign.evaluate(Some(clock::today()), &Progress::new())?;
            outcome = outcome.or(self.delivery.deliver(folder, &result)?);
        }
        Ok(outcome)
    }
}

/// Refuses to put the result of a recording in the place of that of another one, where nobody named the place.
fn refuse_of_another(place: &Path, recording: &Path) -> Result<(), Failure> {
    let Ok(bytes) = std::fs::read(place.join(RESULT)) else {
        return Ok(());
    };
    let Ok(document) = ResultDocument::from_json(&bytes) else {
        return Ok(());
    };
    let name = |path: &Path| path.file_name().map(std::ffi::OsStr::to_owned);
    let mut inputs = document.inputs.iter().map(|i| Path::new(&i.path));
    let of_this = inputs.clone().any(|i| name(i) == name(recording));
    match inputs.next_back() {
        Some(other) if !of_this => Err(Failure::new(format!(
            "{} is the result of {}",
            place.display(),
            other.display()
        ))
        .hint("name a folder for this one with -o FOLDER, or move the other away")),
        _ => Ok(()),
    }
}
