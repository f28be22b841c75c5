//! One campaign on the shaker whose recordings are raw floats, TDMS, WAV or MAT: the outcome is the same to the bit.

use crate::support::*;
use std::fs;
use std::path::{Path, PathBuf};

/// Channels of every recording: reference, x, y, z.
const CHANNELS: usize = 4;
const RATE: f64 = 12_800.0;
/// Of the acquisition: a power of two, so that fractions of it lose nothing.
const FULL_SCALE: f32 = 16.0;

/// The samples of a file of raw floats, sample by sample.
fn floats(path: &Path) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let (words, rest) = bytes.as_chunks::<4>();
    assert!(rest.is_empty());
    words.iter().map(|w| f32::from_le_bytes(*w)).collect()
}

fn channel(samples: &[f32], number: usize) -> impl Iterator<Item = f32> {
    samples.iter().skip(number).step_by(CHANNELS).copied()
}

fn tdms(samples: &[f32]) -> Vec<u8> {
    let word = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let (mut metadata, mut raw) = ((CHANNELS as u32).to_le_bytes().to_vec(), Vec::new());
    for number in 0..CHANNELS {
        metadata.extend(word(&format!("/'run'/'ai{number}'")));
        // Length of the index, single precision, one dimension.
        metadata.extend([20_u32, 9, 1].map(u32::to_le_bytes).concat());
        metadata.extend(((samples.len() / CHANNELS) as u64).to_le_bytes());
        metadata.extend(2_u32.to_le_bytes());
        metadata.extend(
            [
                word("unit_string"),
                0x20_u32.to_le_bytes().to_vec(),
                word("V"),
            ]
            .concat(),
        );
        metadata.extend([word("wf_increment"), 10_u32.to_le_bytes().to_vec()].concat());
        metadata.extend((1.0 / RATE).to_le_bytes());
        raw.extend(channel(samples, number).flat_map(f32::to_le_bytes));
    }
    let lengths = [metadata.len() + raw.len(), metadata.len()];
    let lengths = lengths.map(|n| (n as u64).to_le_bytes()).concat();
    [b"TDSm\x0e\0\0\0\x69\x12\0\0", &lengths[..], &metadata, &raw].concat()
}

fn wav(samples: &[f32]) -> Vec<u8> {
    let bytes = 4 * samples.len() as u32;
    let (rate, frame) = (RATE as u32, 4 * CHANNELS as u32);
    let mut file = [b"RIFF", &(36 + bytes).to_le_bytes()[..], b"WAVEfmt "].concat();
    file.extend(
        [
            16,
            3 | (CHANNELS as u32) << 16,
            rate,
            rate * frame,
            frame | 32 << 16,
        ]
        .map(u32::to_le_bytes)
        .concat(),
    );
    file.extend([&b"data"[..], &bytes.to_le_bytes()].concat());
    file.extend(samples.iter().flat_map(|v| (v / FULL_SCALE).to_le_bytes()));
    file
}

/// A matrix of single precision, a column for each channel (level 4).
fn mat(samples: &[f32]) -> Vec<u8> {
    let rows = (samples.len() / CHANNELS) as u32;
    let mut file = [10, rows, CHANNELS as u32, 0, 4]
        .map(u32::to_le_bytes)
        .concat();
    file.extend(b"run\0");
    for number in 0..CHANNELS {
        file.extend(channel(samples, number).flat_map(f32::to_le_bytes));
    }
    file
}

/// What was found, without the names and digests of the recordings.
fn outcome(campaign: &Path) -> serde_json::Value {
    let out = campaign.join("result");
    succeed(&["calibrate", text(campaign), "-o", text(&out)]);
    let mut result = json(&out.join("result.json"));
    let calibration = json(&out.join("calibration.json"));
    let members = result.as_object_mut().unwrap();
    for name in ["inputs", "extra"] {
        members.remove(name);
    }
    assert!(members["quantities"].as_array().unwrap().len() > 20);
    serde_json::json!([
        result["quantities"],
        result["findings"],
        calibration["K"],
        calibration["covariance"]
    ])
}

#[test]
fn law_the_format_of_the_recordings_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign");
    let rate = RATE.to_string();
    succeed(&[
        "simulate",
        "shaker",
        "-o",
        text(&campaign),
        "--frequencies",
        "80,160",
        "--sampling-rate",
        &rate,
        "--duration",
        "0.5",
        "--repeats",
        "2",
    ]);
    // It lists the recordings as they were simulated.
    fs::remove_file(campaign.join("manifest.json")).unwrap();
    let described = campaign.join("campaign.toml");
    let told = fs::read_to_string(&described).unwrap();
    let raw = format!("format = \"f32\"\nsampling_rate_Hz = {rate}\nfull_scale_V = 10\n");
    assert!(told.contains(&raw), "{told}");
    let runs: Vec<PathBuf> = names(&campaign)
        .iter()
        .filter(|name| name.ends_with(".f32"))
        .map(|name| campaign.join(name))
        .collect();
    let samples: Vec<Vec<f32>> = runs.iter().map(|run| floats(run)).collect();
    assert!(runs.len() > 6 && samples.iter().flatten().all(|v| v.abs() < FULL_SCALE));
    fs::write(
        &described,
        told.replace("full_scale_V = 10", "full_scale_V = 16"),
    )
    .unwrap();
    let wanted = outcome(&campaign);
    // The names of the files stay, and say nothing.
    for (format, written, settings) in [
        (
            "TDMS",
            tdms as fn(&[f32]) -> Vec<u8>,
            "full_scale_V = 16\n".to_owned(),
        ),
        ("WAV", wav, "full_scale_V = 16\n".to_owned()),
        (
            "MAT",
            mat,
            format!("sampling_rate_Hz = {rate}\nfull_scale_V = 16\nunit = \"V\"\n"),
        ),
    ] {
        for (run, samples) in runs.iter().zip(&samples) {
            fs::write(run, written(samples)).unwrap();
        }
        fs::write(&described, told.replace(&raw, &settings)).unwrap();
        assert_eq!(outcome(&campaign), wanted, "{format}");
    }
}
