//! Frequency response from recordings of stepped sines.

use super::ResponseData;
use crate::trouble::{Result, Trouble};
use proofmass_dynamic::sine_steps::{NoResponse, NoSteps, SineSteps, response_of};
use proofmass_signal::transfer::ResponseEstimate;
use proofmass_uncertainty::Finding;

/// Points of all steps of all recordings, ascending in frequency.
pub(super) fn response(
    data: &ResponseData<'_>,
    band: Option<[f64; 2]>,
    findings: &mut Vec<Finding>,
) -> Result<ResponseEstimate> {
    let mut steps = Vec::new();
    let many = data.recordings.len() > 1;
    for (k, [x, y]) in data.recordings.iter().enumerate() {
        let place = if many {
            format!("recording {} of {}", k + 1, data.name)
        } else {
            data.name.to_owned()
        };
        let found = SineSteps::default()
            .evaluate(x.data, y.data, data.rate)
            .map_err(|why| refusal(why, &place))?;
        steps.extend(found.steps);
        findings.extend(found.findings);
    }
    if let Some([low, high]) = band {
        steps.retain(|s| (low..=high).contains(&s.frequency));
    }
    Ok(response_of(steps))
}

fn refusal(why: NoResponse, place: &str) -> Trouble {
    match why {
        NoResponse::Steps(NoSteps::NoSine { periods, steady }) => {
            Trouble::data("the input is not a stepped sine")
                .detail(place)
                .detail(format!(
                    "{periods} periods, at most {steady} of them alike in a row"
                ))
                .with_hint("a stepped sine stays at each frequency for twelve periods or more; for noise use `proofmass test random`")
        }
        NoResponse::Steps(NoSteps::Sweep { periods, rate }) => {
            Trouble::data("the frequency of the input changes all the time: it never stays for a step")
                .detail(place)
                .detail(format!(
                    "{periods} periods, each {:.2} % from the one before it",
                    100.0 * rate
                ))
                .with_hint("evaluate it with `proofmass test sweep`, or stay twelve periods at each frequency")
        }
        NoResponse::Unusable(findings) => {
            let mut trouble = Trouble::data("none of the steps can be used").detail(place);
            for finding in &findings {
                trouble =
                    trouble.detail(format!("{}: {}", finding.what(), finding.evidence_text()));
            }
            match findings.first() {
                Some(finding) => trouble.with_hint(finding.advice_text()),
                None => trouble,
            }
        }
        NoResponse::Data(e) => Trouble::from(e).detail(place),
    }
}
