//! Recordings written in another format and read again.

use proofmass_io::formats::{FORMATS, write::PARQUET};
use proofmass_io::{Input, Recording, RecordingOptions, Source, Unit};
use proofmass_jobs::convert::{
    ConvertData, ConvertFormat, ConvertJob, ConvertOutcome, DeviceTable, GapTreatment, Opening,
    WavSamples,
};
use proofmass_jobs::{Destination, Job, Trouble, TroubleKind, Unwatched};
use std::fmt::Write as _;
use std::path::Path;

fn job(to: ConvertFormat) -> ConvertJob {
    let mut job = ConvertJob::default();
    job.to = Some(to);
    job
}

/// Converts files in memory.
fn convert(job: &ConvertJob, files: &[&[u8]]) -> Result<(Vec<u8>, ConvertOutcome), Trouble> {
    let names = ["a.bin", "b.bin", "c.bin"];
    let open = |(bytes, name): (&&[u8], &'static str)| {
        let bytes = bytes.to_vec();
        move || Source::from_bytes(name, bytes.clone())
    };
    let recordings: Vec<_> = files.iter().zip(names).map(open).collect();
    let recordings = recordings.iter().map(|open| open as &Opening<'_>).collect();
    let mut written = b"untouched".to_vec();
    let data = ConvertData::new(recordings, Destination::Bytes(&mut written));
    let outcome = job.evaluate(&data, &Unwatched);
    drop(data);
    match outcome {
        Ok(outcome) => Ok((written, outcome)),
        Err(trouble) => {
            assert_eq!(written, b"untouched", "{trouble}");
            Err(trouble)
        }
    }
}

fn refused(job: &ConvertJob, files: &[&[u8]]) -> String {
    let Err(trouble) = convert(job, files) else {
        panic!("no refusal");
    };
    format!("{trouble}; {}", trouble.hint().unwrap_or_default())
}

fn read(bytes: &[u8], columns: &[usize], rate: Option<f64>) -> Recording {
    let options = RecordingOptions {
        columns: columns.iter().map(|c| (*c).into()).collect(),
        sampling_rate_hz: rate,
        ..RecordingOptions::default()
    };
    let source = Source::from_bytes("written", bytes).unwrap();
    Recording::from_source(source, &options).unwrap()
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|v| v.to_bits()).collect()
}

/// Numbers of all sizes, a negative zero and the smallest double among them.
fn numbers(n: usize) -> [Vec<f64>; 2] {
    let mut state = 1_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let fraction = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        fraction * 10_f64.powi((state % 61) as i32 - 30)
    };
    let mut columns = [(); 2].map(|()| (0..n).map(|_| next()).collect::<Vec<f64>>());
    (columns[0][0], columns[1][1]) = (-0.0, f64::from_bits(1));
    columns
}

fn text(columns: &[Vec<f64>; 2], rate: f64) -> String {
    let mut text = "time_s,acc_x_g,supply_V\n".to_owned();
    for (i, (x, y)) in columns[0].iter().zip(&columns[1]).enumerate() {
        writeln!(text, "{},{x},{y}", i as f64 / rate).unwrap();
    }
    text
}

