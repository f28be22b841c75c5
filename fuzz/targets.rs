//! What every target does with its bytes: nothing panics, nothing takes long, and what is accepted keeps its promises.
//!
//! The fuzzer (`fuzz_targets/`) and the mutation tests of the workspace (`crates/jobs/tests/mutations.rs`) call the same
//! functions.

use proofmass_core::Watch;
use proofmass_documents::{
    CalibrationFile, DigitalCertificate, GmshMesh, ResultDocument, read_budget, read_model,
};
use proofmass_io::formats::Container;
use proofmass_io::sheet::Sheet;
use proofmass_io::{
    ColumnRef, Layout, LayoutOptions, Manifest, Provenance, Recording, RecordingOptions,
    SegmentRow, Source, Waveform, WaveformFormat, WaveformOptions, inspect_source,
};
use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::{Memory, StoredResult};
use proofmass_uncertainty::{Evaluate, Expression, Trials};
use std::io::Cursor;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

fn source(data: &[u8]) -> Source {
    Source::from_bytes("fuzz", data).expect("memory")
}

/// Text of any shape, plain or packed, with time stamps of any kind.
pub fn recording(data: &[u8]) {
    let _ = inspect_source(source(data), &RecordingOptions::default(), 10);
    let Ok(layout) = Layout::of(&mut source(data), &LayoutOptions::default()) else {
        return;
    };
    for rate in [None, Some(100.0)] {
        let options = RecordingOptions {
            columns: vec![ColumnRef::Index(layout.columns)],
            time: rate.is_none().then_some(ColumnRef::Index(1)),
            sampling_rate_hz: rate,
            ..RecordingOptions::default()
        };
        let Ok(recording) = Recording::from_source(source(data), &options) else {
            continue;
        };
        let n = recording.samples();
        assert!(recording.columns[0].data.iter().all(|v| v.is_finite()));
        assert!(recording.time.rate_hz() > 0.0 && recording.duration_s() > 0.0);
        for i in 1..n {
            assert!(recording.time.seconds(i) > recording.time.seconds(i - 1));
        }
        if let Ok((segments, _)) = SegmentRow::from_source(source(data), &recording) {
            assert!(segments.iter().all(|s| s.start < s.end && s.end <= n));
        }
    }
}

/// Raw floats, WAV and text as waveforms: forged sizes ask for no memory.
pub fn waveform(data: &[u8]) {
    for format in [
        WaveformFormat::F32,
        WaveformFormat::Wav,
        WaveformFormat::Text,
    ] {
        let options = WaveformOptions {
            format,
            sampling_rate_hz: (format == WaveformFormat::F32).then_some(1000.0),
            channels: vec![
                ("a".into(), ColumnRef::Index(1)),
                ("b".into(), ColumnRef::Index(2)),
            ],
            channel_count: 2,
            full_scale_v: Some(10.0),
            ..WaveformOptions::default()
        };
        if let Ok(waveform) = Waveform::from_source(source(data), &options) {
            assert!(waveform.channels.iter().flatten().all(|v| v.is_finite()));
            assert!(waveform.sampling_rate_hz > 0.0);
            let late = waveform.times.iter().flat_map(|t| &t.late_s);
            assert!(late.into_iter().all(|v| v.is_finite()));
        }
    }
}

/// Recordings of other formats: whatever is accepted gives as many numbers as it says.
pub fn streams(data: &[u8]) {
    let open = || Container::open(Box::new(Cursor::new(data.to_vec())));
    let Ok(container) = open() else { return };
    for stream in 0..container.streams().len().min(4) {
        let about = &container.streams()[stream];
        let (count, total) = (about.channels.len().min(64), about.rows);
        let chosen: Vec<usize> = (0..count).collect();
        let container = open().expect("it was opened");
        let mut rows = container.rows(stream, &chosen).expect("it is there");
        let mut block = vec![Vec::new(); count];
        let mut seen = 0;
        while let Ok(n) = rows.next_block(&mut block) {
            assert!(block.iter().all(|column| column.len() == n));
            seen += n as u64;
            if n == 0 {
                assert_eq!(seen, total);
                break;
            }
        }
    }
    let _ = inspect_source(source(data), &RecordingOptions::default(), 10);
}

