//! A recorded acceleration held against a required density: what it says, on page and in files.

use crate::findings;
use crate::page::columns::filed;
use crate::trouble::{Result, Trouble};
use proofmass_dynamic::required_density::{
    DensityComparison, DensityLine, DensityVerdict, RequiredDensity,
};
use proofmass_report::number::{plain, two_digits};
use proofmass_report::plot::{Axis, Series, XyPlot};
use proofmass_report::{Section, Table};
use proofmass_signal::Welch;
use proofmass_uncertainty::Finding;
use serde::Serialize;

/// A record beside what is required of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct JudgedDensity {
    /// What is required.
    pub name: String,
    /// Which channel was judged.
    pub channel: String,
    /// The answer.
    pub comparison: DensityComparison,
    /// Length of the record, s.
    pub duration: f64,
}

/// Distance of the lines where nobody says it, Hz, or half of the lowest frequency.
const RESOLUTION: f64 = 5.0;

impl JudgedDensity {
    /// By Welch's density with a Hann window and half overlap; `relative` is the relative standard uncertainty of the acceleration.
    pub(crate) fn of(
        required: &RequiredDensity,
        (name, record): (&str, &[f64]),
        rate: f64,
        resolution: Option<f64>,
        relative: f64,
    ) -> Result<Self> {
        required.check()?;
        let [low, high] = required.band();
        let width = resolution.unwrap_or(RESOLUTION.min(0.5 * low));
        if !(width > 0.0 && width.is_finite()) {
            return Err(Trouble::request(format!(
                "lines {width} Hz apart are impossible: the resolution is above zero"
            ))
            .with_hint("give --resolution in Hz, above zero"));
        }
        let lines = (0.5 * rate / width).round();
        if !(lines >= 4.0 && 2.0 * lines <= record.len() as f64) {
            return Err(Trouble::data(format!(
                "the record of {:.3} s at {rate} samples/s has no lines {width} Hz apart",
                record.len() as f64 / rate
            ))
            .with_hint("record for longer, or give --resolution HZ for lines further apart"));
        }
        if !(0.5 * rate > low) {
            return Err(Trouble::data(format!(
                "{name} is sampled at {rate} samples/s, and the required spectrum begins at {low} Hz"
            ))
            .with_hint(format!("sample at more than {:.0} per second", 2.0 * high)));
        }
        let density = Welch::new(2 * lines as usize).density(record, rate)?;
        Ok(Self {
            name: required.name.clone(),
            channel: name.to_owned(),
            comparison: required.judge(&density, relative)?,
            duration: record.len() as f64 / rate,
        })
    }

    /// The doubt, where the answer is not yes.
    pub(crate) fn finding(&self) -> Option<Finding> {
        match &self.comparison.verdict {
            DensityVerdict::Beyond {
                frequency,
                by,
                lines,
                ..
            } => Some(findings::spectrum_beyond(
                &self.name,
                *by,
                *frequency,
                *lines,
                self.comparison.lines.len(),
            )),
            DensityVerdict::NotShown { lines, .. } => Some(findings::spectrum_not_shown(
                &self.name,
                *lines,
                self.comparison.lines.len(),
                &self.remedy(),
            )),
            _ => None,
        }
    }

    /// What would show it.
    fn remedy(&self) -> String {
        let DensityVerdict::NotShown {
            longer, reached, ..
        } = &self.comparison.verdict
        else {
            return String::new();
        };
        let [low, high] = reached;
        let reach = format!("the record shows {} Hz to {} Hz", plain(*low), plain(*high));
        match *longer {
            times if times > 1.0 && times < 1e6 => format!(
                "{reach}; at the required level {} s would show it, or lines further apart (--resolution)",
                two_digits(times * self.duration)
            ),
            times if times <= 1.0 => format!(
                "{reach}; its length would show the required level: the estimate itself is near a limit, or frequencies are missing"
            ),
            _ => format!("{reach}; give the tolerance more room"),
        }
    }

