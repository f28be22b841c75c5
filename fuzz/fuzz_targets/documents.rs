//! Calibrations, results, manifests and tables: nothing panics, and what is read is written the same.

#![no_main]

use libfuzzer_sys::fuzz_target;
use proofmass_io::sheet::Sheet;
use proofmass_io::{CalibrationFile, Manifest, ResultDocument, Source};

fuzz_target!(|data: &[u8]| {
    if let Ok(file) = CalibrationFile::from_json(data) {
        let bytes = file.to_json().expect("finite");
        assert_eq!(CalibrationFile::from_json(&bytes).expect("our own"), file);
    }
    if let Ok(result) = ResultDocument::from_json(data)
        && let Ok(bytes) = result.to_json()
    {
        assert_eq!(ResultDocument::from_json(&bytes).expect("our own"), result);
    }
    if let Ok(manifest) = Manifest::from_json(data) {
        let bytes = manifest.to_json().expect("text");
        assert_eq!(Manifest::from_json(&bytes).expect("our own"), manifest);
    }
    let source = Source::from_bytes("fuzz", data).expect("memory");
    let _ = Sheet::from_source(source, "table");
});