#[test]
fn law_numbers_come_back_bit_for_bit() {
    let columns = numbers(5000);
    let csv = text(&columns, 250.0);
    let mut npy = job(ConvertFormat::Npy);
    npy.without_units = true;
    let (array, outcome) = convert(&npy, &[csv.as_bytes()]).unwrap();
    assert_eq!(outcome.rows(), 5000);
    assert_eq!(
        outcome.lost(),
        ["names and units: column 1 is time in s, 2 is acc_x in g, 3 is supply in V"]
    );
    assert_eq!(array.len(), 128 + 8 * 3 * 5000);
    let first: Vec<f64> = array[128..]
        .chunks_exact(24)
        .map(|row| f64::from_le_bytes(row[..8].try_into().unwrap()))
        .collect();
    let times = (0..5000).map(|i| f64::from(i) / 250.0);
    assert!(first.iter().copied().eq(times));

    let (uff, outcome) = convert(&job(ConvertFormat::Uff), &[csv.as_bytes()]).unwrap();
    assert!(outcome.lost().is_empty(), "{:?}", outcome.lost());
    for (file, places) in [(&array, [2, 3]), (&uff, [1, 2])] {
        let mut back = job(ConvertFormat::Csv);
        if places == [2, 3] {
            back.reading.time = Some(1.into());
            back.reading.time_unit = "s".parse().ok();
        }
        let (again, _) = convert(&back, &[file]).unwrap();
        let recording = read(&again, &[2, 3], None);
        assert_eq!(bits(&recording.columns[0].data), bits(&columns[0]));
        assert_eq!(bits(&recording.columns[1].data), bits(&columns[1]));
        assert!((recording.time.rate_hz() / 250.0 - 1.0).abs() < 1e-7);
        if places == [1, 2] {
            let units: Vec<_> = recording.columns.iter().map(|c| c.unit).collect();
            assert_eq!(units, [Some(Unit::StandardGravity), Some(Unit::Volt)]);
        }
    }
    // Text into text keeps every number and every time.
    let (same, _) = convert(&job(ConvertFormat::Csv), &[csv.as_bytes()]).unwrap();
    let (before, after) = (
        read(csv.as_bytes(), &[2, 3], None),
        read(&same, &[2, 3], None),
    );
    assert_eq!(before.columns, after.columns);
    assert_eq!(before.time.source(), after.time.source());
}

#[test]
fn law_whole_numbers_go_through_wav() {
    let mut csv = "time_s,x_count,y_count\n".to_owned();
    for i in 0_i32..3000 {
        let y = (i * 7919) % 65_536 - 32_768;
        writeln!(csv, "{:.5},{},{y}", f64::from(i) / 1000.0, -i).unwrap();
    }
    let mut wav = job(ConvertFormat::Wav);
    wav.wav_form = Some(WavSamples::Int16);
    assert!(refused(&wav, &[csv.as_bytes()]).contains("--without-units"));
    wav.without_units = true;
    let (file, outcome) = convert(&wav, &[csv.as_bytes()]).unwrap();
    assert_eq!(file.len(), 44 + 3000 * 4);
    assert_eq!(
        outcome.statement(),
        "3000 rows of 2 channels, WAV, whole numbers of 16 bits"
    );
    let (again, _) = convert(&job(ConvertFormat::Csv), &[&file]).unwrap();
    let (before, after) = (
        read(csv.as_bytes(), &[2, 3], None),
        read(&again, &[2, 3], None),
    );
    for (a, b) in before.columns.iter().zip(&after.columns) {
        assert_eq!(a.data, b.data);
    }
    assert!((after.time.rate_hz() - 1000.0).abs() < 1e-6);
    // A number that does not fit, with its place.
    let wide = csv.replace(",-17,", ",32768,");
    let told = refused(&wav, &[wide.as_bytes()]);
    assert!(
        told.contains("a.bin:19: column \"x\": 32768 cannot be held"),
        "{told}"
    );
    let half = csv.replace(",-17,", ",0.5,");
    assert!(refused(&wav, &[half.as_bytes()]).contains("0.5 cannot be held"));
    // A rate that is no whole number.
    wav.reading.rate = Some(1000.5);
    let told = refused(&wav, &[csv.as_bytes()]);
    assert!(told.contains("1000.5 Hz"), "{told}");
}

#[test]
fn known_single_precision_tells_what_it_rounds() {
    let csv = "x\n0.1\n0.5\n0.25\n";
    let mut wav = job(ConvertFormat::Wav);
    wav.wav_form = Some(WavSamples::Float32);
    wav.reading.rate = Some(50.0);
    let (_, outcome) = convert(&wav, &[csv.as_bytes()]).unwrap();
    // 0.1 in single precision is 0.100000001490116.
    let told = outcome.lost().join("\n");
    assert!(
        told.contains("digits of 1 number: each is rounded by a share of 1.5e-8"),
        "{told}"
    );
}

