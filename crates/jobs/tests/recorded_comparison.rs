//! A comparison on the shaker from its recordings, through the campaign: noise of a few runs, and channels that are cut off.

use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::shaker_single::ShakerSingleOutcome;
use proofmass_jobs::{Job, Outcome, Unwatched};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::path::Path;

const RATE: f64 = 10_000.0;

/// 160 Hz on a reference and a device of 10 mV/(m/s²) each, the device 0.3 rad behind.
fn channels(amplitude: f64, noise: f64, rng: &mut Xoshiro256PlusPlus) -> [Vec<f64>; 2] {
    let start: f64 = StandardNormal.sample(rng);
    [0.0, 0.3].map(|behind| {
        (0..2000)
            .map(|k| {
                let e: f64 = StandardNormal.sample(rng);
                amplitude * (TAU * 160.0 * f64::from(k) / RATE + start - behind).cos() + noise * e
            })
            .collect()
    })
}

fn calibrated(folder: &Path, runs: &[[Vec<f64>; 2]], full_scale: &str) -> ShakerSingleOutcome {
    let campaign = format!(
        "kind = \"shaker-single\"\n[runs]\nfile = \"runs.csv\"\n[recording]\nformat = \"f32\"\nsampling_rate_Hz = {RATE}\n\
         {full_scale}channels = {{ reference = 1, output = 2 }}\n[reference]\nfile = \"reference.csv\"\nk = 2\n\
         [reading]\nu_relative = 1e-5\nu_phase_deg = 1e-3\n"
    );
    std::fs::write(folder.join("campaign.toml"), campaign).expect("written");
    let certificate = "frequency_Hz,sensitivity_mV/(m/s2),phase_deg,U_relative_%,U_phase_deg\n\
                       10,10,0,0.002,0.002\n1000,10,0,0.002,0.002\n";
    std::fs::write(folder.join("reference.csv"), certificate).expect("written");
    let mut table = "run,frequency_Hz,transverse_%,file\n".to_owned();
    for (i, [x, y]) in runs.iter().enumerate() {
        let both = x.iter().zip(y).flat_map(|(x, y)| [*x as f32, *y as f32]);
        let bytes: Vec<u8> = both.flat_map(f32::to_le_bytes).collect();
        std::fs::write(folder.join(format!("r{i}.f32")), bytes).expect("written");
        table += &format!("r{i},160,1,r{i}.f32\n");
    }
    std::fs::write(folder.join("runs.csv"), table).expect("written");
    let Ok(Campaign::ShakerSingle(campaign)) = Campaign::open(folder) else {
        panic!("a campaign");
    };
    let files = campaign.load(&Unwatched).expect("the recordings");
    files
        .job
        .evaluate(&files.data(), &Unwatched)
        .expect("an outcome")
}

fn codes(outcome: &ShakerSingleOutcome) -> Vec<&str> {
    outcome.findings().iter().map(|f| f.code()).collect()
}

#[test]
fn known_cut_channels_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let whole = channels(0.1, 1e-4, &mut rng);
    let cut = |sides: [f64; 2]| {
        let [x, y] = &whole;
        [x, y].map(|c| c.iter().map(|v| v.clamp(sides[0], sides[1])).collect())
    };
    for full_scale in ["", "full_scale_V = 1\n"] {
        let outcome = calibrated(folder.path(), std::slice::from_ref(&whole), full_scale);
        assert!(!codes(&outcome).contains(&"clipped"));
        // Both at one voltage, where both lose alike and the ratio tells nothing; and one on one side.
        for sides in [[-0.09, 0.09], [-1.0, 0.09]] {
            let outcome = calibrated(folder.path(), &[cut(sides)], full_scale);
            assert!(
                codes(&outcome).contains(&"clipped"),
                "{sides:?} {full_scale}"
            );
        }
    }
}

#[test]
fn coverage_of_a_few_noisy_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    for runs in [1, 2, 3] {
        let (mut held, mut all) = (0u32, 0u32);
        let mut doubted = 0;
        for (noise, seeds) in [(0.01, 60), (0.02, 60), (0.07, 60)] {
            for seed in 0..seeds {
                let mut rng =
                    Xoshiro256PlusPlus::seed_from_u64(100_000 * runs + (1e6 * noise) as u64 + seed);
                let runs: Vec<_> = (0..runs).map(|_| channels(0.1, noise, &mut rng)).collect();
                let outcome = calibrated(folder.path(), &runs, "full_scale_V = 1\n");
                doubted += u32::from(codes(&outcome).contains(&"scatter-exceeds-reading"));
                for (q, truth) in outcome.quantities().iter().zip([0.01, -0.3]) {
                    all += 1;
                    held += u32::from((q.value - truth).abs() <= q.expanded);
                }
            }
        }
        // 360 intervals of modulus and phase of one run, 95 % within three standard deviations of the binomial; of repeats U is the
        // larger of what noise and scatter say.
        let share = f64::from(held) / f64::from(all);
        assert!(share > 0.915, "{runs}: {share}");
        assert!(runs > 1 || share < 0.985, "{share}");
        assert_eq!(doubted, 0, "{runs}");
    }
}
