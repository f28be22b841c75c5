//! The analysis of a recording larger than memory.

use crate::allan_covariance::degrees_of_freedom;
use crate::averages::Averages;
use crate::{
    Analysis, AnalysisOptions, DeviationCurve, NoiseBasis, NoiseChannel, NoiseModel, Sensor,
    Statistic, StreamingAllan, Taus, analyse, chi_square_interval, in_units, kalman_noise,
    state_space,
};
use proofmass_core::Error;

/// Averages kept of each channel.
const KEPT: usize = 1 << 20;

/// What a channel of a [`LongRecord`] is.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelName {
    /// Name as in the recording.
    pub name: String,
    /// What it measures, for conversion to the units in use.
    pub sensor: Option<Sensor>,
    /// Unit of the samples (SI), as printed.
    pub unit: String,
}

/// A recording that arrives in pieces and is never held as a whole.
///
/// Of every channel three things grow with it, none of them with its length: the overlapping Allan deviation at octave
/// averaging times ([`StreamingAllan`], logarithmic memory), the mean and the scatter, and a record of at most 2^20
/// averages of 2^k samples, of which spectrum, coefficients and disturbances are taken. The fit allows for what averaging does
/// to the densities; disturbances shorter than one average are not sought.
///
/// ```
/// use proofmass_noise::{AnalysisOptions, ChannelName, LongRecord, NoiseModel, Term, simulate};
/// use rand::SeedableRng;
///
/// let names = vec![ChannelName { name: "x".into(), sensor: None, unit: "V".into() }];
/// let mut record = LongRecord::new(names);
/// let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(4);
/// let model = NoiseModel { white: 1.0e-3, ..Default::default() };
/// for _ in 0..20 {
///     record.push(&[&simulate(&model, 1000, 100.0, &mut rng).unwrap()]).unwrap();
/// }
/// let analysis = record.analyse(100.0, &AnalysisOptions::default()).unwrap();
/// assert_eq!(analysis.channels[0].samples, 20_000);
/// let fit = analysis.channels[0].whittle.as_ref().unwrap();
/// assert!((fit.value(Term::White).unwrap() / 1.0e-3 - 1.0).abs() < 0.03);
/// ```
#[derive(Clone, Debug)]
pub struct LongRecord {
    names: Vec<ChannelName>,
    channels: Vec<Running>,
    gaps: usize,
}

#[derive(Clone, Debug)]
struct Running {
    allan: StreamingAllan,
    averages: Averages,
    /// Samples, mean and sum of squared departures from it.
    moments: (f64, f64, f64),
}

impl LongRecord {
    /// An empty record of these channels.
    pub fn new(names: Vec<ChannelName>) -> Self {
        let running = Running {
            allan: StreamingAllan::of_samples(),
            averages: Averages::new(KEPT),
            moments: (0.0, 0.0, 0.0),
        };
        Self {
            channels: vec![running; names.len()],
            names,
            gaps: 0,
        }
    }

    /// Takes in a piece of any length, one slice per channel.
    ///
    /// **Errors** [`Error::Length`] for slices of different length or another number of them, [`Error::NotFinite`]
    /// with the index in the piece; nothing of that piece is taken in.
    pub fn push(&mut self, piece: &[&[f64]]) -> Result<(), Error> {
        let wrong = |name, expected, got| Error::Length {
            name,
            expected,
            got,
        };
        if piece.len() != self.channels.len() {
            return Err(wrong("channels", self.channels.len(), piece.len()));
        }
        for samples in piece {
            if samples.len() != piece[0].len() {
                return Err(wrong("channel", piece[0].len(), samples.len()));
            }
            crate::record::check_finite("rate", samples)?;
        }
        for (running, samples) in self.channels.iter_mut().zip(piece) {
            running.allan.push(samples)?;
            running.averages.push(samples);
            running.add_moments(samples);
        }
        Ok(())
    }

    /// Samples are missing here: no statistic reaches across.
    pub fn gap(&mut self) {
        self.gaps += 1;
        for running in &mut self.channels {
            running.allan.gap();
            running.averages.gap();
        }
    }

    /// Samples of each channel so far.
    pub fn samples(&self) -> u64 {
        self.channels.first().map_or(0, |c| c.allan.samples())
    }

