//! Recordings of other formats through the view that text has: the same numbers, rate, units and digest.

use proofmass_io::{
    Layout, LayoutOptions, Recording, RecordingOptions, Rewriter, RowReader, SaidBy, Source,
    TimeSource, Unit, Waveform, WaveformFormat, WaveformOptions, f32_bytes, inspect_source,
};
use std::io::Write as _;
use std::path::PathBuf;

/// 24-bit WAV, two channels at 1 kHz.
fn wav(samples: &[[i32; 2]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let spec = hound::WavSpec {
        channels: 2,
        sample_rate: 1000,
        bits_per_sample: 24,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
    for v in samples.iter().flatten() {
        writer.write_sample(*v).unwrap();
    }
    writer.finalize().unwrap();
    bytes.into_inner()
}

/// TDMS of single-precision floats in volts, channel by channel, at a step of 1 ms.
fn tdms(groups: &[(&str, &[[f32; 2]])]) -> Vec<u8> {
    let text = |t: &str| [&(t.len() as u32).to_le_bytes()[..], t.as_bytes()].concat();
    let (mut metadata, mut raw) = (Vec::new(), Vec::new());
    for (group, samples) in groups {
        for channel in 0..2 {
            metadata.extend(text(&format!("/'{group}'/'ai{channel}'")));
            for v in [20_u32, 9, 1] {
                metadata.extend(v.to_le_bytes());
            }
            metadata.extend((samples.len() as u64).to_le_bytes());
            metadata.extend(2_u32.to_le_bytes());
            metadata.extend([text("wf_increment"), 10_u32.to_le_bytes().to_vec()].concat());
            metadata.extend(0.001_f64.to_le_bytes());
            metadata.extend(
                [
                    text("unit_string"),
                    0x20_u32.to_le_bytes().to_vec(),
                    text("V"),
                ]
                .concat(),
            );
            raw.extend(samples.iter().flat_map(|s| s[channel].to_le_bytes()));
        }
    }
    let objects = 2 * groups.len() as u32;
    let metadata = [&objects.to_le_bytes()[..], &metadata].concat();
    let mut file = b"TDSm\x0e\0\0\0\x69\x12\0\0".to_vec();
    file.extend(((metadata.len() + raw.len()) as u64).to_le_bytes());
    file.extend((metadata.len() as u64).to_le_bytes());
    [file, metadata, raw].concat()
}

fn samples() -> Vec<[f32; 2]> {
    (0..5000)
        .map(|i| [(i as f32 * 0.37).sin(), (i as f32 * 0.11).cos()])
        .collect()
}

fn options(columns: &[&str]) -> RecordingOptions {
    RecordingOptions {
        columns: columns.iter().map(|c| (*c).into()).collect(),
        ..RecordingOptions::default()
    }
}

#[test]
fn known_recording_through_the_one_view() {
    let file = tdms(&[("bench", &samples())]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("named.csv");
    std::fs::write(&path, &file).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&file).unwrap();
    let packed = packed.finish().unwrap();
    let whole = Recording::read(&path, &options(&["ai1", "ai0"])).unwrap();
    let wanted: Vec<f64> = samples().iter().map(|s| f64::from(s[1])).collect();
    assert_eq!(whole.columns[0].data, wanted);
    assert_eq!(whole.columns[0].unit, Some(Unit::Volt));
    assert_eq!(whole.time.rate_hz(), 1000.0);
    assert!(!matches!(whole.time.source(), TimeSource::Column(_)));
    let line = whole.reading().to_string();
    assert_eq!(
        line,
        "columns 2 ai1, 1 ai0 in V by the file; 1 kHz by the file; tdms file"
    );
    assert_eq!(whole.reading().time.by, SaidBy::File);
    // A pipe and a packed file give the same numbers, and each the digest of its own bytes.
    for (bytes, same) in [(file.clone(), true), (packed, false)] {
        let digest = Source::from_bytes("x", bytes.clone())
            .unwrap()
            .finish()
            .unwrap()
            .sha256;
        let pipe = Source::new("pipe", std::io::Cursor::new(bytes)).unwrap();
        let read = Recording::from_source(pipe, &options(&["ai1", "ai0"])).unwrap();
        assert_eq!(read.columns, whole.columns);
        assert_eq!(
            (
                read.file.sha256 == whole.file.sha256,
                read.file.sha256 == digest
            ),
            (same, true)
        );
    }
    let cut = RecordingOptions {
        between: Some([1.0, 2.0]),
        ..options(&["ai0"])
    };
    let cut = Recording::read(&path, &cut).unwrap();
    assert_eq!(
        (cut.samples(), cut.columns[0].data[0]),
        (1000, f64::from(samples()[1000][0]))
    );
    let seen = inspect_source(
        Source::open(&path).unwrap(),
        &RecordingOptions::default(),
        10,
    )
    .unwrap();
    assert_eq!(
        (seen.rows, seen.columns.len(), seen.bad_count),
        (5000, 3, 0)
    );
    let time = seen.time.unwrap();
    assert_eq!((time.rate_hz, time.gap_count), (1000.0, 0));
    assert!((time.duration_s - 5.0).abs() < 1e-9);
}

/// A header of a recording before zeros that pack to a thousandth.
#[test]
fn refuses_a_packed_file_that_fills_the_memory() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&tdms(&[("bench", &samples())])).unwrap();
    for _ in 0..60 {
        packed.write_all(&[0; 1 << 20]).unwrap();
    }
    let source = Source::from_bytes("r", packed.finish().unwrap()).unwrap();
    let error = Recording::from_source(source, &options(&["ai0"])).unwrap_err();
    let said = error.to_string();
    assert!(
        said.contains("unpacks to more than") && said.contains("times its size"),
        "{said}"
    );
}