/// 1000 samples at 100 Hz, of which some are missing.
fn gapped(missing: std::ops::Range<u32>) -> String {
    let mut csv = "time_s,a_m/s2\n".to_owned();
    for i in (0..1000).filter(|i| !missing.contains(i)) {
        writeln!(csv, "{:.2},{i}", f64::from(i) / 100.0).unwrap();
    }
    csv
}

#[test]
fn known_what_becomes_of_a_gap() {
    let csv = gapped(400..410);
    let files: &[&[u8]] = &[csv.as_bytes()];
    let mut wav = job(ConvertFormat::Wav);
    wav.without_units = true;
    let told = refused(&wav, files);
    assert!(told.contains("a gap, 10 samples long in all"), "{told}");
    assert!(
        told.contains("--gaps hold") && told.contains("--gaps close"),
        "{told}"
    );
    let samples = |treatment| {
        let mut job = wav.clone();
        job.gaps = Some(treatment);
        let (file, outcome) = convert(&job, files).unwrap();
        (read(&file, &[1], None).columns[0].data.clone(), outcome)
    };
    let (held, outcome) = samples(GapTreatment::Hold);
    assert_eq!(held.len(), 1000);
    assert!(held[399..410].iter().all(|v| *v == 399.0) && held[410] == 410.0);
    assert!(
        outcome
            .lost()
            .last()
            .unwrap()
            .contains("1 gap: the number before")
    );
    let (closed, _) = samples(GapTreatment::Close);
    assert_eq!(closed.len(), 990);
    assert_eq!(closed[399..401], [399.0, 410.0]);
    wav.gaps = Some(GapTreatment::Nan);
    assert!(refused(&wav, files).contains("no sign for an absent sample"));

    let mut rows = job(ConvertFormat::Csv);
    let (kept, outcome) = convert(&rows, files).unwrap();
    assert_eq!(outcome.rows(), 990);
    assert_eq!(read(&kept, &[2], None).time.gaps().len(), 1);
    rows.gaps = Some(GapTreatment::Nan);
    let (filled, outcome) = convert(&rows, files).unwrap();
    assert_eq!(outcome.rows(), 1000);
    let filled = String::from_utf8(filled).unwrap();
    let lines: Vec<&str> = filled.lines().collect();
    assert_eq!(lines[400..403], ["3.99,399", "4,", "4.01,"]);
    assert_eq!(lines[411], "4.1,410");
    // What was absent is absent again, and NaN in an array.
    let mut npy = job(ConvertFormat::Npy);
    npy.without_units = true;
    let (array, outcome) = convert(&npy, &[filled.as_bytes()]).unwrap();
    let absent = array[128..].chunks_exact(16);
    let absent = absent.filter(|row| f64::from_le_bytes(row[8..].try_into().unwrap()).is_nan());
    assert_eq!(absent.count(), 10);
    assert!(
        outcome
            .notes()
            .join("\n")
            .contains("absent samples, as NaN: 10 of a")
    );
    assert!(refused(&job(ConvertFormat::Uff), &[filled.as_bytes()]).contains("10 of a"));
    rows.gaps = Some(GapTreatment::Close);
    assert!(refused(&rows, files).contains("no gap has to be closed"));
}

