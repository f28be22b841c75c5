//! Kills, two writers, flipped bits: short forms of `--example survival`.

use crate::places::{each, make, new_database};
use crate::recorded::*;
use proofmass_records::*;

#[test]
fn law_two_writers_lose_nothing() {
    each(|place, _| {
        drop(make(place));
        let writers: Vec<_> = (0..2)
            .map(|writer| {
                let place = place.to_owned();
                std::thread::spawn(move || {
                    let mut records = Records::open_to_add(&place).unwrap();
                    for k in 0..60 {
                        let name = format!("{writer}-{k}");
                        file(
                            &mut records,
                            &candidate(&name, "2026-01-01", 1.0, 0.01, 0.005),
                            None,
                        );
                    }
                })
            })
            .collect();
        writers.into_iter().for_each(|w| w.join().unwrap());
        let mut records = Records::open(place).unwrap();
        assert_eq!(records.devices(false).unwrap().len(), 120);
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_one_flipped_bit_is_found_or_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("lab.records");
    let mut records = make(place.to_str().unwrap());
    let campaign = campaign(folder.path());
    records
        .add_result(&campaign.join("result"), &filing(), TODAY)
        .unwrap();
    for k in 0..10 {
        file(
            &mut records,
            &candidate(
                &k.to_string(),
                "2026-01-01",
                1.0 + 0.1 * f64::from(k),
                0.01,
                0.005,
            ),
            None,
        );
    }
    let copy = folder.path().join("copy");
    records.backup(&copy).unwrap();
    let json = records.export_json().unwrap();
    let good = std::fs::read(&copy).unwrap();
    let (mut found, mut harmless) = (0, 0);
    for trial in 0..40_usize {
        let at = trial * 7919 * 31 % good.len();
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (trial % 8);
        std::fs::write(&copy, &bytes).unwrap();
        let told = Records::open(copy.to_str().unwrap())
            .and_then(|mut r| Ok((r.check()?, r.export_json())));
        match told {
            Err(_) => found += 1,
            Ok((check, _)) if !check.is_whole() => found += 1,
            Ok((_, read)) => {
                assert_eq!(
                    read.unwrap(),
                    json,
                    "byte {at} is changed and nobody says it"
                );
                harmless += 1;
            }
        }
    }
    println!("{found} of 40 flipped bits found, {harmless} harmless");
    // Most of the file is free pages and the page of the result, which nobody reads back; some are hit that matter.
    assert!(found > 10, "{found}");
}

#[test]
fn law_a_flipped_bit_on_the_server_is_found() {
    let Some(url) = new_database() else { return };
    let mut records = make(&url);
    file(
        &mut records,
        &candidate("1", "2026-01-01", 1.0, 0.01, 0.005),
        None,
    );
    let mut client = postgres::Client::connect(&url, postgres::NoTls).unwrap();
    for (change, back) in [
        (
            "UPDATE quantity SET value = value + 1e-15",
            "UPDATE quantity SET value = 1.0",
        ),
        (
            "UPDATE entry SET body = replace(body, 'maker', 'Maker') WHERE number = 1",
            "UPDATE entry SET body = replace(body, 'Maker', 'maker') WHERE number = 1",
        ),
        (
            "UPDATE result SET kind = 'shaker-triple'",
            "UPDATE result SET kind = 'shaker-single'",
        ),
    ] {
        assert!(records.check().unwrap().is_whole());
        client.batch_execute(change).unwrap();
        assert!(!records.check().unwrap().is_whole(), "{change}");
        client.batch_execute(back).unwrap();
    }
}