#[test]
fn known_rows_with_their_text() {
    let file = tdms(&[("bench", &[[1.5, -2.0], [0.25, 3.0]])]);
    let mut source = Source::from_bytes("r.tdms", file).unwrap();
    let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
    let mut writer =
        Rewriter::in_memory(source.name(), &layout, &[(1, "ai1_m/s2".into())]).unwrap();
    let mut reader = RowReader::new(source, layout, &[1]).unwrap().keep_text();
    while let Some(block) = reader.next_block().unwrap() {
        writer.block(&block, &[&[7.0, 8.0]]).unwrap();
    }
    let text = String::from_utf8(writer.into_bytes().unwrap()).unwrap();
    assert_eq!(
        text,
        "ai0 (V),ai1_m/s2,time (s)\n1.5,7.0,0\n0.25,8.0,0.001\n"
    );
}

#[test]
fn refuses_to_choose_between_streams() {
    let other: Vec<[f32; 2]> = samples()[..10].to_vec();
    let file = tdms(&[("bench", &samples()), ("oven", &other)]);
    let source = || Source::from_bytes("r.tdms", file.clone()).unwrap();
    let error = Recording::from_source(source(), &options(&["ai0"])).unwrap_err();
    let said = error.to_string();
    assert!(
        said.contains("\"bench\"") && said.contains("\"oven\""),
        "{said}"
    );
    assert!(error.hint().unwrap().contains("--source"));
    let seen = inspect_source(source(), &RecordingOptions::default(), 10).unwrap();
    assert_eq!((seen.streams.len(), seen.columns.len()), (2, 0));
    let chosen = source().with_stream(Some("oven"), false);
    assert_eq!(
        Recording::from_source(chosen, &options(&["ai0"]))
            .unwrap()
            .samples(),
        10
    );
    let wrong =
        Recording::from_source(source().with_stream(Some("own"), false), &options(&["ai0"]));
    assert!(wrong.unwrap_err().hint().unwrap().contains("oven"));
    let text = Source::from_bytes("r.csv", "t_s,a_g\n0,1\n1,2\n").unwrap();
    let text = text.with_stream(Some("oven"), false);
    assert!(Recording::from_source(text, &options(&["a"])).is_err());
}

