//! The attitudes of a campaign: from a table of standstills, the columns of a table of readings, or a list, in one form.

use super::recordings::gravity;
use crate::campaign::{MultiPositionCampaign, RowsAre};
use crate::trouble::{Result, Trouble};
use proofmass_core::Gravity;
use proofmass_io::sheet::Sheet;
use proofmass_io::{AttitudeColumns, GivenAttitude, Recording, check_agreement};
use proofmass_static::{ForceUncertainty, Segment};

/// Standard uncertainties by which the length of a true acceleration may differ from gravity: of twelve true statements one in
/// a thousand tables has one beyond.
const FAR: f64 = 4.0;

impl MultiPositionCampaign {
    /// Fills in what is said of the attitudes: `of_rows` by the table of standstills, else by the columns of a table of readings,
    /// and by `directions`.
    pub(super) fn give_attitudes(
        &self,
        recordings: &[Recording],
        segments: &mut [Segment],
        of_rows: Vec<Option<GivenAttitude>>,
    ) -> Result<()> {
        let mut given = of_rows;
        if self.recording.rows == RowsAre::Readings {
            given = self.columns_of_readings(recordings)?;
        }
        given.resize(segments.len(), None);
        self.add_directions(segments, &mut given)?;
        let local = gravity(&self.gravity)?;
        let (mut stated, mut lacking) = (None, None);
        for (index, (segment, attitude)) in segments.iter_mut().zip(&given).enumerate() {
            let name = || self.named(segment, index);
            let Some(attitude) = attitude else {
                lacking = lacking.or_else(|| Some(name()));
                continue;
            };
            if attitude.acceleration.is_some() {
                stated = stated.or_else(|| Some(name()));
            }
            let (force, known) = self.force(attitude, &local).map_err(|e| e.detail(name()))?;
            segment.attitude = Some(force);
            segment.force_uncertainty = known;
        }
        match (stated, lacking) {
            (Some(stated), Some(lacking)) => Err(Trouble::request(format!(
                "{lacking} has no attitude, while {stated} has a true acceleration"
            ))
            .with_hint("a fit takes attitudes where every standstill has one: fill it in, or leave the standstill out of the table")),
            _ => Ok(()),
        }
    }

    /// The attitudes that the tables of readings hold beside the outputs.
    fn columns_of_readings(&self, recordings: &[Recording]) -> Result<Vec<Option<GivenAttitude>>> {
        let mut all = Vec::new();
        for (name, recording) in self.names().zip(recordings) {
            let header = recording.layout.header.as_deref().unwrap_or_default();
            let samples = recording.samples();
            if !AttitudeColumns::are_in(header) {
                all.resize(all.len() + samples, None);
                continue;
            }
            let mut sheet = Sheet::from_source(self.source.source(name)?, "table of readings")?;
            let columns = AttitudeColumns::claim(&mut sheet).map_err(|e| e.at(&recording.path))?;
            let Some(columns) = columns else {
                all.resize(all.len() + samples, None);
                continue;
            };
            let before = all.len();
            for row in sheet.rows() {
                let attitude = columns.of(&row);
                all.push(attitude.map_err(|e| e.at(&recording.path).line(row.line))?);
            }
            if all.len() - before != samples {
                return Err(Trouble::data(format!(
                    "{} attitudes stand beside {samples} readings",
                    all.len() - before
                ))
                .detail(recording.path.display().to_string())
                .with_hint("a table of readings with attitudes has one header and one reading a row; or give `directions` in [standstill] of a campaign"));
            }
        }
        Ok(all)
    }

    /// `directions` of the campaign, beside what the tables say.
    fn add_directions(
        &self,
        segments: &[Segment],
        given: &mut [Option<GivenAttitude>],
    ) -> Result<()> {
        let Some(directions) = &self.standstill.directions else {
            return Ok(());
        };
        if directions.len() != segments.len() {
            return Err(Trouble::request(format!(
                "{} directions are given for {} standstills",
                directions.len(),
                segments.len()
            ))
            .with_hint(
                "`directions` in [standstill] has one entry for each file or row, in order",
            ));
        }
        for (index, (segment, entry)) in segments.iter().zip(directions).enumerate() {
            let name = || self.named(segment, index);
            let listed = entry.given().map_err(|e| Trouble::from(e).detail(name()))?;
            let Some(own) = given.get_mut(index) else {
                continue;
            };
            *own = match own.take() {
                None => Some(listed),
                Some(table) => Some(one_of(table, listed).map_err(|e| e.detail(name()))?),
            };
        }
        Ok(())
    }