#[test]
fn known_recordings_that_continue_each_other() {
    let whole = gapped(500..500);
    let lines: Vec<&str> = whole.lines().collect();
    let part = |from: usize, to: usize| {
        let rows = lines[from + 1..to + 1].join("\n");
        format!("{}\n{rows}\n", lines[0])
    };
    let (one, two, late) = (part(0, 500), part(500, 1000), part(520, 1000));
    let csv = job(ConvertFormat::Csv);
    let (joined, outcome) = convert(&csv, &[one.as_bytes(), two.as_bytes()]).unwrap();
    let (alone, _) = convert(&csv, &[whole.as_bytes()]).unwrap();
    assert_eq!(joined, alone);
    let inputs: Vec<&Input> = outcome.recordings().iter().collect();
    assert_eq!([&*inputs[0].path, &*inputs[1].path], ["a.bin", "b.bin"]);
    // A gap between them is a gap.
    let mut uff = job(ConvertFormat::Uff);
    let told = refused(&uff, &[one.as_bytes(), late.as_bytes()]);
    assert!(told.contains("behind sample 500"), "{told}");
    uff.gaps = Some(GapTreatment::Hold);
    let (file, _) = convert(&uff, &[one.as_bytes(), late.as_bytes()]).unwrap();
    let held = read(&file, &[1], None);
    assert_eq!(held.samples(), 1000);
    assert_eq!(
        held.columns[0].data[499..521]
            .iter()
            .filter(|v| **v == 499.0)
            .count(),
        21
    );
    // An overlap, with its place.
    let early = part(495, 1000);
    let told = refused(&csv, &[one.as_bytes(), early.as_bytes()]);
    assert!(
        told.contains("b.bin:2: begins at 4.95 s, but a.bin before it ends at 4.99 s"),
        "{told}"
    );
    // The window counts on.
    let mut cut = csv.clone();
    cut.reading.between = Some(vec![4.5, 5.5]);
    let (part, outcome) = convert(&cut, &[one.as_bytes(), two.as_bytes()]).unwrap();
    assert_eq!(outcome.rows(), 100);
    assert!(String::from_utf8(part).unwrap().ends_with("5.49,549\n"));
    let other = two.replace("a_m/s2", "b_m/s2");
    let told = refused(&csv, &[one.as_bytes(), other.as_bytes()]);
    assert!(
        told.contains("b.bin: holds \"b\" where a.bin holds \"a\""),
        "{told}"
    );
    let other = two.replace("a_m/s2", "a_g");
    let told = refused(&csv, &[one.as_bytes(), other.as_bytes()]);
    assert!(told.contains("holds \"a\" in g, a.bin in m/s²"), "{told}");
    // With a stated rate they follow one another.
    let mut rate = job(ConvertFormat::Csv);
    rate.reading.rate = Some(100.0);
    let (_, outcome) = convert(&rate, &[one.as_bytes(), early.as_bytes()]).unwrap();
    assert_eq!(outcome.rows(), 1005);
    let told = outcome.lost().join("\n");
    assert!(told.contains("the times of column time"), "{told}");
}

#[test]
fn known_times_keep_their_digits() {
    // Nanoseconds since 1970, and a counter of 16 bits that begins again.
    let mut csv = "t_ns,a_g\n".to_owned();
    for i in 0..200_u64 {
        writeln!(csv, "{},1", 1_700_000_000_123_456_789 + i * 10_000_001).unwrap();
    }
    let (file, _) = convert(&job(ConvertFormat::Csv), &[csv.as_bytes()]).unwrap();
    let file = String::from_utf8(file).unwrap();
    let mut lines = file.lines().skip(1);
    assert_eq!(lines.next(), Some("1700000000.123456789,1"));
    assert_eq!(lines.next(), Some("1700000000.13345679,1"));
    let mut npy = job(ConvertFormat::Npy);
    npy.without_units = true;
    let (array, outcome) = convert(&npy, &[csv.as_bytes()]).unwrap();
    let second = f64::from_le_bytes(array[144..152].try_into().unwrap());
    assert_eq!(second, 0.010_000_001);
    let told = outcome.lost().join("\n");
    assert!(told.contains("zero is 1700000000.12345"), "{told}");
    let mut wraps = "t_ms,a_g\n".to_owned();
    for i in 0..8000_u64 {
        writeln!(wraps, "{},1", (i * 10) % 65_536).unwrap();
    }
    let (file, outcome) = convert(&job(ConvertFormat::Csv), &[wraps.as_bytes()]).unwrap();
    assert!(String::from_utf8(file).unwrap().ends_with("79.99,1\n"));
    let codes: Vec<&str> = proofmass_jobs::Outcome::findings(&outcome)
        .iter()
        .map(|f| f.code())
        .collect();
    assert_eq!(codes, ["clock-wrapped"]);
}

