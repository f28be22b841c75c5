//! What a fit that failed says to the person who recorded the data.

use super::data::Data;
use super::search;
use crate::Failure;
use crate::plural::count;
use proofmass::calibration::{DirectionCoverage, Segment, WindowedVariance};
use proofmass::core::Error;
use proofmass::jobs::campaign::{MethodModel, MultiPositionCampaign};

/// What a fit that failed says to the person who recorded the data.
pub(super) fn explain(
    error: Error,
    campaign: &MultiPositionCampaign,
    data: &Data,
    given: Option<&[Segment]>,
) -> Failure {
    let failure = Failure::new(error.to_string());
    let model = campaign.method.model.name();
    match error {
        Error::Constant { .. } => failure
            .detail(data.names())
            .hint("check the columns named in [recording], and that the sensor was switched on"),
        Error::OutOfRange {
            name: "magnitude of the output at rest",
            value,
            ..
        } => {
            let hint = if (0.5..2.0).contains(&value) {
                "the outputs look like multiples of g: set `unit = \"g\"` in [recording]"
            } else if value > 200.0 {
                "the outputs look like raw counts: set `unit = \"count\"` in [recording]"
            } else {
                "at rest a sensor reads about 9.8 m/s²: check `unit` and the columns in [recording]"
            };
            failure
                .detail(format!(
                    "{}: declared as m/s² or a multiple of it",
                    data.names()
                ))
                .hint(hint)
        }
        Error::TooFew { .. }
        | Error::Unobservable { .. }
        | Error::TooUncertain { .. }
        | Error::NotConverged { .. }
        | Error::NotPositiveDefinite { .. } => {
            let failure = match directions(campaign, data, given) {
                Some((standstills, coverage)) => failure.detail(format!(
                    "{}: {}, {coverage}",
                    data.names(),
                    count(standstills, "standstill")
                )),
                None => failure.detail(data.names()),
            };
            failure.hint(match smaller(campaign.method.model) {
                Some(smaller) => format!(
                    "record at least twelve standstills of 3 s in well-spread attitudes, each axis up and down among them, or fit a smaller model (`model = \"{smaller}\"` in [method])"
                ),
                None => format!("record more standstills in other attitudes; `{model}` is the smallest model"),
            })
        }
        _ => failure.detail(data.names()),
    }
}

fn smaller(model: MethodModel) -> Option<&'static str> {
    match model {
        MethodModel::Bias => None,
        MethodModel::BiasScale => Some("bias"),
        MethodModel::Triangular | MethodModel::Symmetric | MethodModel::Ellipsoid => {
            Some("bias-scale")
        }
        MethodModel::Full | MethodModel::SixPosition | MethodModel::Ferraris => Some("triangular"),
    }
}

/// Number of standstills and the directions they reach, as far as they can be told without a fit.
fn directions(
    campaign: &MultiPositionCampaign,
    data: &Data,
    given: Option<&[Segment]>,
) -> Option<(usize, DirectionCoverage)> {
    let samples = data.samples().ok()?;
    let segments = match given {
        Some(given) => given.to_vec(),
        None => {
            let windowed =
                WindowedVariance::new(&samples, data.rate, &data.breaks, &search(campaign)).ok()?;
            windowed.segments(campaign.standstill.threshold.unwrap_or(6.0))
        }
    };
    let attitudes: Option<Vec<[f64; 3]>> = segments.iter().map(|s| s.attitude).collect();
    let means: Vec<[f64; 3]> = segments
        .iter()
        .map(|s| samples.mean(s.start, s.end))
        .collect();
    let coverage = match attitudes {
        Some(attitudes) if !attitudes.is_empty() => DirectionCoverage::of(&attitudes),
        _ => DirectionCoverage::of_outputs(&means, data.is_acceleration()).ok()?,
    };
    Some((segments.len(), coverage))
}