/// The same run as raw floats, TDMS and WAV gives the same waveform, bit for bit.
#[test]
fn law_a_waveform_is_the_same_in_every_format() {
    let whole: Vec<[i32; 2]> = (0..4000)
        .map(|i| [i * 2000 - 4_000_000, 3 * i - 6000])
        .collect();
    let volts = |v: i32| f64::from(v) * (10.0 / 8_388_608.0);
    let floats: Vec<[f32; 2]> = whole.iter().map(|s| s.map(|v| volts(v) as f32)).collect();
    let columns = [0, 1].map(|c| whole.iter().map(|s| volts(s[c])).collect::<Vec<f64>>());
    let waveform = |format, bytes: Vec<u8>, names: [&str; 2]| {
        let options = WaveformOptions {
            format,
            sampling_rate_hz: Some(1000.0),
            channels: names
                .iter()
                .map(|n| ((*n).to_owned(), (*n).into()))
                .collect(),
            channel_count: 2,
            full_scale_v: Some(10.0),
            unit: Some(Unit::Volt),
            ..WaveformOptions::default()
        };
        Waveform::from_source(Source::from_bytes("run", bytes).unwrap(), &options).unwrap()
    };
    let raw = f32_bytes(&[&columns[0], &columns[1]]).unwrap();
    let raw = waveform(WaveformFormat::F32, raw, ["1", "2"]);
    let labview = waveform(
        WaveformFormat::Text,
        tdms(&[("bench", &floats)]),
        ["ai0", "ai1"],
    );
    assert_eq!(raw.channels, labview.channels);
    assert_eq!(
        (labview.sampling_rate_hz, labview.times.is_none()),
        (1000.0, true)
    );
    // By its content, and stated; 24 bits over ±10 V are exact in single precision.
    for format in [WaveformFormat::Text, WaveformFormat::Wav] {
        let wav = waveform(format, wav(&whole), ["1", "2"]);
        assert_eq!(wav.channels, columns);
        assert_eq!(
            wav.channels[0]
                .iter()
                .map(|v| *v as f32 as f64)
                .collect::<Vec<_>>(),
            raw.channels[0]
        );
    }
}

#[test]
fn known_cut_file_has_its_rows_and_a_finding() {
    let file = tdms(&[("bench", &samples())]);
    let cut = Source::from_bytes("r.tdms", &file[..file.len() - 10_001]).unwrap();
    let read = Recording::from_source(cut, &options(&["ai0", "ai1"]));
    // One channel lies behind the other, so that rows are lost from the end.
    let read = read.unwrap();
    assert_eq!(read.samples(), 2499);
    assert!(read.findings().iter().any(|f| f.code() == "file-cut"));
}

#[test]
fn known_doubts_about_a_file() {
    let told = |bytes: Vec<u8>| {
        let source = Source::from_bytes("r", bytes).unwrap();
        inspect_source(source, &RecordingOptions::default(), 10)
            .unwrap()
            .findings
    };
    let mut blocks = include_bytes!("seeds/three.cwa").to_vec();
    assert!(told(blocks.clone()).is_empty());
    blocks[1024 + 512 + 60] ^= 1;
    assert_eq!(told(blocks)[0].code(), "parts-damaged");
    let mut set = b"    -1\n   151\nsomebody\n    -1\n".to_vec();
    set.extend(include_bytes!("seeds/two.uff"));
    let found = told(set);
    assert_eq!(found[0].code(), "parts-passed-over");
    assert!(!format!("{found:?}").contains("somebody"));
    let mut file = tdms(&[("bench", &samples())]);
    let places: Vec<usize> = (0..400)
        .filter(|&i| file[i..].starts_with(b"\x01\0\0\0V"))
        .collect();
    places.iter().for_each(|i| file[i + 4] = b'?');
    let found = told(file);
    assert_eq!(found[0].code(), "unit-word-unknown");
}

#[test]
#[cfg(feature = "parquet")]
fn known_nulls_are_absent_and_headings_keep_their_units() {
    let source = || {
        let file = include_bytes!("seeds/nulls.parquet");
        Source::from_bytes("nulls.parquet", file.to_vec()).unwrap()
    };
    let whole = Recording::from_source(source(), &options(&["acc_x", "counts"])).unwrap();
    assert_eq!(whole.columns[0].unit, Some(Unit::MetrePerSecondSquared));
    assert_eq!(whole.columns[1].unit, Some(Unit::Count));
    assert!((whole.time.rate_hz() - 800.0).abs() < 0.1);
    let error = Recording::from_source(source(), &options(&["acc_y"])).unwrap_err();
    assert!(error.to_string().contains("sample 5 is absent"), "{error}");
    let sparse = Recording::from_source_sparse(
        source(),
        &options(&["acc_y"]),
        &[proofmass_io::Absent::Empty],
    );
    let sparse = sparse.unwrap();
    assert_eq!(sparse.columns[0].unit, Some(Unit::StandardGravity));
    assert_eq!(sparse.missing(0), [4, 9]);
    let seen = inspect_source(source(), &RecordingOptions::default(), 10).unwrap();
    assert_eq!((seen.rows, seen.bad_count, seen.bad_row_count), (12, 6, 0));
    assert_eq!(seen.findings[0].code(), "parts-passed-over");
    // As text: an empty field.
    let mut source = source();
    let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
    let mut writer = Rewriter::in_memory(source.name(), &layout, &[(3, "n".into())]).unwrap();
    let mut reader = RowReader::new(source, layout, &[3]).unwrap().keep_text();
    while let Some(block) = reader.next_block().unwrap() {
        writer.block(&block, &[&[0.0; 12]]).unwrap();
    }
    let text = String::from_utf8(writer.into_bytes().unwrap()).unwrap();
    let line = text.lines().nth(5).unwrap();
    assert!(line.starts_with("1,,4000,"), "{line}");
}