#[test]
fn refuses_what_is_no_recording() {
    let csv = job(ConvertFormat::Csv);
    for (bytes, said) in [
        (&b""[..], "empty"),
        (b"time_s,a_g\n", "row"),
        (b"time_s,a_g\n0,1\n0.01,x\n0.02,3\n", "not a number"),
        (b"time_s,a_g\n0,1\n0.01\n0.02,3\n", "field"),
        (b"time_s,a_g\n0,1\n0.01,inf\n0.02,3\n", "inf"),
        (b"time_s,a_g\n0,1\n0.01,2\n0.005,3\n0.02,4\n", "backwards"),
        (b"time_s,a_g\n0,1\n,2\n0.02,4\n", "empty"),
        (b"time_s,a_g\n0,1\n0,2\n0,4\n0,4\n", "repeats"),
    ] {
        let told = refused(&csv, &[bytes]);
        assert!(told.contains(said), "{}: {told}", bytes.escape_ascii());
    }
    let mut units = csv.clone();
    units.reading.columns = Some(vec!["a".into()]);
    units.reading.unit = Some(Unit::Volt);
    assert!(refused(&units, &[b"time_s,a_g\n0,1\n0.01,2\n"]).contains("the heading says g"));
    let none = ConvertJob::default();
    assert!(refused(&none, &[b"a\n1\n2\n"]).contains("--to csv, npy, wav, uff or parquet"));
    let mut wrong = csv.clone();
    wrong.wav_form = Some(WavSamples::Int16);
    let trouble = convert(&wrong, &[b"a\n1\n2\n"]).err().unwrap();
    assert_eq!(trouble.kind(), TroubleKind::Request);
    // No clock: rows in their order, but no steady rate.
    let (order, outcome) = convert(&csv, &[b"a;b\n1;2\n3;4\n"]).unwrap();
    assert_eq!(order, b"a,b\n1,2\n3,4\n");
    assert!(outcome.notes()[0].starts_with("no times are written"));
    assert!(refused(&job(ConvertFormat::Wav), &[b"a;b\n1;2\n3;4\n"]).contains("--rate HZ"));
    let mut held = job(ConvertFormat::Uff);
    held.gaps = Some(GapTreatment::Hold);
    held.reading.rate = Some(10.0);
    assert!(refused(&held, &[b"a,b\n,2\n3,4\n1,1\n"]).contains("no number stands before it"));
}

#[test]
fn law_what_is_listed_as_written_is_written() {
    let written = FORMATS.iter().filter(|f| f.is_written()).map(|f| f.word);
    let mut written: Vec<&str> = written.collect();
    written.sort_unstable();
    let all = ["npy", "parquet", "uff", "wav"];
    assert!(
        all.into_iter()
            .filter(|w| *w != "parquet" || PARQUET)
            .eq(written.iter().copied())
    );
    for word in written {
        let job: ConvertJob = serde_json::from_str(&format!("{{\"to\":\"{word}\"}}")).unwrap();
        assert!(job.to.is_some());
    }
    for (name, to) in [("a.CSV", "a CSV file"), ("x/y.npy", "an npy file")] {
        let target = ConvertJob::default().target(Some(Path::new(name)));
        assert_eq!(target.unwrap().name(), to);
    }
}

