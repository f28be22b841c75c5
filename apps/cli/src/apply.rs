//! `proofmass apply`: compensated recording, streamed.

use crate::recording_arguments::RecordingArguments;
use crate::{Failure, Outcome, console};
use proofmass::core::{Matrix3, SensorModel};
use proofmass::io::{
    AtomicFile, CalibrationFile, Input, Layout, LayoutOptions, Provenance, Rewriter, RowReader,
    SigningKey, Source,
};
use std::path::{Path, PathBuf};

/// Compensate a recording with a calibration.
///
/// a = K⁻¹ (ã − b), row by row: a recording of any size needs no more memory than a small one. All other columns
/// are kept as they are. The same function runs in firmware.
#[derive(clap::Args)]
pub(crate) struct Apply {
    /// calibration.json written by `proofmass calibrate`
    calibration: PathBuf,
    /// Recording with uncompensated outputs; `-` is standard input
    recording: PathBuf,
    /// File for the compensated recording (CSV), replaced if it is there; `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace a file that `proofmass apply` did not write or that was changed since
    #[arg(long)]
    force: bool,
    /// Sign where the file came from with a private key (PEM, Ed25519), as `proofmass keygen` makes it
    #[arg(long, value_name = "KEY")]
    sign: Option<PathBuf>,
    #[command(flatten)]
    reading: RecordingArguments,
}

impl Apply {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let replaced = self.may_replace()?;
        let signer = self.sign.as_deref().map(SigningKey::read).transpose()?;
        let (calibration, calibration_input) =
            CalibrationFile::from_source(Source::open(&self.calibration)?)?;
        let sensor = SensorModel::new(Matrix3(calibration.k), calibration.b)?;
        let mut source = Source::open(&self.recording)?;
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let mut columns = Vec::with_capacity(3);
        let mut factors = [1.0; 3];
        let mut headings = Vec::with_capacity(3);
        for (axis, signal) in self.reading.signals(&calibration)?.iter().enumerate() {
            let index = layout
                .find(signal)
                .map_err(|e| Failure::from(e).detail(self.recording.display().to_string()))?;
            let name = layout.name(index);
            factors[axis] = self
                .reading
                .factor(&calibration, &name, layout.unit(index))?;
            columns.push(index);
            let bare = proofmass::io::split_heading(&name).0.replace(' ', "_");
            headings.push((index, format!("{bare}_{}", calibration.output_unit.ascii())));
        }

        let inputs = [self.recording.as_path(), self.calibration.as_path()];
        let mut reader = RowReader::new(source, layout.clone(), &columns)?.keep_text();
        let mut writer = Rewriter::create(&self.output, &layout, &headings, &inputs)?;
        let bar = console::progress(reader.size().unwrap_or(0), "compensating");
        let mut compensated: [Vec<f64>; 3] = Default::default();
        let (mut rows, mut beyond) = (0u64, 0u64);
        while let Some(block) = reader.next_block()? {
            for column in &mut compensated {
                column.clear();
            }
            for row in 0..block.rows() {
                let a = sensor.apply(std::array::from_fn(|i| factors[i] * block.column(i)[row]));
                for (column, value) in compensated.iter_mut().zip(a) {
                    column.push(value);
                }
                if let Some([low, high]) = calibration.acceleration_range {
                    // The range is that of a resting sensor: a tenth more is still at rest.
                    let margin = 0.1 * (high - low);
                    beyond += u64::from(a.iter().any(|v| *v < low - margin || *v > high + margin));
                }
            }
            let [x, y, z] = &compensated;
            writer.block(&block, &[x, y, z])?;
            rows += block.rows() as u64;
            bar.set_position(reader.bytes_read());
        }
        bar.finish_and_clear();
        for finding in reader.findings() {
            console::note(format!(
                "{}: {}; {}",
                finding.severity(),
                finding.what(),
                finding.evidence_text()
            ));
        }
        let provenance = writer.file().is_kept().then(|| writer.file().sha256());
        let recording_input = reader.finish()?;
        writer.settle()?;
        // Before the recording itself: a run that is killed in between leaves a recording that the next may replace.
        if let Some(sha256) = provenance {
            let mut provenance = Provenance::new(sha256, vec![recording_input, calibration_input]);
            provenance.replaces = replaced;
            if let Some(key) = &signer {
                provenance = provenance.signed(key);
            }
            let mut beside = AtomicFile::create(Provenance::place(&self.output), &inputs)?;
            beside.write_all(&provenance.to_json()?)?;
            beside.commit()?;
        }
        writer.commit()?;
        console::note(format!(
            "written: {} ({rows} samples, columns {})",
            self.output.display(),
            headings
                .iter()
                .map(|(_, h)| h.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        ));
        if beyond > 0 {
            let [low, high] = calibration.acceleration_range.unwrap_or_default();
            console::note(format!(
                "note: {beyond} samples lie beyond {low:.1} … {high:.1} m/s², where the calibration was tested; \
                 the model is extrapolated there"
            ));
        }
        Ok(Outcome::Done)
    }

    /// Whether what stands at the place may go: what an earlier run wrote there and nobody changed, or what the user says.
    /// Its digest, where something stands there.
    fn may_replace(&self) -> Result<Option<String>, Failure> {
        let regular = std::fs::metadata(&self.output).is_ok_and(|m| m.is_file() && m.len() > 0);
        if !regular || self.output == Path::new("-") {
            return Ok(None);
        }
        let there = Input::of(&self.output)?.sha256;
        let own = match Provenance::of(&self.output) {
            Ok(Some(provenance)) => provenance.wrote(&there),
            _ => false,
        };
        if self.force || own || console::asked(&format!("replace {}?", self.output.display())) {
            return Ok(Some(there));
        }
        Err(Failure::new(format!(
            "{} is there, and was not written by `proofmass apply` or was changed since",
            self.output.display()
        ))
        .hint("name another file, or replace it with --force"))
    }
}
