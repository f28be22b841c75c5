//! Points of a frequency response as files have them: a table, a certificate, a calibration.

use super::ModelData;
use crate::channels::{ChannelReading, WantedChannel};
use crate::frequency_response;
use crate::trouble::{Result, Trouble};
use proofmass_documents::AnyCalibration;
use proofmass_dynamic::model::ResponsePoints;
use proofmass_io::{
    ColumnRef, Error, ErrorKind, Input, Layout, LayoutOptions, SaidBy, Source, Unit, UnitRatio,
};
use proofmass_uncertainty::Finding;
use std::path::Path;

/// Columns of a table of points.
#[derive(Clone, Debug, PartialEq)]
pub struct PointColumns {
    /// Frequency, Hz.
    pub frequency: ColumnRef,
    /// Modulus.
    pub modulus: ColumnRef,
    /// Its standard uncertainty.
    pub modulus_uncertainty: ColumnRef,
    /// Phase.
    pub phase: ColumnRef,
    /// Its standard uncertainty.
    pub phase_uncertainty: ColumnRef,
    /// Whether the phases are in degrees where their headings do not say it; else in radians.
    pub degrees: bool,
    /// Unit of the modulus and its uncertainty, where their headings do not say it.
    pub unit: Option<UnitRatio>,
}

impl PointColumns {
    /// Unit of the modulus and who says it.
    fn unit_of_modulus(&self, layout: &Layout, file: &Path) -> Result<(UnitRatio, SaidBy)> {
        let find = layout.find(&self.modulus);
        let index = find.map_err(|e| Trouble::from(e.at(file)))?;
        let refuse = |what: String, hint: &str| {
            let error = Error::new(ErrorKind::Column, what).at(file);
            Err(error.column(layout.name(index)).with_hint(hint).into())
        };
        match (layout.ratio(index), self.unit) {
            (Some(own), Some(stated)) if own != stated => refuse(
                format!("the heading says {own}, {stated} is stated"),
                "leave --unit out, or correct the heading: the heading counts",
            ),
            (Some(own), _) => Ok((own, SaidBy::Heading)),
            (None, Some(stated)) => Ok((stated, SaidBy::Person)),
            (None, None) => refuse(
                "the unit of the modulus is not said".to_owned(),
                "say --unit V/(m/s2), or mV/g, count/g, (m/s2)/N, …, 1 for a pure number; the heading may say it too, as s_V/(m/s2) or s (mV/g)",
            ),
        }
    }
}

/// Points with where they are from.
#[derive(Clone, Debug)]
pub struct RecordedPoints {
    points: ResponsePoints,
    findings: Vec<Finding>,
    name: String,
    input: Input,
}

impl RecordedPoints {
    /// Reads a table with a line for each point.
    ///
    /// # Errors
    /// As [`ChannelReading::read`]; a modulus whose unit nobody says, or that has another one than its uncertainty; an uncertainty that is
    /// not positive.
    pub fn of_table(mut source: Source, columns: &PointColumns) -> Result<Self> {
        let angle = |column: &ColumnRef| match columns.degrees {
            true => WantedChannel::new(column.clone(), Some(Unit::Degree), "--phase-unit"),
            false => WantedChannel::assumed(column.clone(), Unit::Radian),
        };
        let layout = Layout::of(&mut source, &LayoutOptions::default())?;
        let (unit, by) = columns.unit_of_modulus(&layout, source.name())?;
        let index = layout.find(&columns.modulus_uncertainty);
        let own = index.ok().and_then(|index| layout.ratio(index));
        let u_modulus = columns.modulus_uncertainty.clone();
        let wanted = [
            WantedChannel::assumed(columns.frequency.clone(), Unit::Hertz),
            WantedChannel::of_ratio(columns.modulus.clone(), unit, by),
            match own {
                Some(own) => WantedChannel::of_ratio(u_modulus, own, SaidBy::Heading),
                None => WantedChannel::of_ratio(u_modulus, unit, by),
            },
            angle(&columns.phase),
            angle(&columns.phase_uncertainty),
        ];
        let table = ChannelReading::table().read(source, &wanted)?;
        let [f, modulus, u_modulus, phase, u_phase] = table.channels.as_slice() else {
            return Err(Trouble::data("five columns are needed").detail(&table.name));
        };
        if u_modulus.unit != modulus.unit {
            return Err(Trouble::data(format!(
                "the modulus is in {}, its uncertainty in {}",
                modulus.unit, u_modulus.unit
            ))
            .detail(&table.name)
            .with_hint("give both in one unit, or correct the headings"));
        }
        let points = ResponsePoints::polar(
            f.data.clone(),
            &modulus.data,
            &u_modulus.data,
            &phase.data,
            &u_phase.data,
            &modulus.unit,
        )
        .map_err(|e| Trouble::from(e).detail(&table.name))?;
        Ok(Self {
            points,
            findings: table.findings,
            name: table.name,
            input: table.input,
        })
    }

    /// Reads a calibration over frequency or the table of a certificate, whose expanded uncertainties have this coverage factor.
    ///
    /// # Errors
    /// As [`frequency_response::read_calibration`]; a calibration of another kind.
    pub fn of_calibration(source: Source, coverage: Option<f64>) -> Result<Self> {
        let name = source.name().display().to_string();
        let (calibration, input, findings) =
            frequency_response::read_calibration(source, coverage)?;
        let AnyCalibration::FrequencyResponse(file) = calibration else {
            return Err(Trouble::data(format!("{name} is no frequency response"))
                .with_hint("give a calibration.json of kind frequency-response, a certificate, or a table with its five columns named"));
        };
        let response = frequency_response::of_file(&file)?;
        let points = ResponsePoints::of_response(&response, 0, 0)
            .map_err(|e| Trouble::from(e).detail(&name))?;
        Ok(Self {
            points,
            findings,
            name,
            input,
        })
    }

    /// With a relative standard uncertainty of the reference, common to all points.
    #[must_use]
    pub fn with_reference(mut self, relative: f64) -> Self {
        self.points = self.points.with_reference(relative, 0.0, None);
        self
    }

    /// For the job.
    pub fn data(&self) -> ModelData<'_> {
        ModelData {
            points: &self.points,
            findings: &self.findings,
            name: &self.name,
        }
    }

    /// The file with its digest.
    pub fn input(&self) -> Input {
        self.input.clone()
    }
}
