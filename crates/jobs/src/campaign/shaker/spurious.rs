//! `spurious.csv`: the motion of the seat beside the excitation, per inclination and frequency.

use crate::page::AXES;
use crate::page::columns::{filed, frequency, number, percent};
use num_complex::Complex64;
use proofmass_io::Source;
use proofmass_io::sheet::{ANGLE, FREQUENCY, Place, RATIO, Sheet, SheetRow};
use proofmass_io::{Input, Result};
use proofmass_report::Rounding::{Decimals, Plain, TwoDigits};
use proofmass_report::Table;
use proofmass_shaker::{CommonCauses, CommonMotion, Correction, Spurious, SpuriousTable};
use proofmass_uncertainty::DegreesOfFreedom;

/// One measurement of the spurious motion.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousFile {
    /// Path and digest; `None` for a table without a file.
    pub(crate) input: Option<Input>,
    /// Label and table.
    pub(crate) correction: Correction,
}

type Cause = fn(&CommonCauses) -> f64;

/// Columns of what all ratios at a frequency have in common.
const CAUSES: [(&str, Cause); 4] = [
    ("u_vibrometer", |c| c.vibrometer[0]),
    ("u_vibrometer_phase_rad", |c| c.vibrometer[1]),
    ("u_reference", |c| c.reference[0]),
    ("u_reference_phase_rad", |c| c.reference[1]),
];

enum AxisColumns {
    Absent,
    Polar {
        ratio: Place,
        phase: Place,
        u_ratio: Option<Place>,
        u_phase: Option<Place>,
    },
    Parts {
        parts: [Place; 2],
        u: [Option<Place>; 2],
        correlation: Option<Place>,
    },
}

