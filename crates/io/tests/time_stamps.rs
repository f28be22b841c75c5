//! The rate behind time stamps that are rounded, huge, scattered, in bursts, wrapped.

use proofmass_io::{ColumnRef, Error, Recording, RecordingOptions, Result, Source, inspect_source};
use std::fmt::Write;

fn read(text: &str) -> Result<Recording> {
    let options = RecordingOptions {
        columns: vec!["a".into()],
        time: Some(ColumnRef::Index(1)),
        ..RecordingOptions::default()
    };
    Recording::from_source(Source::from_bytes("r.csv", text).unwrap(), &options)
}

fn table(heading: &str, stamps: impl Iterator<Item = String>) -> String {
    let mut text = format!("{heading},a\n");
    for (i, t) in stamps.enumerate() {
        let _ = writeln!(text, "{t},{}", i % 7);
    }
    text
}

fn codes(recording: &Recording) -> Vec<&str> {
    recording.findings().iter().map(|f| f.code()).collect()
}

/// Uniform numbers in 0..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.next()).ln()).sqrt() * (std::f64::consts::TAU * self.next()).cos()
    }
}

/// Rates whose period is no whole number of the last digit: the median step is off by up to a third.
#[test]
fn regress_rates_behind_rounded_and_huge_stamps() {
    let epoch = 1_700_000_000_123_456_789_i128;
    let seconds =
        |rate: f64, decimals: usize| move |i: usize| format!("{:.decimals$}", i as f64 / rate);
    let nanoseconds =
        |rate: f64| move |i: usize| (epoch + (i as f64 * 1e9 / rate).round() as i128).to_string();
    type Write = Box<dyn Fn(usize) -> String>;
    let cases: [(f64, f64, &str, Write); 8] = [
        (300.0, 1e-3, "t_s", Box::new(seconds(300.0, 3))),
        (512.0, 1e-3, "t_s", Box::new(seconds(512.0, 3))),
        (400.0, 1e-3, "t_s", Box::new(seconds(400.0, 3))),
        (800.0, 1e-3, "t_s", Box::new(seconds(800.0, 3))),
        (3000.0, 1e-4, "t_s", Box::new(seconds(3000.0, 4))),
        (1001.0, 1e-4, "t_s", Box::new(seconds(1001.0, 4))),
        (10_000.0, 1e-9, "time_ns", Box::new(nanoseconds(10_000.0))),
        (50_000.0, 1e-9, "time_ns", Box::new(nanoseconds(50_000.0))),
    ];
    for (rate, resolution, heading, stamp) in cases {
        let text = table(heading, (0..75_000).map(stamp));
        let inspection = inspect_source(
            Source::from_bytes("r", text.clone()).unwrap(),
            &RecordingOptions::default(),
            100,
        )
        .unwrap();
        let seen = inspection.time.unwrap();
        let recording = read(&text).unwrap();
        let clock = *recording.time.clock().unwrap();
        for (found, gaps) in [
            (seen.rate_hz, seen.gap_count),
            (recording.time.rate_hz(), recording.time.gaps().len() as u64),
        ] {
            assert!((found / rate - 1.0).abs() < 1e-6, "{rate}: {found}");
            assert_eq!(gaps, 0, "{rate}");
        }
        // What is stated about the rate holds it, and is worth stating.
        let error = (clock.rate_hz - rate).abs();
        assert!(
            error <= 4.0 * clock.rate_u_hz + 1e-12 * rate,
            "{rate}: {clock:?}"
        );
        assert!(clock.rate_u_hz < 2e-5 * rate, "{rate}: {clock:?}");
        if resolution == 1e-9 {
            // Every step is 100 µs or 20 µs: the resolution is that of the last digit.
            assert!((clock.resolution_s - 1e-9).abs() < 1e-15, "{clock:?}");
        } else {
            assert!(
                (clock.resolution_s / resolution - 1.0).abs() < 1e-9,
                "{clock:?}"
            );
            assert_eq!(codes(&recording), ["stamps-coarse"], "{rate}");
        }
    }
}

