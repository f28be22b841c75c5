//! A multi-position campaign from its files to its results.

use super::Calibrate;
use crate::plural::count;
use crate::{Failure, Outcome, clock, console};
use proofmass::calibration::{
    AttitudeUncertainty, DirectionCoverage, Estimator, Ferraris, Model, MultiPosition, Samples,
    Segment, Standstill, StandstillCalibration, WindowedVariance, clipping, suspected_clipping,
    temperature_drift,
};
use proofmass::core::{Error, Gravity};
use proofmass::io::{
    CalibrationFile, Cell, GravityInput, Input, MethodModel, MultiPositionCampaign, OutputFolder,
    Recording, ResultDocument, Software, Table, Unit,
};
use proofmass::report::{MultiPositionReport, Report, html};
use proofmass::uncertainty::{DegreesOfFreedom, Finding, Quantity};
use serde::Serialize;

pub(super) fn run(
    arguments: &Calibrate,
    campaign: &MultiPositionCampaign,
) -> Result<Outcome, Failure> {
    let folder = arguments
        .output
        .clone()
        .unwrap_or_else(|| campaign.source.resolve("result"));
    // Refused before the work, not after it.
    let folder = OutputFolder::create(folder, arguments.force)?;
    let data = Data::read(campaign)?;
    let settings = settings(campaign, &data)?;
    let calibration = calibrate(campaign, &data, &settings)?;
    let findings = findings(campaign, &data, &calibration);

    let calibration_file = calibration_file(campaign, &data, &calibration);
    let result = result(campaign, &data, &calibration, &findings)?.to_json()?;
    let samples = data.samples()?;
    let windowed = WindowedVariance::new(&samples, data.rate, &data.breaks, &search(campaign)).ok();
    let time = data.time();
    let text = MultiPositionReport {
        title: title(campaign),
        meta: meta(campaign),
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
        footer: format!(
            "{} {}",
            Software::default().name,
            Software::default().version
        ),
    };
    folder.write("result.json", &result)?;
    folder.write("calibration.json", calibration_file.to_json()?)?;
    folder.write("report.html", html::render(&text.full(&calibration))?)?;
    folder.write(
        "parameters.csv",
        parameters(campaign, &calibration)?.to_csv()?,
    )?;
    folder.write(
        "standstills.csv",
        standstills(&data, &calibration)?.to_csv()?,
    )?;
    folder.write("covariance.csv", covariance(&calibration)?.to_csv()?)?;
    let place = folder.commit()?;

    if arguments.json {
        console::print_json(&result)?;
    } else {
        let summary: Report = text.summary(&calibration);
        console::show(&summary)?;
    }
    console::note(format!("written: {}", place.display()));
    Ok(Outcome::of(arguments.strict, &findings))
}

/// All recordings of the campaign, one after the other, in SI where their unit has a place in it.
struct Data {
    recordings: Vec<Recording>,
    columns: [Vec<f64>; 3],
    temperature: Option<Vec<f64>>,
    /// Samples before which time jumps: gaps and the seams between recordings.
    breaks: Vec<usize>,
    rate: f64,
    unit: Unit,
    /// What a value in the file is multiplied with.
    factor: f64,
}

impl Data {
    fn read(campaign: &MultiPositionCampaign) -> Result<Self, Failure> {
        let recordings = campaign.read_recordings()?;
        let Some(first) = recordings.first() else {
            return Err(Failure::new("the campaign names no recording"));
        };
        let Some(file_unit) = first.columns[0].unit else {
            return Err(Failure::new(format!(
                "{}: the unit of the outputs is not known",
                first.path.display()
            ))
            .hint("write it in the headings (acc_x_m/s2), or add `unit = \"count\"`, `\"m/s²\"` or `\"g\"` to [recording]"));
        };
        let (unit, factor) = file_unit.si();
        let rate = first.time.rate_hz();
        let mut data = Self {
            columns: Default::default(),
            temperature: first.temperature.as_ref().map(|_| Vec::new()),
            breaks: Vec::new(),
            rate,
            unit,
            factor,
            recordings: Vec::new(),
        };
        for recording in recordings {
            let other = recording.time.rate_hz();
            if (other / rate - 1.0).abs() > 0.01 {
                return Err(Failure::new(format!(
                    "{}: sampled at {other:.3} Hz, the recording before at {rate:.3} Hz",
                    recording.path.display()
                ))
                .hint("calibrate recordings of different rates as separate campaigns"));
            }
            let start = data.columns[0].len();
            if start > 0 {
                data.breaks.push(start);
            }
            let gaps = recording
                .time
                .gaps()
                .iter()
                .map(|gap| start + gap.after_sample + 1);
            data.breaks.extend(gaps);
            let recording = recording.into_si();
            for (all, column) in data.columns.iter_mut().zip(&recording.columns) {
                if column.unit != Some(unit) {
                    return Err(Failure::new(format!(
                        "{}: column {:?} is not in the unit of the other columns",
                        recording.path.display(),
                        column.name
                    ))
                    .hint("x, y and z must share one unit"));
                }
                all.extend(&column.data);
            }
            match (&mut data.temperature, &recording.temperature) {
                (Some(all), Some(column)) => all.extend(&column.data),
                (all, _) => *all = None,
            }
            data.recordings.push(recording);
        }
        Ok(data)
    }

