//! A multi-position campaign from its files to its results.

mod data;
mod documents;
mod explanation;

use self::data::Data;
use self::documents::{calibration_file, covariance, parameters, result, standstills};
use self::explanation::explain;
use super::{Calibrate, heading};
use crate::delivery::Results;
use crate::{Failure, Outcome};
use proofmass::calibration::{
    AttitudeUncertainty, Estimator, Model, MultiPosition, Segment, Standstill,
    StandstillCalibration, WindowedVariance, clipping, suspected_clipping, temperature_drift,
};
use proofmass::core::{Error, Gravity};
use proofmass::io::Software;
use proofmass::jobs::campaign::{GravityInput, MethodModel, MultiPositionCampaign};
use proofmass::report::MultiPositionReport;
use proofmass::uncertainty::Finding;

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &MultiPositionCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments.begin(&campaign.source)?;
    let data = Data::read(campaign)?;
    let settings = settings(campaign, &data)?;
    let calibration = calibrate(campaign, &data, &settings)?;
    let findings = findings(campaign, &data, &calibration);

    let json = result(campaign, &data, &calibration, &findings)?.to_json()?;
    let samples = data.samples()?;
    let windowed = WindowedVariance::new(&samples, data.rate, &data.breaks, &search(campaign)).ok();
    let time = data.time();
    let text = MultiPositionReport {
        title: title(campaign),
        meta: heading::meta(&campaign.device, &campaign.ambient),
        inputs: data
            .inputs(campaign)
            .into_iter()
            .map(|i| (i.path, i.sha256))
            .collect(),
        method: campaign.method.model.name().to_owned(),
        probability: campaign.method.confidence,
        findings: &findings,
        recording: Some((&time, samples.columns())),
        windowed: windowed
            .as_ref()
            .filter(|_| calibration.sweep.threshold.is_some()),
        footer: Software::default().to_string(),
    };
    arguments.delivery.hand_over(
        Some(folder),
        &Results {
            json,
            summary: &|| text.summary(&calibration),
            report: &|| text.full(&calibration),
            files: vec![
                (
                    "calibration.json",
                    calibration_file(campaign, &data, &calibration).to_json()?,
                ),
                (
                    "parameters.csv",
                    parameters(campaign, &calibration)?.to_csv()?,
                ),
                (
                    "standstills.csv",
                    standstills(&data, &calibration)?.to_csv()?,
                ),
                ("covariance.csv", covariance(&calibration)?.to_csv()?),
            ],
            findings: &findings,
        },
    )
}

fn gravity(campaign: &MultiPositionCampaign) -> Result<Gravity, Error> {
    match campaign.gravity {
        GravityInput::Given {
            value,
            standard_uncertainty,
        } => Gravity::given(value, standard_uncertainty),
        GravityInput::Place {
            latitude_deg,
            height_m,
            latitude_standard_uncertainty_deg,
            height_standard_uncertainty_m,
            standard_uncertainty,
        } => {
            let normal = Gravity::normal(
                latitude_deg,
                height_m,
                latitude_standard_uncertainty_deg.unwrap_or(0.0),
                height_standard_uncertainty_m.unwrap_or(0.0),
            )?;
            match standard_uncertainty {
                Some(u) => Gravity::given(normal.value(), u),
                None => Ok(normal),
            }
        }
    }
}

fn settings(campaign: &MultiPositionCampaign, data: &Data) -> Result<MultiPosition, Failure> {
    let model = match campaign.method.model {
        MethodModel::Bias => Model::Bias,
        MethodModel::BiasScale => Model::BiasScale,
        MethodModel::Triangular => Model::Triangular,
        MethodModel::Symmetric | MethodModel::Ellipsoid => Model::Symmetric,
        MethodModel::Full | MethodModel::SixPosition | MethodModel::Ferraris => Model::Full,
    };
    let mut settings = MultiPosition::new(gravity(campaign)?)
        .model(model)
        .output_unit(data.unit.to_string());
    if data.is_acceleration() {
        settings = settings.nominal_sensitivity(1.0);
    } else if model == Model::Bias {
        return Err(Failure::new(format!(
            "model `bias` needs outputs in m/s² or g; {} holds {}",
            data.names(),
            data.unit
        ))
        .hint("fit `bias-scale`, or convert the recording with the nominal sensitivity first"));
    }
    if let Some(deg) = campaign.attitude.standard_uncertainty_deg {
        settings = settings.attitude_uncertainty(AttitudeUncertainty {
            independent: deg.to_radians(),
            common: 0.0,
        });
    }
    Ok(settings)
}

fn search(campaign: &MultiPositionCampaign) -> Standstill {
    let table = &campaign.standstill;
    let default = Standstill::default();
    Standstill {
        window: table.window_s.unwrap_or(default.window),
        minimum_duration: table.minimum_duration_s.unwrap_or(default.minimum_duration),
        threshold: table.threshold,
    }
}

fn calibrate(
    campaign: &MultiPositionCampaign,
    data: &Data,
    settings: &MultiPosition,
) -> Result<StandstillCalibration, Failure> {
    let samples = data.samples()?;
    let given = match data.recordings.as_slice() {
        [only] => campaign.read_segments(only)?,
        _ if campaign.standstill.segments.is_some() => {
            return Err(
                Failure::new("given standstills need a campaign of one recording")
                    .hint("join the recordings into one file, or make one campaign of each"),
            );
        }
        _ => None,
    };
    let method = campaign.method.model;
    let Some(given) = given else {
        if method.needs_attitudes() {
            return Err(Failure::new(format!("method `{}` needs given attitudes", method.name()))
                .hint("add `segments = \"segments.csv\"` to [standstill], with a column `direction` (+x, -x, …) or up_x, up_y, up_z; or fit `triangular`"));
        }
        let search = search(campaign);
        return StandstillCalibration::run(&samples, data.rate, &data.breaks, &search, settings)
            .map_err(|error| explain(error, campaign, data, None));
    };
    let segments: Vec<Segment> = given
        .into_iter()
        .map(|s| Segment {
            start: s.start,
            end: s.end,
            attitude: s.attitude,
            label: s.label,
        })
        .collect();
    let estimator = match method {
        MethodModel::SixPosition | MethodModel::Ferraris => Estimator::SixPositions,
        _ => Estimator::LeastSquares,
    };
    StandstillCalibration::of_segments(&samples, segments.clone(), settings, estimator)
        .map_err(|error| explain(error, campaign, data, Some(&segments)))
}

fn findings(
    campaign: &MultiPositionCampaign,
    data: &Data,
    calibration: &StandstillCalibration,
) -> Vec<Finding> {
    let mut findings: Vec<Finding> = data
        .recordings
        .iter()
        .flat_map(|r| r.findings().to_vec())
        .collect();
    let segments = &calibration.sweep.segments;
    if let Ok(samples) = data.samples() {
        findings.extend(match campaign.recording.range {
            Some([low, high]) => {
                let range = (low * data.factor, high * data.factor);
                clipping(&samples, range, segments)
            }
            None => suspected_clipping(&samples),
        });
    }
    if let Some(temperature) = &data.temperature {
        findings.extend(temperature_drift(
            temperature,
            segments,
            calibration.fit.residuals(),
        ));
    }
    findings.extend(calibration.fit.findings().iter().cloned());
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
    findings
}

fn title(campaign: &MultiPositionCampaign) -> String {
    heading::title(
        campaign.title.as_ref(),
        &campaign.device,
        "Calibration of a triaxial accelerometer",
    )
}
