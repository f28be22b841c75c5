//! Text of any shape, plain or packed: nothing panics, and a recording that is read keeps what it promises.

#![no_main]

use libfuzzer_sys::fuzz_target;
use proofmass_io::{ColumnRef, Layout, LayoutOptions, Recording, RecordingOptions, Source, inspect_source};

fuzz_target!(|data: &[u8]| {
    let source = || Source::from_bytes("fuzz", data).expect("memory");
    let _ = inspect_source(source(), 10);
    let Ok(layout) = Layout::of(&mut source(), &LayoutOptions::default()) else {
        return;
    };
    for rate in [None, Some(100.0)] {
        let options = RecordingOptions {
            columns: vec![ColumnRef::Index(layout.columns)],
            time: rate.is_none().then_some(ColumnRef::Index(1)),
            sampling_rate_hz: rate,
            ..RecordingOptions::default()
        };
        let Ok(recording) = Recording::from_source(source(), &options) else {
            continue;
        };
        let n = recording.samples();
        assert!(recording.columns[0].data.iter().all(|v| v.is_finite()));
        assert!(recording.time.rate_hz() > 0.0 && recording.duration_s() > 0.0);
        for i in 1..n {
            assert!(recording.time.seconds(i) > recording.time.seconds(i - 1));
        }
    }
});