    fn samples(&self) -> Result<Samples<'_>, Error> {
        let [x, y, z] = &self.columns;
        Samples::new(x, y, z)
    }

    fn names(&self) -> String {
        let names: Vec<String> = self
            .recordings
            .iter()
            .map(|r| r.path.display().to_string())
            .collect();
        names.join(", ")
    }

    fn is_acceleration(&self) -> bool {
        self.unit.is_acceleration()
    }

    /// Time of every sample; recordings follow one another without pause.
    fn time(&self) -> Vec<f64> {
        let mut time = Vec::with_capacity(self.columns[0].len());
        let mut offset = 0.0;
        for recording in &self.recordings {
            let start = recording.time.seconds(0);
            time.extend(
                (0..recording.samples()).map(|i| offset + recording.time.seconds(i) - start),
            );
            offset += recording.duration_s();
        }
        time
    }

    fn inputs(&self, campaign: &MultiPositionCampaign) -> Vec<Input> {
        let mut inputs = vec![campaign.source.input.clone()];
        inputs.extend(self.recordings.iter().map(Recording::input));
        if let Some(Ok(segments)) = campaign.segments_file().map(|path| Input::of(&path)) {
            inputs.push(segments);
        }
        inputs
    }
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

/// What a fit that failed says to the person who recorded the data.
fn explain(
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
    campaign.title.clone().unwrap_or_else(|| {
        let device = &campaign.device;
        let words: Vec<&str> = [&device.manufacturer, &device.model, &device.serial]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        if words.is_empty() {
            "Calibration of a triaxial accelerometer".to_owned()
        } else {
            format!("Calibration of {}", words.join(" "))
        }
    })
}

fn meta(campaign: &MultiPositionCampaign) -> Vec<(String, String)> {
    let device = &campaign.device;
    let ambient = &campaign.ambient;
    [
        ("Manufacturer", device.manufacturer.clone()),
        ("Model", device.model.clone()),
        ("Serial number", device.serial.clone()),
        ("Device", device.description.clone()),
        (
            "Temperature",
            ambient.temperature_deg_c.map(|t| format!("{t} °C")),
        ),
        ("Conditions", ambient.description.clone()),
        ("Evaluated on", Some(clock::today())),
    ]
    .into_iter()
    .filter_map(|(label, value)| Some((label.to_owned(), value?)))
    .collect()
}

fn gravity_quantity(gravity: Gravity) -> Quantity {
    Quantity {
        name: "gravity".to_owned(),
        unit: "m/s²".to_owned(),
        value: gravity.value(),
        standard_uncertainty: gravity.standard_uncertainty(),
        dof: DegreesOfFreedom::INFINITE,
    }
}

fn calibration_file(
    campaign: &MultiPositionCampaign,
    data: &Data,
    calibration: &StandstillCalibration,
) -> CalibrationFile {
    let fit = &calibration.fit;
    let sensor = fit.model();
    let mut file = CalibrationFile::new(
        campaign.method.model.name(),
        data.unit,
        sensor.k().0,
        sensor.bias(),
        fit.estimate().clone(),
    );
    let columns = &campaign.recording.columns;
    file.columns = Some([columns.x.clone(), columns.y.clone(), columns.z.clone()]);
    file.device = campaign.device.clone();
    file.gravity = Some(gravity_quantity(fit.gravity()));
    file.repeatability = Some(fit.excess());
    file.temperature_range = temperature_range(data, calibration).or_else(|| {
        let t = campaign.ambient.temperature_deg_c?;
        Some([t, t])
    });
    let reached = fit.residuals().iter().flat_map(|r| r.acceleration);
    let low = reached.clone().fold(f64::INFINITY, f64::min);
    let high = reached.fold(f64::NEG_INFINITY, f64::max);
    file.acceleration_range = Some([low, high]);
    file.inputs = data.inputs(campaign);
    file
}

fn temperature_range(data: &Data, calibration: &StandstillCalibration) -> Option<[f64; 2]> {
    let temperature = data.temperature.as_ref()?;
    let used = calibration
        .sweep
        .segments
        .iter()
        .flat_map(|s| &temperature[s.start..s.end]);
    let low = used.clone().copied().fold(f64::INFINITY, f64::min);
    let high = used.copied().fold(f64::NEG_INFINITY, f64::max);
    Some([low, high])
}

