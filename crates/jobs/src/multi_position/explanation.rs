//! What a fit that failed says to the person who recorded the data.

use super::{MultiPositionData, MultiPositionJob};
use crate::campaign::MethodModel;
use crate::plural::count;
use crate::trouble::Trouble;
use proofmass_core::Error;
use proofmass_static::{
    DirectionCoverage, MeanNoise, Samples, Segment, ThresholdSweep, WindowedVariance,
};

/// What a fit that failed says to the person who recorded the data.
pub(super) fn explain(
    error: Error,
    job: &MultiPositionJob,
    data: &MultiPositionData<'_>,
    given: Option<&[Segment]>,
) -> Trouble {
    let trouble = Trouble::from(error);
    match error {
        Error::Constant { .. } => trouble.detail(data.name).with_hint(
            "check which columns are read, and that the sensor was switched on",
        ),
        Error::OutOfRange {
            name: "magnitude of the output at rest",
            value,
            ..
        } => {
            let hint = if (0.5..2.0).contains(&value) {
                "the outputs look like multiples of g: say --unit g (`unit = \"g\"` in a campaign)"
            } else if value > 200.0 {
                "the outputs look like raw counts: say --unit count (`unit = \"count\"` in a campaign)"
            } else {
                "at rest a sensor reads about 9.8 m/s²: check the unit and which columns are read"
            };
            Trouble::data(format!(
                "magnitude of the output at rest = {value:.4} m/s², and gravity is {:.4} m/s²",
                job.gravity.value()
            ))
            .detail(format!(
                "{}: declared as m/s² or a multiple of it",
                data.name
            ))
            .with_hint(hint)
        }
        Error::TooFew { .. } | Error::Unobservable { .. } | Error::TooUncertain { .. }
            if data.tumble =>
        {
            trouble.detail(data.name).with_hint("turn the sensor for longer, slowly, so that every axis points up and down several times; or fit a smaller model")
        }
        Error::TooFew { .. }
        | Error::Unobservable { .. }
        | Error::TooUncertain { .. }
        | Error::NotConverged { .. }
        | Error::NotFinite { .. }
        | Error::Singular { .. }
        | Error::NotPositiveDefinite { .. } => data_at_fault(error, job, data, given),
        _ => trouble.detail(data.name),
    }
}

/// Positions that determine everything once their directions are given.
const SIX: usize = 6;
/// Standstills below which a fit without directions leaves hardly anything to check it.
const FEW: usize = 12;

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

