//! Many sensors calibrated from the means of their standstills, on one core: time and error of a fit.
//!
//! A production line or a fleet has the means; what it wants is the whole answer for each sensor: parameters, joint
//! covariance, intervals with the scatter between standstills, and what there is to doubt.

use proofmass_core::{Gravity, Matrix3, SensorModel};
use proofmass_static::{Model, MultiPosition, Pose, Segment};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::time::Instant;

const SENSORS: usize = 10_000;
const MEANS: usize = 24;
const NOISE: f64 = 1e-3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    // Sum of twelve uniform numbers: near enough to normal for a bench.
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let gravity = Gravity::given(9.80665, 1e-5)?;
    let settings = MultiPosition::new(gravity)
        .model(Model::Triangular)
        .nominal_sensitivity(1.0)
        .output_unit("m/s²");
    let mut line: Vec<(SensorModel<f64>, Vec<Pose>)> = Vec::with_capacity(SENSORS);
    for _ in 0..SENSORS {
        let mut k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (i, row) in k.iter_mut().enumerate() {
            row[i..].iter_mut().for_each(|v| *v += 0.01 * normal());
        }
        let bias = [0.1 * normal(), 0.1 * normal(), 0.1 * normal()];
        let sensor = SensorModel::new(Matrix3(k), bias)?;
        let v = NOISE * NOISE;
        let poses = (0..MEANS)
            .map(|index| {
                let mut up = [0.0; 3];
                if index < 6 {
                    up[index / 2] = if index % 2 == 0 { 1.0 } else { -1.0 };
                } else {
                    up = [normal(), normal(), normal()];
                }
                let norm = proofmass_core::norm(up);
                let clean = sensor.invert(up.map(|u| 9.80665 * u / norm));
                let segment = Segment {
                    start: 400 * index,
                    end: 400 * (index + 1),
                    attitude: None,
                    force_uncertainty: None,
                    label: None,
                };
                Pose {
                    covariance: Some([[v, 0.0, 0.0], [0.0, v, 0.0], [0.0, 0.0, v]]),
                    time: Some(4.0 * index as f64),
                    ..Pose::reading(segment, clean.map(|c| c + 1.4 * NOISE * normal()))
                }
            })
            .collect();
        line.push((sensor, poses));
    }
    let start = Instant::now();
    let mut inside = 0usize;
    let mut findings = 0usize;
    for (sensor, poses) in &line {
        let fit = settings.fit(poses)?;
        findings += fit.misfits().iter().filter(|m| m.found).count();
        for (axis, name) in ["bias.x", "bias.y", "bias.z"].iter().enumerate() {
            let q = fit.quantity(name).ok_or("no such quantity")?;
            inside += usize::from((q.value - sensor.bias()[axis]).abs() <= q.expanded(0.95));
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{SENSORS} sensors x {MEANS} means: {seconds:.2} s, {:.0} sensors per second on one core; biases inside their \
         95 % intervals: {:.1} %; misfits found on healthy sensors: {findings}",
        SENSORS as f64 / seconds,
        100.0 * inside as f64 / (3 * SENSORS) as f64,
    );
    Ok(())
}