/// What only this kind of result has.
#[derive(Serialize)]
struct Fit<'a> {
    #[serde(rename = "K")]
    k: [[f64; 3]; 3],
    b: [f64; 3],
    chi_square: f64,
    degrees_of_freedom: usize,
    birge_ratio: Option<f64>,
    excess_m_per_s2: f64,
    condition_number: f64,
    iterations: usize,
    residual_rms_m_per_s2: f64,
    ferraris: Option<Ferraris>,
    direction_coverage: &'a DirectionCoverage,
}

fn result(
    campaign: &MultiPositionCampaign,
    data: &Data,
    calibration: &StandstillCalibration,
    findings: &[Finding],
) -> Result<ResultDocument, Failure> {
    let fit = &calibration.fit;
    let mut document = ResultDocument::new("multi-position")
        .title(title(campaign))
        .device(&campaign.device)
        .model(campaign.method.model.name())
        .findings(findings)
        .estimate(fit.estimate(), campaign.method.confidence)
        .quantity(&gravity_quantity(fit.gravity()), campaign.method.confidence);
    for input in data.inputs(campaign) {
        document = document.input(input);
    }
    let sensor = fit.model();
    Ok(document
        .section("date", &clock::today())?
        .section(
            "fit",
            &Fit {
                k: sensor.k().0,
                b: sensor.bias(),
                chi_square: fit.chi_square(),
                degrees_of_freedom: fit.degrees_of_freedom(),
                birge_ratio: fit.birge_ratio(),
                excess_m_per_s2: fit.excess(),
                condition_number: fit.condition(),
                iterations: fit.iterations(),
                residual_rms_m_per_s2: fit.residual_rms(),
                ferraris: (campaign.method.model == MethodModel::Ferraris)
                    .then(|| Ferraris::of(&sensor.k().0)),
                direction_coverage: fit.coverage(),
            },
        )?
        .section("standstills", &fit.residuals())?
        .section("threshold", &calibration.sweep.threshold)?
        .section("threshold_sweep", &calibration.sweep.candidates)?)
}

fn parameters(
    campaign: &MultiPositionCampaign,
    calibration: &StandstillCalibration,
) -> Result<Table, Failure> {
    let p = campaign.method.confidence;
    let mut table = Table::new(["quantity", "value", "unit", "u", "U", "k", "nu_eff"]);
    for q in calibration.fit.estimate().quantities() {
        let nu = q.dof.get();
        table.push([
            Cell::from(q.name.as_str()),
            Cell::from(q.value),
            Cell::from(q.unit.as_str()),
            Cell::from(q.standard_uncertainty),
            Cell::from(q.expanded(p)),
            Cell::from(q.coverage_factor(p)),
            Cell::from(nu.is_finite().then_some(nu)),
        ])?;
    }
    Ok(table)
}

fn standstills(data: &Data, calibration: &StandstillCalibration) -> Result<Table, Failure> {
    let unit = data.unit.ascii();
    let mut columns = vec![
        "standstill".to_owned(),
        "first_sample".to_owned(),
        "end_sample".to_owned(),
    ];
    columns.extend(["x", "y", "z"].map(|a| format!("output_{a}_{unit}")));
    columns.extend(["x", "y", "z"].map(|a| format!("acceleration_{a}_m/s2")));
    columns.extend(
        [
            "residual_m/s2",
            "residual_noise_m/s2",
            "studentised_residual",
        ]
        .map(str::to_owned),
    );
    let mut table = Table::new(columns);
    for r in calibration.fit.residuals() {
        let mut row = vec![
            Cell::from(r.name.as_str()),
            Cell::from(r.samples.0 as f64),
            Cell::from(r.samples.1 as f64),
        ];
        row.extend(
            r.output
                .iter()
                .chain(&r.acceleration)
                .map(|v| Cell::from(*v)),
        );
        row.push(Cell::from(r.magnitude_residual));
        row.push(Cell::from(r.noise));
        row.push(Cell::from(r.studentised));
        table.push(row)?;
    }
    Ok(table)
}

fn covariance(calibration: &StandstillCalibration) -> Result<Table, Failure> {
    let estimate = calibration.fit.estimate();
    let names = estimate.components().iter().map(|c| c.name.clone());
    let mut table = Table::new(std::iter::once("quantity".to_owned()).chain(names));
    let n = estimate.components().len();
    for (i, component) in estimate.components().iter().enumerate() {
        let mut row = vec![Cell::from(component.name.as_str())];
        row.extend((0..n).map(|j| Cell::from(estimate.covariance()[(i, j)])));
        table.push(row)?;
    }
    Ok(table)
}
