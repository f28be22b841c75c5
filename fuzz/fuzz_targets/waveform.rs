//! Raw floats, WAV and text as waveforms: nothing panics, forged sizes ask for no memory, what is read is finite.

#![no_main]

use libfuzzer_sys::fuzz_target;
use proofmass_io::{ColumnRef, Source, Waveform, WaveformFormat, WaveformOptions};

fuzz_target!(|data: &[u8]| {
    for format in [WaveformFormat::F32, WaveformFormat::Wav, WaveformFormat::Text] {
        let options = WaveformOptions {
            format,
            sampling_rate_hz: (format == WaveformFormat::F32).then_some(1000.0),
            channels: vec![("a".into(), ColumnRef::Index(1)), ("b".into(), ColumnRef::Index(2))],
            channel_count: 2,
            full_scale_v: Some(10.0),
            layout: Default::default(),
            unit: None,
        };
        let source = Source::from_bytes("fuzz", data).expect("memory");
        if let Ok(waveform) = Waveform::from_source(source, &options) {
            assert!(waveform.channels.iter().flatten().all(|v| v.is_finite()));
            assert!(waveform.sampling_rate_hz > 0.0);
        }
    }
});
