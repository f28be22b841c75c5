//! Jobs of every kind, from memory alone: answered, stopped, the request as JSON, the result written, read and rendered
//! again, and its principal result the same wherever it is stated. A kind without a row fails the last test.

mod agreement;
mod axis;
mod calibrations;
mod certificates;
mod dynamic;
mod models;
mod statements;
mod static_tests;
#[path = "../support/mod.rs"]
mod support;
mod tables;

use proofmass_jobs::plan::PlanJob;
use proofmass_jobs::{
    AnyData, AnyJob, Gathered, StoredResult, Trouble, TroubleKind, Unwatched, Watch, result_kinds,
};
use std::collections::BTreeSet;
use support::record;

type Answer = Result<StoredResult, Trouble>;

/// One test for each kind of job, and the list of them.
macro_rules! walk {
    ($($test:ident: $job:literal => $result:literal in $room:ident;)*) => {
        const WALKED: &[(&str, &str)] = &[$(($job, $result)),*];

        mod law_every_kind {
            $(#[test]
            #[allow(clippy::let_unit_value)] // some give the result on
            fn $test() {
                let _ = super::$room::$test($result);
                super::tables::law_page($job, $result);
            })*
        }
    };
}

walk! {
    multi_position: "multi-position" => "multi-position" in calibrations;
    free_living: "free-living" => "free-living" in calibrations;
    shaker_triaxial: "shaker-triaxial" => "shaker-triaxial" in calibrations;
    shaker_single: "shaker-single" => "shaker-single" in calibrations;
    shaker_primary: "shaker-primary" => "shaker-primary" in calibrations;
    transverse: "transverse-sensitivity" => "transverse-sensitivity" in calibrations;
    spurious_motion: "spurious-motion" => "spurious-motion" in calibrations;
    validation: "validation" => "validation" in calibrations;
    apply: "apply" => "apply" in calibrations;
    temperature: "temperature" => "temperature" in calibrations;
    bias: "bias" => "bias" in calibrations;
    plan: "plan" => "plan" in models;
    inspect: "inspect" => "inspect" in models;
    convert: "convert" => "convert" in models;
    noise: "noise" => "noise" in models;
    noise_comparison: "noise-comparison" => "noise-comparison" in models;
    device_check: "device-check" => "device-check" in models;
    device_plan: "device-plan" => "device-plan" in models;
    simulate: "simulate" => "simulate" in models;
    uncertainty: "uncertainty" => "uncertainty" in models;
    modes: "modes" => "modes" in models;
    velocity_estimate: "velocity-estimate" => "velocity-estimate" in axis;
    velocity_compare: "velocity-compare" => "velocity-comparison" in axis;
    velocity_map: "velocity-map" => "velocity-map" in axis;
    velocity_drift: "velocity-drift" => "velocity-drift" in axis;
    velocity_integrator: "velocity-integrator" => "velocity-integrator" in axis;
    velocity_tune: "velocity-tune" => "velocity-tuning" in axis;
    static_test: "static-test" => "static-test" in static_tests;
    shock: "shock" => "shock" in dynamic;
    response: "response" => "frequency-response-test" in dynamic;
    transducer_model: "transducer-model" => "frequency-response-test" in dynamic;
    step: "step" => "step" in dynamic;
    levels: "levels" => "level-linearity" in dynamic;
    motion: "motion" => "motion" in dynamic;
    comparison: "comparison" => "comparison" in calibrations;
    certificate: "certificate" => "certificate" in certificates;
    deconvolution: "deconvolution" => "deconvolution" in dynamic;
}

#[test]
fn law_no_kind_is_left_out() {
    let set = |kinds: &[&'static str]| kinds.iter().copied().collect::<BTreeSet<_>>();
    let (jobs, results): (Vec<_>, Vec<_>) = WALKED.iter().copied().unzip();
    assert_eq!(set(&jobs), set(AnyJob::KINDS));
    assert_eq!(set(&results), set(&result_kinds()));
}

/// A request goes through JSON before it is answered.
fn ask(job: impl Into<AnyJob>, data: &AnyData<'_>, watch: &dyn Watch) -> Answer {
    let job: AnyJob = job.into();
    let text = job.to_json()?;
    let again = AnyJob::from_json(text.as_bytes())?;
    assert_eq!(again, job, "{}", job.kind());
    assert!(WALKED.iter().any(|(walked, _)| *walked == job.kind()));
    again.evaluate(data, record(), watch)
}

#[test]
fn refuses_data_of_another_job_and_requests_of_no_job() {
    let job = AnyJob::from(PlanJob::new(models::budget()));
    let sink = Gathered::default();
    let Err(trouble) = job.evaluate(&AnyData::Sink(&sink), record(), &Unwatched) else {
        panic!("a plan from a sink");
    };
    assert_eq!(trouble.kind(), TroubleKind::Request);
    for text in [
        "",
        "{}",
        "[]",
        "{\"job\": \"plan\"}",
        "{\"job\": \"noise\", \"alpha\": }",
        "{\"job\": 7}",
    ] {
        let trouble = AnyJob::from_json(text.as_bytes()).expect_err("a refusal");
        assert!(trouble.hint().is_some_and(|h| h.contains("multi-position")));
    }
}