/// Logs of 2023-11-14 whose times count from their first message: they continue each other by the clock of the files.
#[test]
fn known_dates_of_files_join_recordings() {
    let corpus = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds/three.cwa");
    let whole = std::fs::read(corpus).unwrap();
    // A header of two blocks, then blocks of half a kilobyte.
    let (first, rest) = (&whole[..1536], [&whole[..1024], &whole[1536..]].concat());
    let csv = job(ConvertFormat::Csv);
    let (joined, _) = convert(&csv, &[first, &rest]).unwrap();
    let (alone, _) = convert(&csv, &[&whole]).unwrap();
    let times = |text: &[u8]| -> Vec<f64> {
        let text = String::from_utf8(text.to_vec()).unwrap();
        let rows = text.lines().skip(1);
        rows.map(|row| row.split(',').next().unwrap().parse().unwrap())
            .collect()
    };
    let (joined, alone) = (times(&joined), times(&alone));
    assert!(joined[0] > 946_684_800.0 && joined.len() == alone.len());
    let apart = joined.iter().zip(&alone).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 0.02);
    let told = refused(&csv, &[&rest, first]);
    assert!(told.contains("begins at"), "{told}");
}

#[test]
fn refuses_parquet_where_it_is_not_built_and_devices_elsewhere() {
    let csv = job(ConvertFormat::Csv);
    let table = b"file,serial\na.bin,7\n";
    let refusal = |job: &ConvertJob| {
        let trouble = devices(job, table, &[b"a\n1\n2\n"]).unwrap_err();
        format!("{trouble}; {}", trouble.hint().unwrap_or_default())
    };
    let told = refusal(&csv);
    assert!(
        told.contains("no place for serial numbers") && told.contains("--to parquet"),
        "{told}"
    );
    if !PARQUET {
        let told = refused(&job(ConvertFormat::Parquet), &[b"a\n1\n2\n"]);
        assert!(told.contains("the feature parquet"), "{told}");
    }
    for (table, said) in [
        (&b"file,serial\n"[..], "one row per line"),
        (b"serial\n7\n", "no such column"),
        (b"file,serial\na,7\na,8\n", "stands twice"),
        (b"file,serial\na,\n", "empty"),
        (b"file,serial,bach\na,1,2\n", "did you mean `batch`"),
    ] {
        let source = Source::from_bytes("devices.csv", table).unwrap();
        let trouble = DeviceTable::read(source).unwrap_err();
        let told = format!("{trouble}; {}", trouble.hint().unwrap_or_default());
        assert!(
            told.contains(said) && told.contains("devices.csv"),
            "{told}"
        );
    }
}

