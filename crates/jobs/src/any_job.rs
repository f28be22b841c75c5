//! A job of whatever kind, as one plain request: what JSON of a server, a campaign and options of a command line become.

use crate::apply::{ApplyData, ApplyJob};
use crate::bias::{BiasData, BiasJob};
use crate::certificate::{CertificateData, CertificateJob};
use crate::comparison::{ComparisonData, ComparisonJob};
use crate::convert::{ConvertData, ConvertJob};
use crate::deconvolution::{DeconvolutionData, DeconvolutionJob};
use crate::device_check::{DeviceCheckData, DeviceCheckJob};
use crate::device_plan::DevicePlanJob;
use crate::free_living::{FreeLivingJob, FreeLivingWindows};
use crate::inspect::{InspectData, InspectJob};
use crate::known_keys::known_keys;
use crate::linearity::{LinearityData, LinearityJob};
use crate::modes::{ModesData, ModesJob};
use crate::motion::{MotionData, MotionJob};
use crate::multi_position::{MultiPositionData, MultiPositionJob};
use crate::noise::{NoiseData, NoiseJob};
use crate::noise_comparison::{NoiseComparisonData, NoiseComparisonJob};
use crate::outcome::{Job, Outcome};
use crate::plan::PlanJob;
use crate::response::{ModelData, ModelJob, ResponseData, ResponseJob};
use crate::shaker_primary::{ShakerPrimaryData, ShakerPrimaryJob};
use crate::shaker_single::{ShakerSingleData, ShakerSingleJob};
use crate::shaker_triaxial::{ShakerTriaxialData, ShakerTriaxialJob};
use crate::shock::{ShockData, ShockJob};
use crate::simulate::SimulateJob;
use crate::spurious_motion::{SpuriousMotionData, SpuriousMotionJob};
use crate::static_test::{StaticTestData, StaticTestJob};
use crate::step::{StepData, StepJob};
use crate::store::Sink;
use crate::temperature::{TemperatureData, TemperatureJob};
use crate::transverse::{TransverseData, TransverseJob};
use crate::trouble::{Result, Trouble};
use crate::uncertainty::UncertaintyJob;
use crate::validation::{ValidationData, ValidationJob};
use crate::velocity::{
    AxisData, VelocityCompareJob, VelocityDriftJob, VelocityEstimateJob, VelocityIntegratorJob,
    VelocityMapJob, VelocityTuneJob,
};
use crate::{Record, StoredResult};
use proofmass_core::Watch;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Declares the requests, the data each takes, and the dispatch between them.
macro_rules! jobs {
    ($($(#[$doc:meta])* $name:ident($job:ty, $data:ty, $kind:literal, |$given:ident| $used:expr),)*) => {
        /// A request of any kind; in JSON it is the request itself with its kind as `job`.
        ///
        /// ```
        /// use proofmass_jobs::{AnyData, AnyJob, Record, Unwatched};
        ///
        /// use proofmass_jobs::uncertainty::UncertaintyJob;
        ///
        /// let model = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
        ///              [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2 * m\"\n";
        /// let request = UncertaintyJob { model: proofmass_documents::read_model(model).unwrap(), ..Default::default() };
        /// let text = AnyJob::from(request).to_json()?;
        /// assert!(text.contains("\"job\": \"uncertainty\""));
        /// // What a server does with such a text.
        /// let job = AnyJob::from_json(text.as_bytes())?;
        /// let result = job.evaluate(&AnyData::None, Record::default(), &Unwatched)?;
        /// assert_eq!(result.kind(), "uncertainty");
        /// assert_eq!(result.quantities()[0].value, 4.0);
        /// # Ok::<(), proofmass_jobs::Trouble>(())
        /// ```
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "job")]
        #[non_exhaustive]
        pub enum AnyJob {
            $($(#[$doc])* #[serde(rename = $kind)] $name(Box<$job>),)*
        }

        /// The data of a job of any kind.
        #[non_exhaustive]
        pub enum AnyData<'a> {
            /// For jobs that need none.
            None,
            /// An axis with encoder and accelerometer.
            Axis(AxisData<'a>),
            /// Runs of a triaxial accelerometer on a shaker.
            ShakerTriaxial(ShakerTriaxialData<'a>),
            /// Runs of a comparison.
            ShakerSingle(ShakerSingleData<'a>),
            /// Runs against an interferometer.
            ShakerPrimary(ShakerPrimaryData<'a>),
            /// Runs of a transverse test.
            Transverse(TransverseData<'a>),
            /// Runs of a vibrometer.
            SpuriousMotion(SpuriousMotionData<'a>),
            /// Outputs of an accelerometer in many positions.
            MultiPosition(MultiPositionData<'a>),
            /// Still moments of a logger.
            FreeLiving(&'a FreeLivingWindows),
            /// A calibration and new standstills.
            Validation(ValidationData<'a>),
            /// A calibration and a recording to be compensated.
            Apply(ApplyData<'a>),
            /// Recordings to be written in another format.
            Convert(ConvertData<'a>),
            /// A recording to be looked at.
            Inspect(InspectData),
            /// A sensor at rest over a sweep of temperature.
            Temperature(TemperatureData<'a>),
            /// A recording with rests in known attitudes.
            Bias(BiasData<'a>),
            /// Readings, a recording, a calibration or calibrations of a static test.
            StaticTest(StaticTestData<'a>),
            /// Where simulated files go.
            Sink(&'a dyn Sink),
            /// A sensor at rest.
            Noise(NoiseData<'a>),
            /// Noise results of several units.
            NoiseComparison(NoiseComparisonData<'a>),
            /// Results of devices.
            DeviceCheck(DeviceCheckData<'a>),
            /// A mesh, or nothing for a wedge by its dimensions.
            Modes(ModesData<'a>),
            /// A recorded shock.
            Shock(ShockData<'a>),
            /// Recorded inputs and outputs.
            Response(ResponseData<'a>),
            /// Points of a frequency response.
            TransducerModel(ModelData<'a>),
            /// A recorded step.
            Step(StepData<'a>),
            /// Amplitudes over levels.
            Levels(LinearityData<'a>),
            /// A recorded acceleration.
            Motion(MotionData<'a>),
            /// Two calibrations of one device.
            Comparison(ComparisonData<'a>),
            /// An output and the model behind it.
            Deconvolution(DeconvolutionData<'a>),
            /// A result to be certified.
            Certificate(CertificateData<'a>),
        }

        /// The keys of the request of a kind, where they are known.
        fn keys_of(kind: &str) -> Option<&'static [&'static str]> {
            match kind {
                $($kind => known_keys::<$job>(),)*
                _ => None,
            }
        }

        /// The schema of each request.
        #[cfg(feature = "schema")]
        pub(crate) fn request_schemas() -> Vec<(&'static str, crate::schema::Readable)> {
            vec![$(($kind, crate::schema::Readable::request::<$job>())),*]
        }

        impl AnyJob {
            /// Every kind, as `job` in JSON.
            pub const KINDS: &'static [&'static str] = &[$($kind),*];

            /// Kind of the request, as `job` in JSON.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $kind,)*
                }
            }

            /// Answers the question; the result is filed with `record`.
            ///
            /// # Errors
            /// Data of another job; else as the job.
            pub fn evaluate(
                &self,
                data: &AnyData<'_>,
                record: Record,
                watch: &dyn Watch,
            ) -> Result<StoredResult> {
                match self {
                    $(Self::$name(job) => {
                        let data: Option<&<$job as Job>::Data<'_>> = {
                            let $given = data;
                            $used
                        };
                        let data = data.ok_or_else(|| self.needs(stringify!($data)))?;
                        let outcome = job.answer(data, &record.inputs, watch)?;
                        StoredResult::new(record, &outcome)
                    })*
                }
            }
        }

        /// Every kind of result, as `kind` in result.json; two jobs may share one.
        pub fn result_kinds() -> Vec<&'static str> {
            let mut kinds: Vec<&str> = Vec::new();
            for kind in [$(<$job as Job>::Outcome::KIND),*] {
                if !kinds.contains(&kind) {
                    kinds.push(kind);
                }
            }
            kinds
        }

        $(impl From<$job> for AnyJob {
            fn from(job: $job) -> Self {
                Self::$name(Box::new(job))
            }
        })*
    };
}

/// The data inside, where it is that of the variant.
macro_rules! only {
    ($given:ident, $variant:ident) => {
        match $given {
            AnyData::$variant(data) => Some(data),
            _ => None,
        }
    };
}

/// No data at all.
const NOTHING: &() = &();

fn nothing<'a>(given: &AnyData<'_>) -> Option<&'a ()> {
    matches!(given, AnyData::None).then_some(NOTHING)
}

jobs! {
    /// Bias, scale and misalignment of a triaxial accelerometer from many positions.
    MultiPosition(MultiPositionJob, MultiPositionData, "multi-position", |d| only!(d, MultiPosition)),
    /// The same from the still moments of a logger.
    FreeLiving(FreeLivingJob, FreeLivingWindows, "free-living", |d| only!(d, FreeLiving)),
    /// A triaxial accelerometer on a shaker.
    ShakerTriaxial(ShakerTriaxialJob, ShakerTriaxialData, "shaker-triaxial", |d| only!(d, ShakerTriaxial)),
    /// A single-axis accelerometer against a reference.
    ShakerSingle(ShakerSingleJob, ShakerSingleData, "shaker-single", |d| only!(d, ShakerSingle)),
    /// A single-axis accelerometer against a laser interferometer.
    ShakerPrimary(ShakerPrimaryJob, ShakerPrimaryData, "shaker-primary", |d| only!(d, ShakerPrimary)),
    /// The transverse sensitivity of a single-axis accelerometer.
    Transverse(TransverseJob, TransverseData, "transverse-sensitivity", |d| only!(d, Transverse)),
    /// Motion of table and wedges beside the excitation.
    SpuriousMotion(SpuriousMotionJob, SpuriousMotionData, "spurious-motion", |d| only!(d, SpuriousMotion)),
    /// A plan of configurations.
    Plan(PlanJob, (), "plan", |d| nothing(d)),
    /// A calibration on standstills it was not made from.
    Validation(ValidationJob, ValidationData, "validation", |d| only!(d, Validation)),
    /// A recording compensated with a calibration.
    Apply(ApplyJob, ApplyData, "apply", |d| only!(d, Apply)),
    /// Recordings written in another format.
    Convert(ConvertJob, ConvertData, "convert", |d| only!(d, Convert)),
    /// What is in a recording.
    Inspect(InspectJob, InspectData, "inspect", |d| only!(d, Inspect)),
    /// Noise of sensors at rest.
    Noise(NoiseJob, NoiseData, "noise", |d| only!(d, Noise)),
    /// Noise of several units, held against each other and against limits.
    NoiseComparison(NoiseComparisonJob, NoiseComparisonData, "noise-comparison", |d| only!(d, NoiseComparison)),
    /// Devices, held against their data sheet.
    DeviceCheck(DeviceCheckJob, DeviceCheckData, "device-check", |d| only!(d, DeviceCheck)),
    /// What to measure for a data sheet, and for how long.
    DevicePlan(DevicePlanJob, (), "device-plan", |d| nothing(d)),
    /// Velocity of an axis.
    VelocityEstimate(VelocityEstimateJob, AxisData, "velocity-estimate", |d| only!(d, Axis)),
    /// Methods of velocity estimation side by side.
    VelocityCompare(VelocityCompareJob, AxisData, "velocity-compare", |d| only!(d, Axis)),
    /// Parameters of velocity estimation.
    VelocityTune(VelocityTuneJob, AxisData, "velocity-tune", |d| only!(d, Axis)),
    /// Errors of an encoder that repeat with its reading.
    VelocityMap(VelocityMapJob, AxisData, "velocity-map", |d| only!(d, Axis)),
    /// What a velocity from an accelerometer alone drifts.
    VelocityDrift(VelocityDriftJob, (), "velocity-drift", |d| nothing(d)),
    /// Which integration rule and which high-pass a velocity from an accelerometer needs.
    VelocityIntegrator(VelocityIntegratorJob, (), "velocity-integrator", |d| nothing(d)),
    /// Bias and scale over temperature.
    Temperature(TemperatureJob, TemperatureData, "temperature", |d| only!(d, Temperature)),
    /// The bias over a recording.
    Bias(BiasJob, BiasData, "bias", |d| only!(d, Bias)),
    /// Inclination, sensitivity, zero-g, orthogonality, linearity, centrifuge, stability.
    StaticTest(StaticTestJob, StaticTestData, "static-test", |d| only!(d, StaticTest)),
    /// Recordings whose truth is known.
    Simulate(SimulateJob, Sink, "simulate", |d| only!(d, Sink)),
    /// A model of measurement.
    Uncertainty(UncertaintyJob, (), "uncertainty", |d| nothing(d)),
    /// Modes of a wedge.
    Modes(ModesJob, ModesData, "modes", |d| only!(d, Modes)),
    /// A shock, alone or against a reference.
    Shock(ShockJob, ShockData, "shock", |d| only!(d, Shock)),
    /// A frequency response from noise, blows or a sweep.
    Response(ResponseJob, ResponseData, "response", |d| only!(d, Response)),
    /// A model fitted to points of a frequency response.
    TransducerModel(ModelJob, ModelData, "transducer-model", |d| only!(d, TransducerModel)),
    /// A step response.
    Step(StepJob, StepData, "step", |d| only!(d, Step)),
    /// Linearity over the level.
    Levels(LinearityJob, LinearityData, "levels", |d| only!(d, Levels)),
    /// Figures of a recorded acceleration.
    Motion(MotionJob, MotionData, "motion", |d| only!(d, Motion)),
    /// Two calibrations over frequency, held against each other.
    Comparison(ComparisonJob, ComparisonData, "comparison", |d| only!(d, Comparison)),
    /// A certificate of a result.
    Certificate(CertificateJob, CertificateData, "certificate", |d| only!(d, Certificate)),
    /// The input behind an output.
    Deconvolution(DeconvolutionJob, DeconvolutionData, "deconvolution", |d| only!(d, Deconvolution)),
}

/// Refuses a key that the request of a kind does not have.
fn unknown_key(given: &Map<String, Value>, kind: &str) -> Result<()> {
    if !AnyJob::KINDS.contains(&kind) {
        let near = proofmass_io::spelling::nearest(kind, AnyJob::KINDS.iter().copied());
        let near = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let all = AnyJob::KINDS.join(", ");
        return Err(
            Trouble::request(format!("there is no job of kind `{kind}`"))
                .with_hint(format!("{near}`job` is one of {all}")),
        );
    }
    let Some(keys) = keys_of(kind) else {
        return Ok(());
    };
    let Some(unknown) = given
        .keys()
        .find(|k| *k != "job" && !keys.contains(&k.as_str()))
    else {
        return Ok(());
    };
    let near = proofmass_io::spelling::nearest(unknown, keys.iter().copied());
    let near = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    Err(
        Trouble::request(format!("a job of kind `{kind}` has no key `{unknown}`"))
            .with_hint(format!("{near}its keys are {}", keys.join(", "))),
    )
}

impl AnyJob {
    fn needs(&self, data: &str) -> Trouble {
        Trouble::request(format!(
            "the data are not those of a job of kind `{}`",
            self.kind()
        ))
        .with_hint(match data {
            "()" => "it needs none".to_owned(),
            name => format!("give it {name}"),
        })
    }

    /// Reads a request.
    ///
    /// # Errors
    /// An unknown kind (with the known ones), a key or a value that the job does not have (with the nearest key).
    pub fn from_json(bytes: &[u8]) -> Result<Self> {
        let read = |bytes| serde_json::from_slice::<Map<String, Value>>(bytes);
        if let Ok(given) = read(bytes)
            && let Some(kind) = given.get("job").and_then(Value::as_str)
        {
            unknown_key(&given, kind)?;
        }
        serde_json::from_slice(bytes).map_err(|e| {
            Trouble::request(format!("the request cannot be read: {e}"))
                .with_hint(format!("`job` is one of {}", Self::KINDS.join(", ")))
        })
    }

    /// The request as JSON.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn to_json(&self) -> Result<String> {
        proofmass_io::finite::to_json(self)
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .map_err(Trouble::from)
    }
}