/// Calibrations, results, manifests, provenances, tables, meshes: what is read is written the same.
pub fn documents(data: &[u8]) {
    if let Ok(file) = CalibrationFile::from_json(data) {
        let bytes = file.to_json().expect("finite");
        assert_eq!(CalibrationFile::from_json(&bytes).expect("our own"), file);
        let outputs: [&[f64]; 3] = [&[1.0], &[2.0], &[3.0]];
        let model = file.compensation().expect("what was checked");
        let _ = model.apply_columns(&outputs[..file.axes()], None);
    }
    if let Ok(result) = ResultDocument::from_json(data)
        && let Ok(bytes) = result.to_json()
    {
        assert_eq!(ResultDocument::from_json(&bytes).expect("our own"), result);
    }
    if let Ok(manifest) = Manifest::from_json(data) {
        let bytes = manifest.to_json().expect("text");
        assert_eq!(Manifest::from_json(&bytes).expect("our own"), manifest);
        if let Some(signature) = &manifest.signature {
            let _ = signature.signer(&manifest.statement());
        }
    }
    if let Ok(provenance) = Provenance::from_json(data) {
        let bytes = provenance.to_json().expect("text");
        assert_eq!(Provenance::from_json(&bytes).expect("our own"), provenance);
    }
    if let Ok(certificate) = DigitalCertificate::from_source(source(data)) {
        let all = certificate.quantities.iter().flat_map(|q| &q.values);
        assert!(all.into_iter().all(|v| v.is_finite()));
        if let Ok(table) = certificate.sensitivity(None) {
            assert!(!table.rows.is_empty());
            let sound = |v: f64| v.is_finite() && v >= 0.0;
            for row in &table.rows {
                assert!(row.frequency > 0.0 && row.sensitivity > 0.0);
                assert!(sound(row.sensitivity_uncertainty));
                assert!(row.phase.is_none_or(|[p, u]| p.is_finite() && sound(u)));
            }
        }
    }
    let _ = Sheet::from_source(source(data), "table");
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = GmshMesh::parse(text, std::path::Path::new("fuzz"));
    }
}

/// A result of any kind: what is read is rendered, and its files are files.
pub fn results(data: &[u8]) {
    let Ok(result) = StoredResult::from_json(data) else {
        return;
    };
    let _ = result.summary();
    if let Ok(files) = result.files() {
        for (name, _) in files {
            assert!(!name.contains(['/', '\\', '\0']) && name != "..", "{name}");
        }
    }
}

/// The language of models: budgets, formulas, their evaluation.
pub fn model(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let names = ["a", "b", "c"];
    if let Ok(formula) = Expression::parse(text, &names) {
        for x in [[0.0; 3], [1.0, 2.0, 3.0], [-1e300, 1e-300, f64::MAX]] {
            let _: f64 = formula.evaluate(&x);
        }
    }
    let _ = read_budget(text);
    if let Ok(model) = read_model(text) {
        let options = Evaluate {
            trials: Trials::Fixed(10_000),
            ..Evaluate::default()
        };
        let _ = model.evaluate(&options, &mut |_| ControlFlow::Continue(()));
    }
}

/// An onlooker that stops every calculation soon.
#[derive(Default)]
struct Impatient(AtomicU64);

impl Watch for Impatient {
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        match self.0.fetch_add(1, Ordering::Relaxed) {
            0..200 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        }
    }
}

/// A campaign of any kind, with files of every kind beside it.
pub fn campaign(data: &[u8]) {
    let store = FILES.iter().fold(Memory::new(), |store, (name, text)| {
        store.file(*name, *text)
    });
    let store = store.file("campaign.toml", data);
    let Ok(campaign) = Campaign::read(Arc::new(store), "campaign.toml") else {
        return;
    };
    let watch = Impatient::default();
    match campaign {
        Campaign::MultiPosition(campaign) => {
            let _ = campaign.load(&watch);
        }
        Campaign::FreeLiving(campaign) => {
            let _ = campaign.load(&watch);
        }
        Campaign::ShakerTriaxial(campaign) => {
            let _ = campaign.load(&watch);
            let _ = campaign.plan_job(160.0);
        }
        Campaign::ShakerSingle(campaign) => {
            let _ = campaign.load(&watch);
        }
        Campaign::ShakerPrimary(campaign) => {
            let _ = campaign.load(&watch);
        }
        Campaign::SpuriousMotion(campaign) => {
            let _ = campaign.load(&watch);
        }
        _ => {}
    }
}

/// Files that a campaign of the corpus names.
const FILES: [(&str, &[u8]); 7] = [
    ("recording.csv", include_bytes!("corpus/recording/rests.csv")),
    (
        "runs.csv",
        include_bytes!("../examples/published-triaxial/runs.csv"),
    ),
    (
        "reference.csv",
        include_bytes!("../examples/published-triaxial/reference.csv"),
    ),
    (
        "budget.toml",
        include_bytes!("../examples/published-triaxial/budget.toml"),
    ),
    (
        "plan.csv",
        include_bytes!("../examples/published-triaxial/plan.csv"),
    ),
    (
        "single.csv",
        b"run,frequency_Hz,reference_mV,reference_phase_deg,output_mV,output_phase_deg\n\
          a,10,100,0,99,1\nb,10,100,0,98,1\nc,20,100,0,99,2\nd,20,100,5,99,7\n",
    ),
    (
        "spurious.csv",
        b"run,frequency_Hz,inclination_deg,axis,reference_m/s2,reference_phase_deg,velocity_mm/s,velocity_phase_deg\n\
          a,10,0,x,10,0,1,9\nb,10,0,x,10,0,1.1,8\nc,10,0,y,10,0,2,3\nd,10,0,y,10,0,2,4\n\
          e,10,0,z,10,0,159,90\nf,10,0,z,10,0,159,90\n",
    ),
];
