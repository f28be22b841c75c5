//! The questions to an axis.

use crate::agreement::{check, figure};
use crate::ask;
use proofmass_jobs::velocity::{
    AxisData, VelocityCompareJob, VelocityDriftJob, VelocityEstimateJob, VelocityIntegratorJob,
    VelocityMapJob, VelocityTuneJob,
};
use proofmass_jobs::{AnyData, AnyJob, StoredResult};
use proofmass_motion::{
    DriftSources, EncoderAiding, IntegratorTask, Method, MotionRecord, ReadingSource,
};
use proofmass_rig::{AxisMotion, DrivenAxis};

fn walk(kind: &str, job: impl Into<AnyJob>) -> StoredResult {
    let mut axis = DrivenAxis::new(AxisMotion::servo(5.0));
    axis.duration = 2.0;
    let recording = axis.simulate(1).expect("an axis");
    let mut motion = MotionRecord::new(
        recording.sample_time,
        ReadingSource::Position,
        recording.position(),
        recording.acceleration.clone(),
    )
    .expect("a record");
    motion.increment = Some(recording.increment);
    let truth: Vec<f64> = recording.truth.iter().map(|p| p.velocity).collect();
    let job = job.into();
    check(kind, &|watch| {
        let data = AnyData::Axis(AxisData {
            reference: Some(&truth),
            ..AxisData::new(&motion)
        });
        ask(job.clone(), &data, watch)
    })
}

pub fn velocity_estimate(kind: &str) {
    walk(kind, VelocityEstimateJob::default());
}

pub fn velocity_compare(kind: &str) {
    let methods = vec![
        Method::FixedTime,
        "observer:10,100".parse().expect("a method"),
    ];
    let result = walk(
        kind,
        VelocityCompareJob::new(methods, vec![1000.0, 100.0], Some(0.5)),
    );
    figure(&result, "errors.csv", 0, "rms_m/s");
}

pub fn velocity_map(kind: &str) {
    // As of a wheel of one centimetre.
    let turn = std::f64::consts::TAU * 0.01;
    walk(kind, VelocityMapJob::new(turn));
}

pub fn velocity_drift(kind: &str) {
    let sources = DriftSources {
        offset: 0.01,
        orientation_uncertainty: 2e-3,
        noise: 0.02,
        sample_time: 1e-3,
        flicker: 1e-4,
        walk: 1e-5,
        rest: 5.0,
        ..DriftSources::default()
    };
    let mut job = VelocityDriftJob::new(sources, vec![1.0, 10.0]);
    job.upper = Some(DriftSources {
        walk: 2e-5,
        ..sources
    });
    job.encoder = Some(EncoderAiding {
        increment: 1e-3,
        rate: 500.0,
        scale_uncertainty: 1e-3,
        walk: 1e-3,
    });
    job.sources.speed = 1.0;
    check(kind, &|watch| ask(job.clone(), &AnyData::None, watch));
}

pub fn velocity_integrator(kind: &str) {
    let task = IntegratorTask {
        band: [2.0, 40.0],
        rate: 200.0,
        bias: 0.02,
        noise: 0.05,
        speed: 0.5,
        duration: 60.0,
    };
    let mut job = VelocityIntegratorJob::new(task);
    job.allowed = Some(0.01);
    check(kind, &|watch| ask(job, &AnyData::None, watch));
}

pub fn velocity_tune(kind: &str) {
    walk(kind, VelocityTuneJob::default());
}
