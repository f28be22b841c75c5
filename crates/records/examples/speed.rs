//! How fast records are with 10⁵ calibrations of 10⁴ devices: adding, history, due list, recall, size.
//!
//! `cargo run --release -p proofmass-records --example speed [CALIBRATIONS] [DEVICES] [PLACE]`

use proofmass_records::*;
use proofmass_static::static_test::RecalibrationRule;
use std::time::Instant;

fn main() -> Result<(), proofmass_jobs::Trouble> {
    let argument = |i: usize| std::env::args().nth(i);
    let number = |i: usize, usual: i64| argument(i).and_then(|t| t.parse().ok()).unwrap_or(usual);
    let (calibrations, devices) = (number(1, 100_000), number(2, 10_000));
    let folder =
        std::env::temp_dir().join(format!("proofmass-records-speed-{}", std::process::id()));
    let _ = std::fs::create_dir_all(&folder);
    let place = argument(3).unwrap_or_else(|| folder.join("lab.records").display().to_string());
    let mut records = Records::open_or_make(&place)?;
    let today = "2026-06-01";
    let standard = |serial: &str| FiledDevice {
        serial: Some(serial.into()),
        standard: true,
        ..Default::default()
    };
    for k in 0..10 {
        let number = records.add(today, None, Content::Device(standard(&format!("R{k}"))))?;
        let certificate = FiledCertificate {
            standard: number,
            number: format!("C{k}"),
            valid_from: "2010-01-01".into(),
            u_relative: Some(0.0025),
            ..FiledCertificate::default()
        };
        records.add(today, None, Content::Certificate(certificate))?;
    }
    let rule = FiledRule {
        device: None,
        rule: RecalibrationRule::Fixed { months: 12.0 },
        tolerances: Vec::new(),
    };
    records.add(today, None, Content::Rule(rule))?;
    let first = day_of("2016-01-01")?;
    let began = Instant::now();
    for k in 0..calibrations {
        let quantity = |axis: &str| FiledQuantity {
            name: format!("S.{axis}"),
            unit: "V/(m/s²)".into(),
            value: 0.01 * (1.0 + 1e-4 * ((k * 7919) % 100) as f64),
            u: Some(3e-5),
            expanded: Some(6e-5),
            k: Some(2.0),
            u_standard: Some(2.5e-5),
            ..Default::default()
        };
        let candidate = Candidate {
            device: proofmass_documents::Device {
                serial: Some(format!("D{}", k % devices)),
                model: Some("A1".into()),
                ..Default::default()
            },
            kind: "shaker-single".into(),
            date: date_of(first + 3650 * k / calibrations),
            sha256: format!("{k:064x}"),
            source: "simulated".into(),
            quantities: ["x", "y", "z"].map(quantity).to_vec(),
            ..Default::default()
        };
        let filing = Filing {
            standard: vec![format!("R{}", k % 10)],
            ..Default::default()
        };
        records.file_candidate(&candidate, &filing, today)?;
    }
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "adding          {:8.0} results a second, one transaction each",
        calibrations as f64 / seconds
    );
    let mut told =
        |what: &str,
         ask: &mut dyn FnMut(&mut Records) -> Result<usize, proofmass_jobs::Trouble>| {
            let mut times = Vec::new();
            let mut count = 0;
            for _ in 0..5 {
                let began = Instant::now();
                count = ask(&mut records)?;
                times.push(1e3 * began.elapsed().as_secs_f64());
            }
            times.sort_by(f64::total_cmp);
            println!("{what:15} {:8.1} ms (median of 5), {count} rows", times[2]);
            Ok::<(), proofmass_jobs::Trouble>(())
        };
    told("history", &mut |r| {
        let device = r.device("D77")?;
        Ok(r.history(device)?
            .iter()
            .map(|h| h.series.points.len())
            .sum())
    })?;
    told("due list", &mut |r| Ok(r.due(i64::MAX / 4)?.len()))?;
    let until = day_of(today)?;
    told("recall, a year", &mut |r| {
        let standard = r.device("R3")?;
        Ok(r.recall(standard, until, Some(until - 365), Some(0.01))?
            .results
            .len())
    })?;
    told("list", &mut |r| Ok(r.devices(false)?.len()))?;
    let began = Instant::now();
    let check = records.check()?;
    println!(
        "check           {:8.1} s, {} entries, whole: {}",
        began.elapsed().as_secs_f64(),
        check.entries,
        check.is_whole()
    );
    drop(records);
    if let Ok(size) = std::fs::metadata(&place) {
        println!("file            {:8.1} MB", size.len() as f64 / 1e6);
    }
    let _ = std::fs::remove_dir_all(&folder);
    Ok(())
}
