//! The polynomials of a subchannel as one scaling.

use super::Signal;
use super::properties::{Other, Polynomial, Properties};
use crate::Result;
use crate::raw::Window;
use crate::scaling::{From, Scaling, Step};
use crate::stream::{Remark, SeekRead};
use std::collections::BTreeMap;

/// The scaling of a subchannel.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) scaling: Scaling,
    /// Words for what it was taken at.
    pub(super) at: Option<String>,
}

impl Default for Found {
    fn default() -> Self {
        Self {
            scaling: Scaling::none(),
            at: None,
        }
    }
}

pub(super) struct Calibrations<'a> {
    properties: &'a Properties,
    signals: &'a BTreeMap<u64, Signal>,
    /// Means of the subchannels that polynomials take; `None` of those that have no samples.
    means: BTreeMap<(u64, u64), Option<f64>>,
    pub(super) remarks: Vec<Remark>,
}

impl<'a> Calibrations<'a> {
    pub(super) fn new(properties: &'a Properties, signals: &'a BTreeMap<u64, Signal>) -> Self {
        Self {
            properties,
            signals,
            means: BTreeMap::new(),
            remarks: Vec::new(),
        }
    }

    /// The polynomial of the channel, and that of the subchannel of its result.
    pub(super) fn scaling(
        &mut self,
        file: &mut dyn SeekRead,
        channel: u64,
        field: u64,
    ) -> Result<Found> {
        let mut found = Found::default();
        let mut chain = Chain::default();
        let polynomials = self.named(channel, field);
        for polynomial in polynomials {
            let polynomial = match polynomial {
                Ok(polynomial) => polynomial,
                Err(number) => {
                    let name = self.name(channel, field);
                    // Numbers without their calibration are no small matter.
                    self.remarks.push(Remark::damaged(format!(
                        "calibration {number} of {name} is not in the file, and not applied"
                    )));
                    continue;
                }
            };
            let Some(other) = polynomial.other else {
                chain.one(polynomial);
                continue;
            };
            let mean = match self.means.get(&(other.channel, other.subchannel)) {
                Some(mean) => *mean,
                None => {
                    let mean = self.mean(file, other)?;
                    self.means.insert((other.channel, other.subchannel), mean);
                    mean
                }
            };
            let name = self.name(other.channel, other.subchannel);
            if mean.is_none() {
                let of = self.name(channel, field);
                self.remarks.push(Remark::passed_over(format!(
                    "the calibration of {of} depends on {name}, which has no samples: it is taken at its reference, {}",
                    other.reference
                )));
            }
            let at = mean.unwrap_or(other.reference);
            found.at = Some(format!(" at {name} = {at:.3}"));
            chain.two(polynomial, other, at);
        }
        found.scaling = chain.scaling();
        Ok(found)
    }

    /// The polynomials that a subchannel names, or the number of the one that is not there.
    fn named(&self, channel: u64, field: u64) -> Vec<Result<&'a Polynomial, u64>> {
        let Some(about) = self.properties.channels.get(&channel) else {
            return Vec::new();
        };
        let own = about.subchannels.get(&field).and_then(|s| s.calibration);
        let numbers = about.calibration.into_iter().chain(own);
        let find = |number| self.properties.calibrations.get(&number).ok_or(number);
        numbers.map(find).collect()
    }

    fn name(&self, channel: u64, field: u64) -> String {
        let about = self.properties.channels.get(&channel);
        let name = about.and_then(|c| c.subchannels.get(&field)?.name.clone());
        name.unwrap_or_else(|| format!("channel {channel}.{field}"))
    }

    /// Mean of a subchannel, scaled; it has no second variable itself.
    fn mean(&self, file: &mut dyn SeekRead, other: Other) -> Result<Option<f64>> {
        let raw = self.signals.get(&other.channel);
        let field = usize::try_from(other.subchannel).ok();
        let Some(raw) = raw.and_then(|s| s.raws.get(field?)) else {
            return Ok(None);
        };
        let mut chain = Chain::default();
        for polynomial in self.named(other.channel, other.subchannel) {
            match polynomial {
                Ok(polynomial) if polynomial.other.is_none() => chain.one(polynomial),
                _ => return Ok(None),
            }
        }
        let scaling = chain.scaling();
        let mut raw = raw.clone();
        raw.rewind();
        let mut window = Window::default();
        let (mut sum, mut count) = (0.0, 0_u64);
        loop {
            let mut numbers = Vec::new();
            raw.read(&mut window, file, 1 << 14, &mut numbers)?;
            if numbers.is_empty() {
                break;
            }
            count += numbers.len() as u64;
            sum += scaling.apply(vec![numbers]).iter().sum::<f64>();
        }
        let mean = sum / count as f64;
        Ok(Some(mean).filter(|m| m.is_finite()))
    }
}

/// Polynomials one after the other; straight lines in a row are one line.
#[derive(Default)]
struct Chain {
    steps: Vec<Step>,
    line: Option<(f64, f64)>,
}

impl Chain {
    fn one(&mut self, polynomial: &Polynomial) {
        let reference = polynomial.reference;
        match polynomial.coefficients[..] {
            [slope, intercept] => self.line(slope, intercept - slope * reference),
            _ => {
                if reference != 0.0 {
                    self.line(1.0, -reference);
                }
                self.end_line();
                let from = self.from();
                let coefficients = polynomial.coefficients.iter().rev().copied();
                self.steps.push(Step::Polynomial {
                    from,
                    coefficients: coefficients.collect(),
                });
            }
        }
    }

    /// A·x·y + B·x + C·y + D at one value of y, where x and y are less their references.
    fn two(&mut self, polynomial: &Polynomial, other: Other, y: f64) {
        let [a, b, c, d] = polynomial.coefficients[..] else {
            return;
        };
        let (x0, y0) = (polynomial.reference, other.reference);
        // Multiplied out in the order in which the maker's reader does it, so that the same bits come out.
        let (b, c, d) = (b - a * y0, c - a * x0, d + a * x0 * y0 - b * x0 - c * y0);
        let (slope, intercept) = self.line.take().unwrap_or((1.0, 0.0));
        let xy = a * slope;
        let x = b * slope;
        let only_y = a * intercept + c;
        let constant = b * intercept + d;
        self.line = Some((xy * y + x, only_y * y + constant));
    }

    fn line(&mut self, slope: f64, intercept: f64) {
        self.line = Some(match self.line {
            Some((first, offset)) => (slope * first, intercept + slope * offset),
            None => (slope, intercept),
        });
    }

    fn from(&self) -> From {
        match self.steps.len() {
            0 => From::Stored(0),
            n => From::Step(n - 1),
        }
    }

    fn end_line(&mut self) {
        if let Some((slope, intercept)) = self.line.take().filter(|line| *line != (1.0, 0.0)) {
            let from = self.from();
            self.steps.push(Step::Linear {
                from,
                slope,
                intercept,
            });
        }
    }

    fn scaling(mut self) -> Scaling {
        self.end_line();
        Scaling { steps: self.steps }
    }
}