fn reference_data() -> PathBuf {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    PathBuf::from(
        data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md"),
    )
}

/// The last page of a GENEActiv file ends behind 231 samples; sums of the 16 whole ones are those of GGIRread.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_pages_before_a_cut() {
    let file = reference_data().join("wearable/ggirread/GENEActiv_testfile.bin");
    let table = RecordingOptions {
        table: true,
        ..options(&["acc_x", "acc_y", "acc_z"])
    };
    let read = Recording::read(&file, &table).unwrap();
    assert_eq!(read.samples(), 5031);
    assert!(read.findings().iter().any(|f| f.code() == "file-cut"));
    let wanted = [
        (-0.956_097, -2_409.708_213),
        (0.173_389, 1_415.920_572),
        (-0.232_751, -2_210.803_508),
    ];
    for (column, (last, sum)) in read.columns.iter().zip(wanted) {
        let whole = &column.data[..4800];
        assert!((whole[4799] - last).abs() < 1e-6);
        assert!((whole.iter().sum::<f64>() - sum).abs() < 1e-6);
    }
}

/// Times of IDE blocks as idelib gives them, which are whole microseconds, and the rate that follows from all samples.
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_times_of_blocks() {
    for (name, stream, channel, first, last, rate) in [
        (
            "wearable/idelib/SSX70065.IDE",
            "Acceleration",
            "X",
            0.006_439,
            12.168_518,
            3071.843,
        ),
        (
            "wearable/idelib/XS5E25D40.IDE",
            "40g DC Acceleration",
            "X (40g)",
            0.010_894,
            1.514_526,
            4022.926,
        ),
    ] {
        let table = RecordingOptions {
            stream: Some(stream.to_owned()),
            table: true,
            ..options(&["time"])
        };
        let read = Recording::read(&reference_data().join(name), &table).unwrap();
        let times = &read.columns[0].data;
        assert!((times[0] - first).abs() < 1e-6, "{name}");
        assert!((times[times.len() - 1] - last).abs() < 1e-6, "{name}");
        let clocked = RecordingOptions {
            stream: Some(stream.to_owned()),
            ..options(&[channel])
        };
        let read = Recording::read(&reference_data().join(name), &clocked).unwrap();
        assert!(
            (read.time.rate_hz() / rate - 1.0).abs() < 1e-3,
            "{name} {}",
            read.time.rate_hz()
        );
    }
}