#[test]
fn law_nanoseconds_since_1970_lose_nothing() {
    // Irregular times a few microseconds apart: from zero, and since 1970.
    let mut random = Random(7);
    let mut at = 0_i128;
    let times: Vec<i128> = (0..5_000)
        .map(|_| {
            at += 4_000 + (2_000.0 * random.next()) as i128;
            at
        })
        .collect();
    let small = read(&table("t_ns", times.iter().map(|t| t.to_string()))).unwrap();
    let epoch = 1_700_000_000_000_000_000_i128;
    let large = read(&table(
        "t_ns",
        times.iter().map(|t| (t + epoch).to_string()),
    ))
    .unwrap();
    let as_seconds = table("t_s", times.iter().map(|t| format!("1700000000.{:09}", t)));
    let seconds = read(&as_seconds).unwrap();
    for i in 0..5_000 {
        let want = (times[i] - times[0]) as f64 * 1e-9;
        for (r, start) in [
            (&small, times[0] as f64 * 1e-9),
            (&large, 0.0),
            (&seconds, 0.0),
        ] {
            let got = r.time.seconds(i) - start;
            assert!(
                (got - want).abs() < 1e-15 + 1e-14 * want,
                "{i}: {got} {want}"
            );
        }
    }
    assert_eq!(large.time.origin().value(), (epoch + times[0]) as f64);
    // Relative to one another they are exact too.
    assert_eq!(seconds.time.offset_s(&seconds.time), 0.0);
    assert!(
        (large
            .time
            .at("1700000000.5", proofmass_io::DecimalMark::Point)
            .unwrap()
            - (0.5 - times[0] as f64 * 1e-9))
            .abs()
            < 1e-15
    );
}

#[test]
fn known_dates_with_times_and_units_since_1970() {
    let iso = table(
        "timestamp",
        (0..500).map(|i| format!("2026-03-29T00:59:{:02}.{:02}Z", 50 + i / 100 % 10, i % 100)),
    );
    let recording = read(&iso).unwrap();
    assert!((recording.time.rate_hz() - 100.0).abs() < 1e-9);
    assert_eq!(codes(&recording), [""; 0]);
    // Found without being named, quoted, and with a blank for the T.
    let found = inspect_source(
        Source::from_bytes(
            "r",
            iso.replace("2026-03-29T", "\"2026-03-29 ")
                .replace("Z,", "\","),
        )
        .unwrap(),
        &RecordingOptions::default(),
        100,
    )
    .unwrap();
    assert!((found.time.unwrap().rate_hz - 100.0).abs() < 1e-9);
    for (unit, per_second) in [("ms", 1_000_i64), ("us", 1_000_000), ("ns", 1_000_000_000)] {
        let stamps =
            (0..500).map(|i| (1_700_000_000 * per_second + i * per_second / 100).to_string());
        let recording = read(&table("timestamp", stamps)).unwrap();
        assert!((recording.time.rate_hz() - 100.0).abs() < 1e-9, "{unit}");
        assert_eq!(codes(&recording), ["time-unit-assumed"], "{unit}");
    }
}

#[test]
fn known_counters_that_begin_again_are_continued() {
    let micro = |i: u64| (4_294_000_000 + 1000 * i) % (1 << 32);
    let wrapped = read(&table("t_us", (0..5000).map(|i| micro(i).to_string()))).unwrap();
    assert!((wrapped.time.rate_hz() - 1000.0).abs() < 1e-9);
    assert!((wrapped.duration_s() - 5.0).abs() < 1e-9);
    assert_eq!(codes(&wrapped), ["clock-wrapped"]);
    // The same counter, exported in seconds.
    let seconds = table(
        "t_s",
        (0..5000).map(|i| format!("{:.6}", micro(i) as f64 * 1e-6)),
    );
    let seconds = read(&seconds).unwrap();
    assert!((seconds.duration_s() - 5.0).abs() < 1e-9);
    // Sixteen bits of milliseconds, twice.
    let milli = (0..15_000_u64).map(|i| ((60_000 + 10 * i) % (1 << 16)).to_string());
    let milli = read(&table("t_ms", milli)).unwrap();
    assert!((milli.duration_s() - 150.0).abs() < 1e-9);
    // A restart is none.
    let restart = (0..200_u64).map(|i| ((i % 100) * 10).to_string());
    let error: Error = read(&table("t_ms", restart)).unwrap_err();
    assert_eq!(error.line_number(), Some(102));
    assert!(error.to_string().contains("backwards"), "{error}");
}