impl SpuriousFile {
    /// Reads a table, such as a vibrometer campaign or `proofmass modes` writes.
    ///
    /// # Errors
    /// A file that cannot be read, or a row that is wrong, with line and column.
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::read(Source::open(path)?, &path.display().to_string())
    }

    pub(crate) fn read(source: Source, label: &str) -> Result<Self> {
        let mut sheet = Sheet::from_source(source, "table of spurious motion")?;
        let tilt = sheet.quantity("inclination", ANGLE)?;
        let frequency = sheet.quantity("frequency", FREQUENCY)?;
        let found = AXES
            .iter()
            .map(|axis| {
                let polar = [
                    sheet.quantity(&format!("{axis}_ratio"), RATIO)?,
                    sheet.quantity(&format!("{axis}_phase"), ANGLE)?,
                    sheet.quantity(&format!("u_{axis}_ratio"), RATIO)?,
                    sheet.quantity(&format!("u_{axis}_phase"), ANGLE)?,
                ];
                let parts = [
                    sheet.quantity(&format!("{axis}_real"), RATIO)?,
                    sheet.quantity(&format!("{axis}_imaginary"), RATIO)?,
                    sheet.quantity(&format!("u_{axis}_real"), RATIO)?,
                    sheet.quantity(&format!("u_{axis}_imaginary"), RATIO)?,
                    sheet.quantity(&format!("r_{axis}"), RATIO)?,
                ];
                Ok((polar, parts))
            })
            .collect::<Result<Vec<_>>>()?;
        let dof = sheet.text("nu");
        let mut cause = |name: &str| -> Result<[Option<Place>; 2]> {
            let phase = format!("u_{name}_phase");
            Ok([
                sheet.quantity(&format!("u_{name}"), RATIO)?,
                sheet.quantity(&phase, ANGLE)?,
            ])
        };
        let causes = [cause("vibrometer")?, cause("reference")?];
        sheet.finish()?;
        let tilt = sheet.required(tilt, "inclination_deg")?;
        let frequency = sheet.required(frequency, "frequency_Hz")?;
        let columns = found
            .into_iter()
            .zip(AXES)
            .map(|((polar, parts), axis)| AxisColumns::new(&sheet, axis, polar, parts))
            .collect::<Result<Vec<_>>>()?;
        if columns.iter().all(|c| matches!(c, AxisColumns::Absent)) {
            sheet.required(None, "x_ratio")?;
        }
        let mut common: Vec<CommonCauses> = Vec::new();
        let mut rows: Vec<(u64, Spurious)> = Vec::new();
        for row in sheet.rows() {
            let mut entry = Spurious {
                basis: Default::default(),
                inclination: row.number(tilt)?,
                frequency: row.positive(frequency)?,
                ratio: [Complex64::new(0.0, 0.0); 3],
                covariance: [[0.0; 3]; 3],
                dof: DegreesOfFreedom::INFINITE,
            };
            if let Some(place) = dof
                && !row.text(place).is_empty()
            {
                entry.dof = DegreesOfFreedom::new(row.positive(place)?)
                    .ok_or_else(|| row.refuse(place, "degrees of freedom are positive"))?;
            }
            for (k, column) in columns.iter().enumerate() {
                let ([re, im], covariance) = column.read(&row)?;
                entry.covariance[k] = covariance;
                entry.ratio[k] = Complex64::new(re, im);
            }
            if let Some((line, _)) = rows.iter().find(|(_, r)| {
                (r.inclination - entry.inclination).abs() < 1e-6 && r.frequency == entry.frequency
            }) {
                return Err(row
                    .refuse_row(format!(
                        "inclination {:.4}° at {} Hz stands in line {line} already",
                        entry.inclination.to_degrees(),
                        entry.frequency
                    ))
                    .with_hint("write another measurement into a file of its own, as another [[correction]]"));
            }
            let [vibrometer, reference] = causes.map(|places| places.map(|p| row.uncertainty(p)));
            let both = |[modulus, phase]: [Result<f64>; 2]| Ok([modulus?, phase?]);
            let found = CommonCauses {
                frequency: entry.frequency,
                vibrometer: both(vibrometer)?,
                reference: both(reference)?,
            };
            match common.iter().find(|c| c.frequency == found.frequency) {
                None => common.push(found),
                Some(other) if *other == found => {}
                Some(_) => {
                    return Err(row
                        .refuse_row(format!(
                            "u of vibrometer or reference at {} Hz is not that of the rows before",
                            found.frequency
                        ))
                        .with_hint(
                            "they are common to all wedges: write the same into every row of a frequency",
                        ));
                }
            }
            rows.push((row.line, entry));
        }
        let mut table = SpuriousTable::new(rows.into_iter().map(|(_, r)| r).collect());
        table.common = CommonMotion::new(common);
        Ok(Self {
            input: Some(sheet.input.clone()),
            correction: Correction {
                label: label.to_owned(),
                table,
            },
        })
    }

    /// The table as it is read again: real and imaginary parts with their uncertainties and correlation; on a page
    /// modulus and phase.
    pub(crate) fn table(table: &SpuriousTable) -> Table {
        let mut fields = vec![
            // Radians of whole degrees come back with rounding in the last digit.
            number("inclination_deg", ("α", "°"), Plain, |e: &Spurious| {
                (e.inclination.to_degrees() * 1e9).round() / 1e9
            }),
            frequency(|e: &Spurious| e.frequency),
        ];
        for (k, axis) in AXES.into_iter().enumerate() {
            // Standard uncertainty of one part, mean over both.
            let part = move |e: &Spurious| (0.5 * (e.covariance[k][0] + e.covariance[k][2])).sqrt();
            fields.extend([
                percent("", &format!("|ε_{axis}′|"), move |e: &Spurious| {
                    e.ratio[k].norm()
                })
                .rounded(Decimals(3)),
                number("", ("u", "%"), TwoDigits, move |e: &Spurious| {
                    Some(100.0 * part(e)).filter(|u| *u > 0.0)
                }),
                number("", ("phase", "°"), Decimals(1), move |e: &Spurious| {
                    let (modulus, phase) = e.ratio[k].to_polar();
                    (modulus > 2.0 * part(e) && modulus > 0.0).then(|| phase.to_degrees())
                }),
                filed(format!("{axis}_real"), move |e: &Spurious| e.ratio[k].re),
                filed(format!("{axis}_imaginary"), move |e: &Spurious| {
                    e.ratio[k].im
                }),
                filed(format!("u_{axis}_real"), move |e: &Spurious| {
                    e.covariance[k][0].sqrt()
                }),
                filed(format!("u_{axis}_imaginary"), move |e: &Spurious| {
                    e.covariance[k][2].sqrt()
                }),
                filed(format!("r_{axis}"), move |e: &Spurious| {
                    let [rr, ri, ii] = e.covariance[k];
                    let both = rr.sqrt() * ii.sqrt();
                    if both > 0.0 { ri / both } else { 0.0 }
                }),
            ]);
        }
        fields.push(filed("nu", |e: &Spurious| {
            (!e.dof.is_infinite()).then(|| e.dof.get())
        }));
        for (heading, of) in CAUSES {
            let common = &table.common;
            if common.at.iter().any(|c| of(c) > 0.0) {
                fields.push(filed(heading, move |e: &Spurious| {
                    common.at(e.frequency).map_or(0.0, of)
                }));
            }
        }
        Table::of(
            "Correction of each axis: ratio to the reference acceleration, along z′ the deviation from one",
            fields,
            &table.entries,
        )
        .note("u is that of the real or the imaginary part. A phase is given where the modulus exceeds 2 u.")
    }
}

