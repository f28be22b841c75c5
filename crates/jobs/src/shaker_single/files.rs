//! From the files of a campaign to the job and its runs.

use super::{ShakerSingleFiles, ShakerSingleJob, ShakerSingleRun};
use crate::bench_runs::BenchFiles;
use crate::campaign::{Certificate, ShakerSingleCampaign};
use crate::device_output::DeviceOutput;
use crate::observed::{SensorFiles, observe, of_channel};
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_shaker::sample_clock::SampleClock;
use proofmass_shaker::single_axis::{ComparisonBudget, ComparisonRow};
use proofmass_uncertainty::DegreesOfFreedom;

impl ShakerSingleCampaign {
    /// Reads the tables of the campaign and its recordings.
    ///
    /// # Errors
    /// A file that cannot be read, a recording without a sine, or `watch` wanted it to stop.
    pub fn load(&self, watch: &dyn Watch) -> Result<ShakerSingleFiles> {
        let mut table = self.read_runs()?;
        let certificate = Certificate::of_reference(&self.source, self.reference.as_ref())?;
        // Of several devices and a check standard this result is about one.
        let names = self.channels();
        let sensor = SensorFiles::of(&self.source, self.output_recording.as_ref(), &names)?;
        let observed = observe(
            &mut table,
            self.recording.as_ref(),
            || self.waveform_options(),
            sensor,
            watch,
        )?;
        let name = table.path.display().to_string();
        let own = names.iter().position(|n| *n == self.channel).unwrap_or(1);
        let check = self
            .check_standard
            .as_ref()
            .and_then(|c| names.iter().position(|n| *n == c.channel));
        let runs = table
            .runs
            .iter()
            .zip(&observed.runs)
            .map(|(run, seen)| ShakerSingleRun {
                row: ComparisonRow {
                    run: run.run.clone(),
                    frequency: run.frequency_hz,
                    reference: seen.phasors[0],
                    output: seen.phasors[own],
                    transverse: run.seat.transverse,
                    covariance: [seen.covariances[0], seen.covariances[own]],
                },
                check: check.map(|k| (seen.phasors[k], seen.covariances[k])),
                target: run.seat.target,
                quality: of_channel(&seen.quality(None), own),
                place: format!("{name}:{}", run.line),
            })
            .collect();
        // What the devices give that record by themselves; the others give volts, or what the table says.
        let in_sensor = |k: usize| {
            let sensor = self.output_recording.as_ref();
            sensor.filter(|s| s.channels.contains_key(names[k]))
        };
        let output_of = |k: usize| match in_sensor(k) {
            Some(sensor) => sensor.output(&self.source),
            None => Ok(DeviceOutput::of(table.quantities.get(k).copied())),
        };
        let clock = in_sensor(own).map(|s| s.clock);
        let delay = |channel: &str| {
            let recording = self.recording.as_ref();
            recording.map_or(0.0, |r| r.delay_uncertainty(channel))
        };
        let reading = &self.reading;
        let budget = ComparisonBudget {
            ratio: reading.u_relative,
            phase: reading.u_phase_deg.to_radians(),
            dof: reading
                .dof
                .and_then(DegreesOfFreedom::new)
                .unwrap_or(DegreesOfFreedom::INFINITE),
            transverse: self.transverse.map(|t| t.shares()),
            front_end: delay("reference").hypot(delay(names[own])),
            free_phase: clock == Some(SampleClock::Own),
        };
        let mut findings = Vec::new();
        let mut inputs = vec![self.source.input.clone()];
        let mut job = ShakerSingleJob::new(None, budget);
        if let Some(certificate) = certificate {
            findings.extend(certificate.findings);
            inputs.push(certificate.input);
            job.reference = Some(certificate.table);
            job.reference_description = certificate.description;
        }
        job.output = output_of(own)?;
        job.sample_clock = clock;
        if let Some(k) = check {
            if in_sensor(k).is_some() {
                return Err(Trouble::data(format!(
                    "{}: the check standard is a channel of the bench",
                    self.source.path.display()
                ))
                .with_hint("name its channel in [recording]"));
            }
            job.check_output = output_of(k)?;
            if let Some(certificate) = self.read_check_standard(job.check_output)? {
                findings.extend(certificate.findings);
                inputs.push(certificate.input);
                job.check_standard = Some(certificate.table);
            }
        }
        let datasheet = self.datasheet.as_ref().map(|d| d.si(&self.source));
        if let Some((output, datasheet)) = datasheet.transpose()? {
            if output != job.output {
                return Err(Trouble::data(format!(
                    "[datasheet] is in {}, and the device gives {}",
                    output.unit(),
                    job.output.unit()
                ))
                .detail(self.source.path.display().to_string())
                .with_hint("state unit in [datasheet] in what the device gives per m/s² or g"));
            }
            job.datasheet = Some(datasheet);
        }
        job.excluded = table.excluded(&self.runs.exclude);
        job.coverage_factor = self.method.coverage_factor;
        let said = (findings, inputs);
        Ok(BenchFiles::new((job, runs), &table.path, said, observed))
    }

    /// What the result is filed with.
    pub fn record(&self, files: &ShakerSingleFiles, date: Option<String>) -> Record {
        self.filed(date, files.inputs.clone())
    }
}
