//! Recordings of loggers and of LabVIEW in another format: the sums that other readers found.

use proofmass_io::{Recording, RecordingOptions, Source};
use proofmass_jobs::convert::{ConvertData, ConvertFormat, ConvertJob};
use proofmass_jobs::{Destination, Job, Unwatched};
use std::path::PathBuf;

/// File, its columns, rows, and the sums of three of them or fewer.
type Case = (&'static str, &'static [&'static str], usize, &'static [f64]);

/// By GGIRread, actipy and npTDMS.
const CASES: &[Case] = &[
    (
        "wearable/ggirread/ax3_testfile.cwa",
        &["acc_x", "acc_y", "acc_z"],
        17_400,
        &[13_530.468_75, 2_217.437_5, 5_079.046_875],
    ),
    (
        "wearable/ggirread/ax6_testfile.cwa",
        &["acc_x", "acc_y", "acc_z"],
        11_320,
        &[183.263_184, 2_386.895_020, 834.331_543],
    ),
    (
        "doors/tdms/03_waveform_complete.tdms",
        &["AC Voltage"],
        10_000,
        &[7.389_644_45e-13],
    ),
    (
        "doors/tdms/daqmx_accelerometers_scaled.tdms",
        &["ai0", "ai1"],
        10_000,
        &[619.558_867, 3_875.866_92],
    ),
];

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn crosscheck_sums_after_conversion() {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    let data = PathBuf::from(
        data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md"),
    );
    for (name, columns, rows, sums) in CASES {
        for to in [ConvertFormat::Csv, ConvertFormat::Npy] {
            let path = data.join(name);
            let mut job = ConvertJob::default();
            job.to = Some(to);
            job.without_units = true;
            job.reading.columns = Some(columns.iter().map(|c| (*c).into()).collect());
            let mut written = Vec::new();
            let open = || Source::open(&path);
            let given = ConvertData::new(vec![&open], Destination::Bytes(&mut written));
            let outcome = job
                .evaluate(&given, &Unwatched)
                .unwrap_or_else(|e| panic!("{name}: {e}, {:?}", e.hint()));
            drop(given);
            assert_eq!(outcome.rows(), *rows as u64, "{name}");
            // The time stands first.
            let options = RecordingOptions {
                columns: (2..columns.len() + 2).map(Into::into).collect(),
                table: true,
                ..RecordingOptions::default()
            };
            let source = Source::from_bytes("written", written).unwrap();
            let read = Recording::from_source(source, &options).unwrap();
            for (column, sum) in read.columns.iter().zip(*sums) {
                let own: f64 = column.data.iter().sum();
                let scale: f64 = column.data.iter().map(|v| v.abs()).sum();
                assert_eq!(column.data.len(), *rows);
                assert!((own - sum).abs() <= 1e-8 * scale, "{name}: {own} for {sum}");
            }
        }
    }
}