impl AxisColumns {
    fn new(
        sheet: &Sheet,
        axis: &str,
        polar: [Option<Place>; 4],
        parts: [Option<Place>; 5],
    ) -> Result<Self> {
        let [any_polar, any_parts] = [
            polar.iter().any(Option::is_some),
            parts.iter().any(Option::is_some),
        ];
        match (any_polar, any_parts) {
            (false, false) => Ok(Self::Absent),
            (true, true) => Err(sheet
                .header_error(
                    &format!("{axis}_real"),
                    "modulus with phase and real with imaginary part exclude each other",
                )
                .with_hint("keep one of the two forms")),
            (true, false) => Ok(Self::Polar {
                ratio: sheet.required(polar[0], &format!("{axis}_ratio"))?,
                phase: sheet.required(polar[1], &format!("{axis}_phase_deg"))?,
                u_ratio: polar[2],
                u_phase: polar[3],
            }),
            (false, true) => Ok(Self::Parts {
                parts: [
                    sheet.required(parts[0], &format!("{axis}_real"))?,
                    sheet.required(parts[1], &format!("{axis}_imaginary"))?,
                ],
                u: [parts[2], parts[3]],
                correlation: parts[4],
            }),
        }
    }

    fn read(&self, row: &SheetRow) -> Result<([f64; 2], [f64; 3])> {
        match self {
            Self::Absent => Ok(([0.0; 2], [0.0; 3])),
            Self::Polar {
                ratio,
                phase,
                u_ratio,
                u_phase,
            } => {
                let (r, angle) = (row.number(*ratio)?, row.number(*phase)?);
                if r < 0.0 {
                    return Err(row
                        .refuse(*ratio, "a modulus is not negative")
                        .with_hint("turn the phase by 180°, or write real and imaginary part"));
                }
                let (s, c) = angle.sin_cos();
                let along = row.uncertainty(*u_ratio)?;
                // Without a phase uncertainty of its own the phasor is known alike in every direction.
                let across = match u_phase {
                    Some(_) => r * row.uncertainty(*u_phase)?,
                    None => along,
                };
                let (a, b) = (along * along, across * across);
                Ok((
                    [r * c, r * s],
                    [
                        a * c * c + b * s * s,
                        (a - b) * c * s,
                        a * s * s + b * c * c,
                    ],
                ))
            }
            Self::Parts {
                parts,
                u,
                correlation,
            } => {
                let (u_re, u_im) = (row.uncertainty(u[0])?, row.uncertainty(u[1])?);
                let r = row.optional(*correlation)?.unwrap_or(0.0);
                if let Some(place) = correlation
                    && r.abs() > 1.0
                {
                    return Err(row
                        .refuse(
                            *place,
                            format!("a correlation of {r} is out of range: from −1 to 1"),
                        )
                        .with_hint("give a number from −1 to 1; leave it empty for 0"));
                }
                Ok((
                    [row.number(parts[0])?, row.number(parts[1])?],
                    [u_re * u_re, r * u_re * u_im, u_im * u_im],
                ))
            }
        }
    }
}