/// Standstills that do not make a calibration: how many there are, where, and everything else that is known of them.
fn data_at_fault(
    error: Error,
    job: &MultiPositionJob,
    data: &MultiPositionData<'_>,
    given: Option<&[Segment]>,
) -> Trouble {
    let [x, y, z] = data.outputs;
    let Ok(samples) = Samples::new(x, y, z) else {
        return Trouble::from(error).detail(data.name);
    };
    let segments = match given {
        Some(given) => given.to_vec(),
        None => WindowedVariance::new(&samples, data.rate, data.breaks, &job.search)
            .map(|windowed| match job.search.threshold {
                Some(threshold) => windowed.holds(&samples, threshold),
                None => ThresholdSweep::most(&samples, &windowed),
            })
            .unwrap_or_default(),
    };
    let found = if given.is_some() { "given" } else { "found" };
    let n = segments.len();
    let mut trouble = match error {
        // One count, whatever number the fit was offered.
        Error::TooFew {
            name: "standstills",
            needed,
            ..
        } => Trouble::data(format!(
            "too few standstills: {n} {found}, model `{}` needs {needed}",
            job.method.name()
        )),
        Error::NotFinite { .. } | Error::Singular { .. } => Trouble::data(
            "the standstills do not lie on one sphere or ellipsoid: the fit runs away",
        ),
        _ => Trouble::from(error),
    };
    let means: Vec<[f64; 3]> = segments
        .iter()
        .map(|s| samples.mean(s.start, s.end))
        .collect();
    let attitudes: Option<Vec<[f64; 3]>> = segments.iter().map(|s| s.attitude).collect();
    let coverage = match attitudes {
        Some(attitudes) if !attitudes.is_empty() => Some(DirectionCoverage::of(&attitudes)),
        _ => DirectionCoverage::of_outputs(&means, data.unit.is_acceleration()).ok(),
    };
    let all_six = coverage.as_ref().is_some_and(|c| c.missing.is_empty());
    let place = format!("{}: {} {found}", data.name, count(n, "standstill"));
    trouble = trouble.detail(match coverage {
        Some(coverage) => format!("{place}, {coverage}"),
        None => place,
    });
    if data.segments.is_none() {
        let spans = segments.iter().map(|s| s.len() as f64 / data.rate);
        let (shortest, longest) =
            spans.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
        trouble = trouble.detail(format!(
            "at {:.3} samples per second a standstill of less than {:.1} s is not found{}",
            data.rate,
            job.search.shortest_hold(data.rate),
            if n > 0 {
                format!("; those found last {shortest:.1} s to {longest:.1} s")
            } else {
                String::new()
            }
        ));
    }
    let pauses = data.breaks.len();
    if pauses > 0 {
        trouble = trouble.detail(format!(
            "the time stamps pause or restart {}",
            count(pauses, "time")
        ));
    }
    for finding in job.doubts_of_the_samples(data, &samples, &segments) {
        trouble = trouble.detail(format!("{}: {}", finding.what(), finding.evidence_text()));
    }
    for suspect in suspects(job, data, &samples, &segments) {
        trouble = trouble.detail(suspect);
    }
    let model = job.method.name();
    // Perhaps there should be no standstills.
    let tumble = match data.segments.is_none() && n < FEW {
        true => {
            ". A sensor that is turned slowly all the time: --rows tumble (`rows = \"tumble\"` in a campaign)"
        }
        false => "",
    };
    let unknown = segments.iter().all(|s| s.attitude.is_none());
    if unknown && all_six && (SIX..FEW).contains(&n) {
        let how = match data.segments {
            Some(_) => {
                "`directions = [\"+x\", \"-x\", …]` in [standstill] of a campaign, which `proofmass init` writes"
            }
            None => {
                "`segments = \"segments.csv\"` in [standstill] of a campaign, which `proofmass init` writes, with a column `direction` (+x, -x, …)"
            }
        };
        return trouble.with_hint(format!(
            "say which axis points up in each ({how}): then six positions are enough. Without directions record at least \
             twelve{tumble}"
        ));
    }
    // A model that only given attitudes determine, whatever was recorded.
    if unknown && job.method == MethodModel::Full && n >= FEW {
        return trouble.with_hint(
            "model `full` needs the attitude of each standstill, and none is given: add a column `direction` to `segments` in \
             [standstill], or fit --model triangular (`model = \"triangular\"` in a campaign)",
        );
    }
    trouble.with_hint(match smaller(job.method) {
        Some(smaller) => format!(
            "record at least twelve standstills of {:.0} s in well-spread attitudes, each axis up and down among them{}{tumble}{}",
            job.search.shortest_hold(data.rate).ceil().max(3.0),
            // No model does with fewer directions.
            match n >= SIX && all_six {
                true => format!(". Or fit a smaller model: --model {smaller} (`model = \"{smaller}\"` in a campaign)"),
                false => String::new(),
            },
            match n {
                1..SIX => ". One axis alone, up and down: a campaign of the kind single-axis (`proofmass init --kind single-axis`)",
                _ => "",
            }
        ),
        None => format!("record more standstills in other attitudes; `{model}` is the smallest model"),
    })
}

/// Standstills that the others contradict, in words.
fn suspects(
    job: &MultiPositionJob,
    data: &MultiPositionData<'_>,
    samples: &Samples<'_>,
    segments: &[Segment],
) -> Vec<String> {
    let found = || -> Option<Vec<String>> {
        let noise = MeanNoise::estimate(samples, segments).ok()?;
        let poses = noise.poses(samples, segments);
        let settings = job.settings(data).ok()?.noise_dof(noise.dof());
        let suspects = settings.suspects(&poses).ok()?;
        let words = suspects.iter().map(|suspect| {
            let given = segments[suspect.index].attitude;
            match (given, suspect.seen) {
                (Some([x, y, z]), Some([a, b, c])) => format!(
                    "standstill {}: given ({x:+.2}, {y:+.2}, {z:+.2}), the others see it along ({a:+.2}, {b:+.2}, {c:+.2}): correct its attitude or exclude it",
                    suspect.name
                ),
                _ => format!(
                    "standstill {} is out of line with the others by {:.1} % of g: look at it or exclude it",
                    suspect.name,
                    1e2 * suspect.deviation
                ),
            }
        });
        Some(words.collect())
    };
    found().unwrap_or_default()
}