#[test]
fn known_missing_samples_are_gaps_and_do_not_bend_the_rate() {
    for (rate, decimals) in [(100.0, 2), (100.0, 3), (800.0, 6), (300.0, 3)] {
        let mut taken = 0;
        let stamps = (0..20_000).map(|i| {
            // Lost: one sample, then ten, then a thousand.
            taken += match i {
                5_000 => 2,
                9_000 => 11,
                15_000 => 1001,
                _ => 1,
            };
            format!("{:.decimals$}", f64::from(taken) / rate)
        });
        let recording = read(&table("t_s", stamps)).unwrap();
        assert_eq!(recording.time.gaps().len(), 3, "{rate} {decimals}");
        assert_eq!(codes(&recording).last(), Some(&"gaps-in-record"));
        assert!(
            (recording.time.rate_hz() / rate - 1.0).abs() < 1e-6,
            "{rate}"
        );
    }
}

#[test]
fn known_bursts_lie_on_the_clock_line() {
    // Eight samples at 1 kHz are handed over together, up to 0.4 ms late.
    let mut random = Random(3);
    let mut late = 0.0;
    let stamps: Vec<String> = (0..40_000)
        .map(|i| {
            if i % 8 == 0 {
                late = 4e-4 * random.next();
            }
            format!("{:.6}", f64::from(i / 8 * 8 + 7) * 1e-3 + late)
        })
        .collect();
    let recording = read(&table("t_s", stamps.into_iter())).unwrap();
    assert_eq!(codes(&recording), ["stamps-in-bursts"]);
    let time = &recording.time;
    assert!(
        (time.rate_hz() / 1000.0 - 1.0).abs() < 1e-6,
        "{:?}",
        time.clock()
    );
    assert!(time.gaps().is_empty());
    for i in 1..40_000 {
        assert!((time.seconds(i) - time.seconds(i - 1) - 1e-3).abs() < 1e-9);
    }
    // Sampling finer than the stamps: 3 kHz in milliseconds.
    let fine = read(&table(
        "t_s",
        (0..30_000).map(|i| format!("{:.3}", f64::from(i) / 3000.0)),
    ))
    .unwrap();
    assert!((fine.time.rate_hz() / 3000.0 - 1.0).abs() < 1e-6);
    assert!((fine.time.seconds(3000) - 1.0).abs() < 1e-3);
    // A doubled row among healthy ones is none of this.
    let doubled = (0..1000).map(|i| format!("{:.2}", f64::from(i - i32::from(i > 500)) * 0.01));
    let error = read(&table("t_s", doubled)).unwrap_err();
    assert_eq!(error.line_number(), Some(503));
}