/// The same of columns of Parquet files, as pyarrow gives them.
#[test]
#[cfg(feature = "parquet")]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_parquet_of_others() {
    let folder = reference_data().join("doors/parquet");
    for (name, column, n, first, last, sum) in [
        ("alltypes_plain.snappy.parquet", "id", 2, 6.0, 7.0, 13.0),
        (
            "alltypes_plain.snappy.parquet",
            "bool_col",
            2,
            1.0,
            0.0,
            1.0,
        ),
        (
            "alltypes_plain.snappy.parquet",
            "tinyint_col",
            2,
            0.0,
            1.0,
            1.0,
        ),
        ("datapage_v2.snappy.parquet", "b", 5, 1.0, 5.0, 15.0),
        ("datapage_v2.snappy.parquet", "c", 5, 2.0, 2.0, 16.0),
        ("datapage_v2.snappy.parquet", "d", 5, 1.0, 1.0, 4.0),
        (
            "byte_stream_split.zstd.parquet",
            "f32",
            300,
            1.764_052_39,
            0.370_055_884,
            8.258_872_92,
        ),
        (
            "byte_stream_split.zstd.parquet",
            "f64",
            300,
            -1.306_526_85,
            -0.178_589_092,
            -41.229_190_2,
        ),
        // Its places in a dictionary of one take no bits, which old readers refuse and the format allows.
        ("ARROW-GH-43605.parquet", "min_fl", 21_186, 0.0, 0.0, 0.0),
    ] {
        let options = RecordingOptions {
            table: true,
            ..options(&[column])
        };
        let read = Recording::read(&folder.join(name), &options);
        let read = read.unwrap_or_else(|e| panic!("{name}: {e}, {:?}", e.hint()));
        let data = &read.columns[0].data;
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-8 * b.abs().max(1e-12);
        assert_eq!(data.len(), n, "{name}");
        assert!(close(data[0], first) && close(data[n - 1], last), "{name}");
        assert!(close(data.iter().sum(), sum), "{name}");
    }
    let absent = RecordingOptions {
        table: true,
        ..options(&["b_struct.b_c_int"])
    };
    let path = folder.join("nulls.snappy.parquet");
    let error = Recording::read(&path, &absent).unwrap_err().to_string();
    assert!(error.contains("sample 1 is absent"), "{error}");
    let path = folder.join("ARROW-GH-41317.parquet");
    let error = Recording::read(&path, &options(&["uint8"])).unwrap_err();
    assert!(error.to_string().contains("index at the end is damaged"));
}