/// Converts recordings of devices in memory.
fn devices(
    job: &ConvertJob,
    table: &[u8],
    files: &[&[u8]],
) -> Result<(Vec<u8>, ConvertOutcome), Trouble> {
    let table = DeviceTable::read(Source::from_bytes("devices.csv", table).unwrap())?;
    let open = |(bytes, device): (&&[u8], &proofmass_jobs::convert::Device)| {
        let (bytes, name) = (bytes.to_vec(), device.file.clone());
        move || Source::from_bytes(&name, bytes.clone())
    };
    let recordings: Vec<_> = files.iter().zip(&table.devices).map(open).collect();
    let recordings = recordings.iter().map(|open| open as &Opening<'_>).collect();
    let mut written = Vec::new();
    let data = ConvertData::new(recordings, Destination::Bytes(&mut written)).with_devices(&table);
    let outcome = job.evaluate(&data, &Unwatched)?;
    drop(data);
    Ok((written, outcome))
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::*;

    #[test]
    fn law_numbers_times_and_units_come_back() {
        let columns = numbers(5000);
        let csv = text(&columns, 250.0);
        let (file, outcome) = convert(&job(ConvertFormat::Parquet), &[csv.as_bytes()]).unwrap();
        assert!(outcome.lost().is_empty() && outcome.notes().is_empty());
        assert_eq!(
            outcome.columns(),
            ["time in s", "acc_x in g", "supply in V"]
        );
        let (again, _) = convert(&job(ConvertFormat::Csv), &[&file]).unwrap();
        let (before, after) = (
            read(csv.as_bytes(), &[2, 3], None),
            read(&again, &[2, 3], None),
        );
        assert_eq!(before.columns, after.columns);
        assert_eq!(
            again,
            convert(&job(ConvertFormat::Csv), &[csv.as_bytes()])
                .unwrap()
                .0
        );
        // Gaps are kept, absent samples are nulls and absent again.
        let gapped = gapped(400..410);
        let mut filled = job(ConvertFormat::Parquet);
        filled.gaps = Some(GapTreatment::Nan);
        let (file, outcome) = convert(&filled, &[gapped.as_bytes()]).unwrap();
        assert_eq!(
            outcome.notes(),
            ["1 gap: 10 missing samples put in as nulls"]
        );
        let mut nan = job(ConvertFormat::Csv);
        nan.gaps = Some(GapTreatment::Nan);
        let (wanted, _) = convert(&nan, &[gapped.as_bytes()]).unwrap();
        let (again, _) = convert(&job(ConvertFormat::Csv), &[&file]).unwrap();
        assert_eq!(again, wanted);
        // More rows than a row group holds.
        let mut long = "a,b\n".to_owned();
        for i in 0..1_100_000 {
            writeln!(long, "{i},{}", -i).unwrap();
        }
        let mut rate = job(ConvertFormat::Parquet);
        rate.reading.rate = Some(1000.0);
        let (file, _) = convert(&rate, &[long.as_bytes()]).unwrap();
        let again = read(&file, &[2, 3], None);
        assert_eq!(again.samples(), 1_100_000);
        assert!(
            again.columns[0]
                .data
                .iter()
                .zip(0..)
                .all(|(v, i)| *v == f64::from(i))
        );
        assert!((again.time.rate_hz() / 1000.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn known_recordings_of_many_devices_are_one_table() {
        let table = b"file;serial;batch\nlate.csv;0012;B 7\nearly.csv;0013;B 7\n";
        let late = "t (ms);a (g)\n1700000000000;1,5\n1700000000010;2,5\n1700000000020;\n";
        let early = "t (s);a (g)\n0;-1,5\n0,02;-2,5\n";
        let files: [&[u8]; 2] = [late.as_bytes(), early.as_bytes()];
        let (file, outcome) = devices(&job(ConvertFormat::Parquet), table, &files).unwrap();
        assert_eq!(outcome.rows(), 5);
        assert_eq!(
            outcome.columns(),
            ["serial", "batch", "recording", "time in s", "a in g"]
        );
        assert_eq!(
            outcome.lost(),
            ["late.csv: the start of the times: zero is 1700000000 s of the recording"]
        );
        assert_eq!(
            outcome.notes(),
            ["late.csv: absent samples, as nulls: 1 of a"]
        );
        let inputs: Vec<&str> = outcome
            .recordings()
            .iter()
            .map(|i| i.path.as_str())
            .collect();
        assert_eq!(inputs, ["devices.csv", "late.csv", "early.csv"]);
        // Read again, each is a stream of its own.
        let told = refused(&job(ConvertFormat::Csv), &[&file]);
        assert!(
            told.contains("\"0012 late.csv\" (3 samples") && told.contains("--source"),
            "{told}"
        );
        let mut one = job(ConvertFormat::Csv);
        one.reading.choice.source = Some("0013 early.csv".to_owned());
        let (again, _) = convert(&one, &[&file]).unwrap();
        assert_eq!(
            String::from_utf8(again).unwrap(),
            "time_s,a_g\n0,-1.5\n0.02,-2.5\n"
        );
        // The words of the row groups, as they stand in the dictionaries.
        let holds = |word: &[u8]| file.windows(word.len()).any(|w| w == word);
        assert!(
            [&b"0012"[..], b"0013", b"B 7", b"early.csv"]
                .into_iter()
                .all(holds)
        );
        // Other columns are refused, with both names.
        let other = early.replace("a (g)", "b (g)");
        let files: [&[u8]; 2] = [late.as_bytes(), other.as_bytes()];
        let told = devices(&job(ConvertFormat::Parquet), table, &files);
        let told = told.unwrap_err().to_string();
        assert!(
            told.contains("early.csv: holds \"b\" where late.csv holds \"a\""),
            "{told}"
        );
    }
}