    /// What [`analyse`] finds, with the curve of all samples.
    ///
    /// **Errors** as [`analyse`]; [`Error::OutOfRange`] for another statistic than OADEV or other averaging times than
    /// octaves, which a stream does not have.
    pub fn analyse(&self, sample_rate: f64, options: &AnalysisOptions) -> Result<Analysis, Error> {
        let octaves = options.statistic == Statistic::OverlappingAllan
            && options.further.is_empty()
            && options.deviation.taus == Taus::Octave;
        if !octaves {
            return Err(Error::OutOfRange {
                name: "statistics or averaging times beyond the octaves of OADEV",
                value: 1.0,
                min: 0.0,
                max: 0.0,
            });
        }
        let averaged = self.channels.first().map_or(1, |c| c.averages.factor());
        let channels: Vec<NoiseChannel<'_>> = self
            .names
            .iter()
            .zip(&self.channels)
            .map(|(name, running)| NoiseChannel {
                name: &name.name,
                sensor: name.sensor,
                unit: &name.unit,
                rate: running.averages.values(),
            })
            .collect();
        let mut averaged_options = options.clone();
        averaged_options.fit.averaged *= averaged;
        let mut analysis = analyse(
            &channels,
            None,
            sample_rate / averaged as f64,
            &averaged_options,
        )?;
        analysis.sample_rate = sample_rate;
        analysis.averaged = averaged;
        analysis.rows = (analysis.rows.0 * averaged, analysis.rows.1 * averaged);
        for run in &mut analysis.stretches {
            *run = (run.0 * averaged, run.1 * averaged);
        }
        for gap in &mut analysis.gaps {
            gap.row *= averaged;
            gap.rows *= averaged;
        }
        for ((channel, running), name) in analysis
            .channels
            .iter_mut()
            .zip(&self.channels)
            .zip(&self.names)
        {
            let (n, mean, squares) = running.moments;
            channel.samples = n as usize;
            channel.mean = mean;
            channel.standard_deviation = (squares / (n - 1.0)).sqrt();
            for d in &mut channel.disturbances {
                d.samples = (d.samples.0 * averaged, d.samples.1 * averaged);
            }
            if channel.curve.is_some() {
                let mut curve = running
                    .allan
                    .curve_at(sample_rate, options.deviation.probability)?;
                if let Some(fit) = &channel.whittle {
                    of_the_model(&mut curve, &fit.model, n as usize);
                    let mut band = fit.band;
                    if averaged > 1 {
                        // What shapes the averages is not what shapes the samples.
                        band.front_end = None;
                        band.described_to = band.highest_frequency;
                    }
                    channel.fitted = crate::consistency::fitted(&fit.model, &band, &curve);
                }
                channel.curve = Some(curve);
            }
            // What belongs to one sample belongs to one of the recording, not to one average.
            if let Some(fit) = &channel.whittle {
                channel.kalman = Some(kalman_noise(fit, sample_rate)?);
                channel.states = Some(state_space(fit, sample_rate, n / sample_rate)?);
            }
            if let Some(sensor) = name.sensor {
                for term in &mut channel.units {
                    if let Some(first) = term.units.first() {
                        term.units = in_units(term.term, first.value, sensor, sample_rate);
                    }
                }
            }
        }
        if averaged > 1 {
            analysis.findings.push(proofmass_uncertainty::findings::averaged_record(
                "spectrum, coefficients and disturbances are those of averages; the Allan curve is that of all samples",
                &format!(
                    "averages of {averaged} samples, {} Hz",
                    sample_rate / averaged as f64
                ),
                "the fit allows for the averaging; analyse a shorter part for frequencies above half of this rate",
            ));
        }
        Ok(analysis)
    }

    /// The averages of a channel that were analysed, for a plot against time.
    pub fn averages(&self, channel: usize) -> &[f64] {
        self.channels
            .get(channel)
            .map_or(&[], |c| c.averages.values())
    }
}

/// Degrees of freedom of the fitted noise in place of those of the slope: every (m/8)-th difference costs 1 % of them.
fn of_the_model(curve: &mut DeviationCurve, model: &NoiseModel, samples: usize) {
    for p in &mut curve.points {
        let nu = degrees_of_freedom(model, p.factor, &[samples], curve.sample_rate);
        if let Some(nu) = nu.map(|nu| 0.99 * nu) {
            p.basis = NoiseBasis::Model;
            p.edf = Some(nu);
            p.interval = chi_square_interval(p.deviation, nu, curve.probability);
        }
    }
}

impl Running {
    /// Mean and squares of a piece joined to those so far.
    fn add_moments(&mut self, samples: &[f64]) {
        if samples.is_empty() {
            return;
        }
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let squares: f64 = samples.iter().map(|v| (v - mean) * (v - mean)).sum();
        let (before, old_mean, old_squares) = self.moments;
        let all = before + n;
        let step = mean - old_mean;
        self.moments = (
            all,
            old_mean + step * n / all,
            old_squares + squares + step * step * before * n / all,
        );
    }
}