/// Numbers, first, last and sum of a channel as other readers give them (npTDMS, lvm_read, pyuff, scipy, mcap, pyulog, h5py, idelib, GGIRread).
#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_streams_of_others() {
    for (name, stream, column, n, first, last, sum) in [
        (
            "doors/tdms/daqmx_accelerometers_scaled.tdms",
            None,
            "ai0",
            10_000,
            0.012_149_373_3,
            0.477_506_679,
            619.558_867,
        ),
        (
            "doors/tdms/daqmx_accelerometers_scaled.tdms",
            None,
            "ai1",
            10_000,
            32.152_917_7,
            -29.154_064_6,
            3_875.866_92,
        ),
        (
            "doors/tdms/06_multi_segment.tdms",
            None,
            "Sensor",
            300,
            -0.008_707_881_75,
            -0.061_440_027_8,
            -0.680_059_018,
        ),
        (
            "doors/tdms/IncrementalMetaInformationExample_step5.tdms",
            Some("group 2"),
            "channel2",
            39,
            4.0,
            27.0,
            438.0,
        ),
        (
            "doors/lvm/short.lvm",
            None,
            "Excitation (Trigger)",
            10,
            0.914_018,
            0.680_572,
            6.917_138,
        ),
        (
            "doors/lvm/short.lvm",
            None,
            "Response (Trigger)",
            10,
            1.204_792,
            1.212_775,
            12.138_708,
        ),
        (
            "doors/uff/uneven_ascii.uff",
            None,
            "response a 1Z",
            2048,
            1.604_897_85,
            -4.667_296_67,
            272.455_599,
        ),
        (
            "doors/wav/test-44100Hz-le-1ch-4bytes-rf64.wav",
            None,
            "channel 1",
            4410,
            9_538_171.0,
            -212_242_929.0,
            8_927_800.0,
        ),
        (
            "doors/wav/test-44100Hz-be-1ch-4bytes.wav",
            None,
            "channel 1",
            4410,
            9_538_171.0,
            -212_242_929.0,
            8_927_800.0,
        ),
        (
            "doors/wav/usb_accelerometer_24bit.wav",
            None,
            "channel 2",
            48_000,
            61_975.0,
            57_766.0,
            0.0,
        ),
        (
            "wearable/ggirread/ax3_testfile.cwa",
            None,
            "acc_x",
            17_400,
            0.328_125,
            -0.0625,
            13_530.468_75,
        ),
        (
            "wearable/ggirread/ax3_testfile_corrupt_blocks_0_13_14_142_143_144.cwa",
            None,
            "acc_z",
            16_680,
            -0.578_125,
            0.203_125,
            4_939.875,
        ),
        (
            "wearable/ggirread/ax6_testfile.cwa",
            None,
            "acc_y",
            11_320,
            0.071_289_062_5,
            0.981_445_312_5,
            2_386.895_02,
        ),
        (
            "wearable/skdh/ax3_sample.cwa",
            None,
            "acc_z",
            58_800,
            0.953_125,
            0.375,
            11_800.093_75,
        ),
        (
            "doors/mcap/imu_zstd.mcap",
            None,
            "linear_acceleration.x",
            3000,
            -8.420_9,
            -8.272_38,
            -18_548.350_7,
        ),
        (
            "doors/mcap/imu_zstd.mcap",
            None,
            "linear_acceleration.y",
            3000,
            0.067_1,
            4.723_02,
            3_095.228_49,
        ),
        (
            "doors/mcap/imu_zstd.mcap",
            None,
            "time",
            3000,
            0.0,
            29.99,
            44_985.0,
        ),
        (
            "doors/mcap/imu_two_topics_lz4.mcap",
            Some("/camera/imu"),
            "linear_acceleration.z",
            1500,
            5.745_11,
            8.973_58,
            f64::NAN,
        ),
        (
            "doors/mcap/imu_cut.mcap",
            None,
            "linear_acceleration.z",
            1689,
            5.245_11,
            8.674_79,
            f64::NAN,
        ),
        (
            "doors/ulg/sample_px4_events.ulg",
            Some("sensor_combined"),
            "accelerometer_m_s2[2]",
            7783,
            -9.821_813_583_374_023,
            -9.812_236_785_888_672,
            -76_141.371_799_945_83,
        ),
        (
            "doors/ulg/sample_px4_events.ulg",
            Some("sensor_accel"),
            "x",
            31,
            0.023_942_016_1,
            -0.064_643_442_6,
            -0.248_996_973_04,
        ),
        (
            "wearable/pyulog/sample_log_small.ulg",
            Some("sensor_accel_1"),
            "z",
            6,
            -9.912_714_004_5,
            -9.909_867_286_7,
            -59.439_145_088_2,
        ),
        (
            "wearable/idelib/SSX70065.IDE",
            Some("Acceleration"),
            "X",
            37_361,
            -0.046_875,
            -0.351_562_5,
            -0.068_177_293_835_8 * 37_361.0,
        ),
        (
            "wearable/idelib/XS5E25D40.IDE",
            Some("40g DC Acceleration"),
            "Y (40g)",
            6050,
            0.055_237_379_469,
            0.048_833_217_840,
            0.042_046_923_592 * 6050.0,
        ),
        (
            "wearable/idelib/XS5E25D40.IDE",
            Some("25g PE Acceleration"),
            "Z (25g)",
            7420,
            -11.171_408_940,
            -11.169_366_713,
            -11.170_081_355 * 7420.0,
        ),
        (
            "doors/ide/test5.IDE",
            Some("100g PE Acceleration"),
            "Mic",
            46_317,
            -1.429_770_351_72,
            -2.006_561_379_42,
            -1.416_667_563_999 * 46_317.0,
        ),
        (
            "wearable/wristpy/example_geneactiv.bin",
            None,
            "acc_y",
            27_300,
            (-24_600.0 + 474.0) / 25_100.0,
            -0.726_135_458,
            -25_627.888_447,
        ),
        (
            "doors/mat/shaker_excitation.mat",
            None,
            "freq_hz",
            100,
            19.998_618_7,
            10_000.0,
            164_043.935,
        ),
        (
            "doors/mat/testvec_4_GLNX86.mat",
            None,
            "xdot_filt",
            2,
            8.111_544_75e-13,
            1.285_040_39e-11,
            1.366_155_84e-11,
        ),
        (
            "doors/hdf5/rotate-360cc_mpu6050_accelerometer.mat",
            None,
            "accelBuffer(:,1)",
            1463,
            0.008_701_517_965_600_971,
            14.594_573_007_374_146,
            10_570.082_967_783_39,
        ),
        (
            "doors/hdf5/rotate-360cc_mpu6050_accelerometer.mat",
            None,
            "accelBuffer(:,4)",
            1463,
            0.987_548_828_125,
            0.988_281_25,
            535.004_882_812_5,
        ),
        (
            "doors/hdf5/rotate-360cc_mpu6050_temperature.mat",
            None,
            "temperatureBuffer(:,2)",
            1463,
            23.024_117_647_058_823,
            23.024_117_647_058_823,
            33_690.590_000_000_004,
        ),
        (
            "doors/mat/testhdf5_7.4_GLNX86.mat",
            None,
            "testdouble",
            9,
            0.0,
            std::f64::consts::TAU,
            28.274_333_882_308_14,
        ),
        (
            "doors/hdf5/test_chunked_datasets_earliest.hdf5",
            None,
            "int/large_int8",
            100,
            0.0,
            99.0,
            4_950.0,
        ),
        (
            "doors/hdf5/test_compressed_chunked_datasets_latest.hdf5",
            None,
            "float/float32lzf(:,5)",
            7,
            4.0,
            34.0,
            133.0,
        ),
        (
            "doors/hdf5/test_compressed_chunked_datasets_latest.hdf5",
            None,
            "int/int32(:,2)",
            7,
            1.0,
            31.0,
            112.0,
        ),
        (
            "doors/hdf5/test_byteshuffle_compressed_datasets_earliest.hdf5",
            None,
            "float/float64(:,3)",
            7,
            2.0,
            32.0,
            119.0,
        ),
        (
            "doors/hdf5/fletcher32_datasets_latest.hdf5",
            None,
            "int/int8(:,4)",
            7,
            3.0,
            33.0,
            126.0,
        ),
        (
            "doors/hdf5/compound_datasets_earliest.hdf5",
            Some("3 samples"),
            "2d_chunked_compound(:,1).real",
            3,
            2.299_999_952_316_284,
            2.299_999_952_316_284,
            6.899_999_856_948_852_5,
        ),
        (
            "doors/hdf5/compound_datasets_earliest.hdf5",
            Some("4 samples"),
            "chunked_compound.vector(2)",
            4,
            2.0,
            74.099_998_474_121_1,
            -695.799_977_064_132_7,
        ),
        (
            "formats/labview_sample.lvm",
            Some("every 0.000586 s"),
            "accelerometer_base",
            12_375,
            0.203,
            -0.034_655,
            f64::NAN,
        ),
        (
            "formats/Sample_UFF58_ascii.uff",
            None,
            "response Mic 01 X",
            79_292,
            -0.014_755_3,
            -0.004_314_69,
            f64::NAN,
        ),
    ] {
        let options = RecordingOptions {
            stream: stream.map(str::to_owned),
            table: true,
            ..options(&[column])
        };
        let read = Recording::read(&reference_data().join(name), &options);
        let read = read.unwrap_or_else(|e| panic!("{name}: {e}, {:?}", e.hint()));
        let data = &read.columns[0].data;
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-8 * b.abs().max(1e-12);
        assert_eq!(data.len(), n, "{name}");
        assert!(close(data[0], first) && close(data[n - 1], last), "{name}");
        let scale: f64 = data.iter().map(|v| v.abs()).sum();
        assert!(
            sum.is_nan() || (data.iter().sum::<f64>() - sum).abs() <= 1e-8 * scale,
            "{name}"
        );
    }
}