    /// The specific force in units of local gravity, and how well it is known where that is said of it alone.
    fn force(
        &self,
        given: &GivenAttitude,
        local: &Gravity,
    ) -> Result<([f64; 3], Option<ForceUncertainty>)> {
        let (g, u_g) = (local.value(), local.standard_uncertainty());
        let lengths = self.attitude.a_true_relative_standard_uncertainty;
        let Some(truth) = given.acceleration else {
            return match lengths {
                None => Ok((given.direction, None)),
                Some(_) => Err(Trouble::request(
                    "the lengths of true accelerations count, and this standstill has a direction alone",
                )
                .with_hint("give its a_true as well, or take a_true_relative_standard_uncertainty out of [attitude]")),
            };
        };
        let stated = truth
            .standard_uncertainty
            .or(self.attitude.a_true_standard_uncertainty);
        let Some(u) = stated else {
            return Err(Trouble::request(
                "the uncertainty of the true acceleration is missing",
            )
            .with_hint("add a column u_a_true_m/s2 beside a_true_x_m/s2, or say --a-true-uncertainty U (`a_true_standard_uncertainty = U in [attitude]` in a campaign), in m/s²"));
        };
        let length = proofmass_core::norm(truth.value);
        let across = u / g;
        if lengths.is_some() {
            let own = ForceUncertainty {
                across,
                along: across,
            };
            return Ok((truth.value.map(|a| a / g), Some(own)));
        }
        // What may differ: the statement and gravity itself; a billionth is the rounding of a unit.
        let (off, may) = (length - g, u.hypot(u_g));
        if off.abs() > FAR * may + 1e-9 * g {
            let [x, y, z] = truth.value;
            let than = if off > 0.0 { "more" } else { "less" };
            return Err(Trouble::request(format!(
                "the true acceleration ({x:.5}, {y:.5}, {z:.5}) m/s² has the length {length:.5} m/s², {:.2} % ({:.5} m/s²) {than} than gravity, {g:.5} m/s²; its standard uncertainty with that of gravity is {may:.2e} m/s²",
                100.0 * off.abs() / g,
                off.abs(),
            ))
            .with_hint("at rest it is gravity in the axes of the sensor: correct the numbers, their unit (g is 9.80665 m/s²) or the place; state a larger uncertainty where they are rounded; of a centrifuge write a campaign with a_true_relative_standard_uncertainty in [attitude]: then the lengths count"));
        }
        // At rest the length is that of gravity, whose uncertainty is common to all: what is left open is the direction.
        let own = ForceUncertainty { across, along: 0.0 };
        Ok((given.direction, Some(own)))
    }

    fn named(&self, segment: &Segment, index: usize) -> String {
        let what = match self.recording.rows {
            RowsAre::Readings => "reading",
            _ => "standstill",
        };
        match &segment.label {
            Some(label) => format!("{what} {} ({label})", index + 1),
            None => format!("{what} {}", index + 1),
        }
    }
}

/// Of an attitude and a true acceleration that agree the acceleration; of two attitudes none.
fn one_of(table: GivenAttitude, listed: GivenAttitude) -> Result<GivenAttitude> {
    let (truth, named) = match (table.acceleration, listed.acceleration) {
        (Some(_), None) => (table, listed),
        (None, Some(_)) => (listed, table),
        _ => {
            return Err(Trouble::request(
                "the attitude is given twice: by the table and by `directions` in [standstill]",
            )
            .with_hint("keep one of the two; a true acceleration may stand beside a direction"));
        }
    };
    check_agreement(&named, &truth)?;
    Ok(truth)
}