/// Scattered, rounded and drifting stamps of many clocks: how often value ± 2 u holds the rate.
#[test]
fn coverage_of_the_stated_uncertainty_of_the_rate() {
    let mut random = Random(11);
    let runs = 400;
    for kind in 0..4 {
        let mut held = 0;
        let mut relative = Vec::new();
        for _ in 0..runs {
            let rate = 90.0 + 20.0 * random.next();
            let n = 200 + (2000.0 * random.next()) as usize;
            let phase = random.next();
            let mut wander = 0.0;
            let stamps: Vec<String> = (0..n)
                .map(|i| {
                    let t = (i as f64 + phase) / rate;
                    match kind {
                        // Rounded to a third of a step, and to a thirtieth of a percent.
                        0 => format!("{t:.3}"),
                        1 => format!("{:.6}", (t * 3e2).round() / 3e2),
                        // Scattered by a hundredth of a step; scattered with memory.
                        2 => format!("{:.9}", t + 1e-4 * random.normal()),
                        _ => {
                            wander = 0.9 * wander + 1e-4 * random.normal();
                            format!("{:.9}", t + wander)
                        }
                    }
                })
                .collect();
            let recording = read(&table("t_s", stamps.into_iter())).unwrap();
            let clock = recording.time.clock().unwrap();
            held += u32::from((clock.rate_hz - rate).abs() <= 2.0 * clock.rate_u_hz);
            relative.push(clock.rate_u_hz / rate);
        }
        // 95 % of 400: 380 ± 4.4. Rounding errors repeat, so that the interval is wider than it has to be there.
        let least = 380 - 4 * 5;
        assert!(held >= least, "kind {kind}: {held} of {runs}");
        if kind >= 2 {
            assert!(
                held <= 398,
                "kind {kind}: {held} of {runs}, the interval is too wide"
            );
        }
        relative.sort_by(f64::total_cmp);
        println!(
            "kind {kind}: {held} of {runs} held, median u {:.1e}",
            relative[200]
        );
    }
}

/// Healthy recordings: jitter up to a tenth of a step, no loss, sane digits. Nothing may be doubted.
#[test]
fn law_healthy_stamps_raise_no_finding() {
    let mut random = Random(5);
    for _ in 0..200 {
        let rate = 10_f64.powf(1.0 + 3.0 * random.next());
        let jitter = 0.03 * random.next() / rate;
        let stamps: Vec<String> = (0..3000)
            .map(|i| {
                format!(
                    "{:.7}",
                    (f64::from(i) + 0.5) / rate + jitter * random.normal()
                )
            })
            .collect();
        let recording = read(&table("t_s", stamps.into_iter())).unwrap();
        assert_eq!(codes(&recording), [""; 0], "{rate} {jitter}");
    }
}

/// Stamps that differ in their digits but not in seconds since a far zero: found by mutation.
#[test]
fn regress_steps_that_vanish_so_far_from_zero_are_refused() {
    let stamps = [
        "0",
        "10",
        "20",
        "100000000000000000",
        "100000000000000000.5",
        "100000000000000001",
    ];
    let error = read(&table("t_s", stamps.iter().map(|s| (*s).to_owned()))).unwrap_err();
    assert!(error.to_string().contains("repeats"), "{error}");
}

/// Rows lost at random from 100 Hz in milliseconds, one in a hundred to one in three: gaps, not rounding.
#[test]
fn known_rows_lost_at_random_are_gaps() {
    let mut random = Random(9);
    for share in [0.01, 0.1, 0.33] {
        let kept = (0..30_000).filter(|k| *k == 0 || *k > 29_970 || random.next() >= share);
        let kept: Vec<u32> = kept.collect();
        let missing = 30_000 - kept.len() as u64;
        let text = table(
            "t_s",
            kept.iter().map(|k| format!("{:.3}", f64::from(*k) * 0.01)),
        );
        let seen = inspect_source(
            Source::from_bytes("r", text.clone()).unwrap(),
            &RecordingOptions::default(),
            100,
        )
        .unwrap();
        let seen = seen.time.unwrap();
        let recording = read(&text).unwrap();
        assert_eq!(seen.rate_hz, recording.time.rate_hz());
        assert!(
            (seen.rate_hz / 100.0 - 1.0).abs() < 1e-9,
            "{share}: {}",
            seen.rate_hz
        );
        assert_eq!(seen.clock.missing, missing, "{share}");
        assert_eq!(seen.gap_count, recording.time.gaps().len() as u64);
    }
}