/// The description and the file that it names are inputs, each with its digest.
#[test]
fn known_inputs_of_a_recording_in_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let description = r#"<unisens xmlns="http://www.unisens.org/unisens2.0">
        <signalEntry id="acc.bin" dataType="int16" sampleRate="64" lsbValue="0.5" unit="g">
        <binFileFormat/><channel name="x"/></signalEntry></unisens>"#;
    let place = folder.path().join("unisens.xml");
    std::fs::write(&place, description).unwrap();
    let beside = folder.path().join("acc.bin");
    let numbers: Vec<u8> = (0..200_i16).flat_map(i16::to_le_bytes).collect();
    std::fs::write(&beside, numbers).unwrap();
    let recording =
        Recording::from_source(Source::open(&place).unwrap(), &options(&["x"])).unwrap();
    assert_eq!(recording.columns[0].unit, Some(Unit::StandardGravity));
    assert_eq!(recording.columns[0].data[199], 99.5);
    let names: Vec<PathBuf> = recording
        .input()
        .files()
        .map(|f| f.path.clone().into())
        .collect();
    assert_eq!(names, [place.clone(), beside.clone()]);
    let own = proofmass_io::Input::of(&beside).unwrap();
    assert_eq!(recording.input().beside[0].sha256, own.sha256);
    // A copy elsewhere has nothing beside it.
    let other = tempfile::tempdir().unwrap();
    let alone = other.path().join("unisens.xml");
    std::fs::copy(&place, &alone).unwrap();
    let error = Recording::from_source(Source::open(&alone).unwrap(), &options(&["x"]));
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("\"acc.bin\", of which nothing lies beside it"),
        "{error}"
    );
}