    /// The answer in words.
    pub(crate) fn verdict(&self) -> String {
        let c = &self.comparison;
        let all = c.lines.len();
        match &c.verdict {
            DensityVerdict::Inside { frequency, margin } => format!(
                "The spectrum is inside {}: all {all} lines lie within their tolerance with their intervals (95 % together). Nearest to a limit is {} Hz, by {margin:.1} dB.",
                self.name,
                plain(*frequency)
            ),
            DensityVerdict::Beyond {
                frequency,
                by,
                interval,
                lines,
            } => {
                let (side, sign) = match *by > 0.0 {
                    true => ("above the upper limit", 1.0),
                    false => ("below the lower limit", -1.0),
                };
                let [mut low, mut high] = interval.map(|d| sign * d);
                if low > high {
                    (low, high) = (high, low);
                }
                format!(
                    "The spectrum is beyond {}: at {} Hz by {:.1} dB ({low:.1} dB to {high:.1} dB) {side}; {lines} of {all} lines are beyond.",
                    self.name,
                    plain(*frequency),
                    by.abs()
                )
            }
            DensityVerdict::NotShown {
                lines,
                frequency,
                margin,
                ..
            } => format!(
                "Whether the spectrum keeps {} is not shown: the intervals of {lines} of {all} lines reach over a limit, at {} Hz the estimate is {:.1} dB {} it; {}.",
                self.name,
                plain(*frequency),
                margin.abs(),
                if *margin < 0.0 { "beyond" } else { "within" },
                self.remedy()
            ),
            _ => String::new(),
        }
    }

    /// Spectrum, limits and intervals.
    pub(crate) fn section(&self) -> Section {
        let c = &self.comparison;
        let of = |f: fn(&DensityLine) -> f64| -> Vec<f64> { c.lines.iter().map(f).collect() };
        let frequency = of(|l| l.frequency);
        let positive = |y: Vec<f64>| -> Vec<f64> { y.iter().map(|v| v.max(1e-30)).collect() };
        let required = of(|l| l.required);
        let (low, high) = (of(|l| l.limits[0]), of(|l| l.limits[1]));
        let (from, to) = (
            positive(of(|l| l.interval[0])),
            positive(of(|l| l.interval[1])),
        );
        let measured = positive(of(|l| l.measured));
        let plot = XyPlot::new(
            Axis::log("frequency", "Hz"),
            Axis::log("density", "(m/s²)²/Hz"),
        )
        .series(
            Series::line("required, with its tolerance", &frequency, &required).band(&low, &high),
        )
        .series(
            Series::line("measured, with its interval", &frequency, &measured).band(&from, &to),
        );
        let [rms, u, wanted] = c.rms;
        Section::new("Required spectrum")
            .paragraph(format!(
                "Welch's density of {} in lines {} Hz apart, with {:.0} degrees of freedom each. The intervals hold for all lines together \
                 in 95 of 100 Gaussian records. In the common band the RMS is {} m/s² with U = {} m/s² (k = 1.96, 95 %); {} m/s² is required.",
                self.channel,
                plain(c.resolution),
                c.dof,
                proofmass_report::scientific(rms, 4),
                two_digits(1.96 * u),
                proofmass_report::scientific(wanted, 4),
            ))
            .figure("The measured spectrum beside the required one", plot)
    }

    /// Line by line.
    pub(crate) fn table(&self) -> Table {
        let fields = vec![
            filed("frequency_Hz", |l: &DensityLine| l.frequency),
            filed("density_(m/s2)2/Hz", |l: &DensityLine| l.measured),
            filed("low_(m/s2)2/Hz", |l: &DensityLine| l.interval[0]),
            filed("high_(m/s2)2/Hz", |l: &DensityLine| l.interval[1]),
            filed("required_(m/s2)2/Hz", |l: &DensityLine| l.required),
            filed("lower_limit_(m/s2)2/Hz", |l: &DensityLine| l.limits[0]),
            filed("upper_limit_(m/s2)2/Hz", |l: &DensityLine| l.limits[1]),
        ];
        Table::of("", fields, &self.comparison.lines).file("required_spectrum.csv")
    }
}