/// Stamps that cross by jitter belong to the line like all others, whether a reader takes them or only looks.
#[test]
fn known_stamps_that_cross_do_not_shift_the_rate() {
    let mut random = Random(13);
    let stamps =
        (0..20_000).map(|k| format!("{:.6}", 1.0 + 0.01 * (f64::from(k) + 0.3 * random.normal())));
    let text = table("t_s", stamps);
    let seen = inspect_source(
        Source::from_bytes("r", text).unwrap(),
        &RecordingOptions::default(),
        100,
    )
    .unwrap();
    let time = seen.time.unwrap();
    // √12 · 0.3 / n^1.5 is one standard uncertainty.
    assert!(
        (time.rate_hz / 100.0 - 1.0).abs() < 5.0 * 3.7e-7,
        "{}",
        time.rate_hz
    );
    assert_eq!(time.gap_count, 0);
    assert!(time.clock.crossing > 100);
}

#[test]
fn known_two_rates_are_said() {
    let stamps = (0..20_000).map(|k| {
        format!(
            "{:.6}",
            0.01 * f64::from(k.min(12_000)) + 0.02 * f64::from((k - 12_000).max(0))
        )
    });
    let recording = read(&table("t_s", stamps)).unwrap();
    let change = recording.time.clock().unwrap().change.unwrap();
    assert!((change.before_hz / 100.0 - 1.0).abs() < 1e-3, "{change:?}");
    assert!((change.after_hz / 50.0 - 1.0).abs() < 1e-3, "{change:?}");
    assert!(codes(&recording).contains(&"rate-changes"));
}

/// What is seen of samples of 100 Hz whose stamps scatter by so many steps, with this share of the rows lost, and how many those are.
fn lossy(scatter: f64, share: f64) -> (proofmass_io::Inspection, u64) {
    let mut random = Random(17);
    let kept = (0..20_000).filter(|k| *k == 0 || *k == 19_999 || random.next() >= share);
    let kept: Vec<u32> = kept.collect();
    let stamps: Vec<String> = kept
        .iter()
        .map(|k| {
            format!(
                "{:.6}",
                1.0 + 0.01 * (f64::from(*k) + scatter * random.normal())
            )
        })
        .collect();
    let source = Source::from_bytes("r", table("t_s", stamps.into_iter())).unwrap();
    let seen = inspect_source(source, &RecordingOptions::default(), 10).unwrap();
    (seen, 20_000 - kept.len() as u64)
}

/// Stamps that scatter by a third of a step still show the grid behind them: how many rows are lost, but not where.
/// Where they scatter by half a step nothing shows it, and the rate is known no better than a loss would leave it.
#[test]
fn known_losses_beside_scattered_stamps_are_told() {
    for share in [0.05, 0.1] {
        let (seen, missing) = lossy(0.3, share);
        let clock = seen.time.unwrap().clock;
        let found: Vec<&str> = seen.findings.iter().map(|f| f.code()).collect();
        assert!(
            found.contains(&"rows-missing-somewhere"),
            "{share}: {found:?}"
        );
        // Those beside each other are told a few too few.
        let told = clock.missing as f64 / missing as f64;
        assert!((0.96..=1.0).contains(&told), "{missing}: {clock:?}");
        assert!((clock.rate_hz - 100.0).abs() < 3.0 * clock.rate_u_hz);

        let (seen, _) = lossy(0.5, share);
        let clock = seen.time.unwrap().clock;
        let found = seen.findings.iter().find(|f| f.code() == "rate-untested");
        assert!(found.is_some() && clock.untested, "{:?}", seen.findings);
        let error = (clock.rate_hz - 100.0).abs();
        assert!(error > 3.0 && error < 3.0 * clock.rate_u_hz, "{clock:?}");
    }
    for scatter in [0.3, 0.5] {
        let (healthy, _) = lossy(scatter, 0.0);
        assert!(healthy.findings.is_empty(), "{:?}", healthy.findings);
    }
}
