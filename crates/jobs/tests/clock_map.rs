//! A small part of the map of sampling rates (`examples/clock_map`): every kind of stamps, six recordings of each.

use proofmass_io::{RecordingOptions, Source, inspect_source};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus as Random;

#[path = "../examples/clock_map/stamps.rs"]
mod stamps;

use stamps::CELLS;

/// Errors lie within 1.96 u as often as normal ones, and none beyond 6 u; where u is large a finding tells why.
#[test]
fn coverage_of_rates_over_what_clocks_do() {
    let (mut all, mut within) = (0, 0);
    for cell in CELLS {
        for seed in 0..6 {
            let mut random = Random::seed_from_u64(seed ^ cell.seed());
            let (text, rate) = cell.recording(&mut random);
            let source = Source::from_bytes("r.csv", text).unwrap();
            let seen = inspect_source(source, &RecordingOptions::default(), 10).unwrap();
            let time = seen.time.unwrap();
            let off = (time.rate_hz - rate).abs() / time.clock.rate_u_hz;
            // A doubled row at the very end is not decided, which shifts rates that are known to 10⁻⁹.
            let little = (time.rate_hz / rate - 1.0).abs() < 1e-8;
            assert!(
                off < 6.0 || little,
                "{} {seed}: {off} u, {rate} Hz: {:?}",
                cell.name,
                time.clock
            );
            all += 1;
            within += u32::from(off <= 1.96);
            let told = seen.findings.iter().any(|f| f.code() == "rate-untested");
            assert!(
                told || time.clock.rate_u_hz < 1e-3 * rate,
                "{} {seed}: {:?}",
                cell.name,
                time.clock
            );
        }
    }
    // Four standard deviations of the binomial distribution below 95 %.
    let n = f64::from(all);
    let least = 0.95 * n - 4.0 * (0.95 * 0.05 * n).sqrt();
    assert!(f64::from(within) >= least, "{within} of {all}");
}
