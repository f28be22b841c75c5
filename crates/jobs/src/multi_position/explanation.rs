//! What a fit that failed says to the person who recorded the data.

use super::{MultiPositionData, MultiPositionJob};
use crate::campaign::MethodModel;
use crate::plural::count;
use crate::trouble::Trouble;
use proofmass_calibration::{DirectionCoverage, Samples, Segment, WindowedVariance};
use proofmass_core::Error;

/// What a fit that failed says to the person who recorded the data.
pub(super) fn explain(
    error: Error,
    job: &MultiPositionJob,
    data: &MultiPositionData<'_>,
    given: Option<&[Segment]>,
) -> Trouble {
    let trouble = Trouble::from(error);
    let model = job.method.name();
    match error {
        Error::Constant { .. } => trouble.detail(data.name).with_hint(
            "check the columns named in [recording], and that the sensor was switched on",
        ),
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
            trouble
                .detail(format!(
                    "{}: declared as m/s² or a multiple of it",
                    data.name
                ))
                .with_hint(hint)
        }
        Error::TooFew { .. }
        | Error::Unobservable { .. }
        | Error::TooUncertain { .. }
        | Error::NotConverged { .. }
        | Error::NotPositiveDefinite { .. } => {
            let trouble = match directions(job, data, given) {
                Some((standstills, coverage)) => trouble.detail(format!(
                    "{}: {}, {coverage}",
                    data.name,
                    count(standstills, "standstill")
                )),
                None => trouble.detail(data.name),
            };
            trouble.with_hint(match smaller(job.method) {
                Some(smaller) => format!(
                    "record at least twelve standstills of 3 s in well-spread attitudes, each axis up and down among them, or fit a smaller model (`model = \"{smaller}\"` in [method])"
                ),
                None => format!("record more standstills in other attitudes; `{model}` is the smallest model"),
            })
        }
        _ => trouble.detail(data.name),
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
    job: &MultiPositionJob,
    data: &MultiPositionData<'_>,
    given: Option<&[Segment]>,
) -> Option<(usize, DirectionCoverage)> {
    let [x, y, z] = data.outputs;
    let samples = Samples::new(x, y, z).ok()?;
    let segments = match given {
        Some(given) => given.to_vec(),
        None => {
            let windowed =
                WindowedVariance::new(&samples, data.rate, data.breaks, &job.search).ok()?;
            windowed.segments(job.search.threshold.unwrap_or(6.0))
        }
    };
    let attitudes: Option<Vec<[f64; 3]>> = segments.iter().map(|s| s.attitude).collect();
    let means: Vec<[f64; 3]> = segments
        .iter()
        .map(|s| samples.mean(s.start, s.end))
        .collect();
    let coverage = match attitudes {
        Some(attitudes) if !attitudes.is_empty() => DirectionCoverage::of(&attitudes),
        _ => DirectionCoverage::of_outputs(&means, data.unit.is_acceleration()).ok()?,
    };
    Some((segments.len(), coverage))
}
