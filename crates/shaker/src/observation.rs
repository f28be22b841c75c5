//! What one run gives: the acceleration of the table and the three outputs, as phasors.

use super::Configuration;
use super::budget::Key;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::DegreesOfFreedom;
use serde::{Deserialize, Serialize};

/// One configuration at one frequency. Volts stand for the unit of the outputs, whatever it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PhasorRow {
    /// Name of the run, for messages.
    pub run: String,
    /// Session in which it was measured: a day, or a bench that was set up anew. All rows of a campaign name one, or none does.
    pub session: Option<String>,
    /// Nominal drive frequency in Hz; rows of one frequency carry the same number.
    pub frequency: f64,
    /// Mounting.
    pub configuration: Configuration,
    /// Acceleration of the table along z′ in m/s², peak, from the reference standard and its certificate.
    pub reference: Complex64,
    /// Outputs x, y, z in V, peak.
    pub outputs: [Complex64; 3],
    /// Covariance `[rr, ri, ii]` of the reference (m/s²)² and of the outputs (V²) from the sine approximation.
    pub covariance: [[f64; 3]; 4],
    /// What is known of the phases of the outputs.
    pub phases: OutputPhases,
    /// Sensitivity of the reference in V/(m/s²), where it was recorded in volts: cables can be swapped then.
    pub reference_sensitivity: Option<Complex64>,
}

/// What is known of the phases of the outputs of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputPhases {
    /// Each was read against that of the reference.
    #[default]
    Measured,
    /// The three have one in common that nobody knows: they were sampled by another clock than the reference.
    InCommon,
    /// Nobody read them: the outputs are moduli.
    Unread,
}

/// Share of the excitation along the axis of an output from which on the sense of the reading is that of the mounting, whatever the
/// cross terms.
pub(crate) const TOLD: f64 = 0.3;

/// Each frequency once, in ascending order.
pub(crate) fn ascending(frequencies: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = frequencies.into_iter().collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The sessions of some rows, in the order in which they come.
pub(crate) fn sessions(rows: &[PhasorRow]) -> Vec<&str> {
    let mut list: Vec<&str> = vec![];
    for session in rows.iter().filter_map(|r| r.session.as_deref()) {
        if !list.contains(&session) {
            list.push(session);
        }
    }
    list
}

impl PhasorRow {
    /// A row without noise of its own: the budget carries everything.
    pub fn new(
        run: impl Into<String>,
        frequency: f64,
        configuration: Configuration,
        reference: Complex64,
        outputs: [Complex64; 3],
    ) -> Self {
        Self {
            run: run.into(),
            session: None,
            frequency,
            configuration,
            reference,
            outputs,
            covariance: [[0.0; 3]; 4],
            phases: OutputPhases::Measured,
            reference_sensitivity: None,
        }
    }

    /// Outputs per unit acceleration of the table, o/a in V/(m/s²).
    pub(crate) fn ratios(&self) -> [Complex64; 3] {
        self.outputs.map(|o| o / self.reference)
    }

    /// The row as it would have been, had the cables of the reference and of an output not been swapped; `None` where the
    /// reference was no voltage, or the output none either.
    pub(crate) fn with_reference_on(&self, channel: usize) -> Option<Self> {
        let r = self.reference_sensitivity?;
        let round = |c: [f64; 3]| 0.5 * (c[0] + c[2]);
        let mut row = self.clone();
        row.reference = self.outputs[channel] / r;
        row.outputs[channel] = self.reference * r;
        let noise = [
            round(self.covariance[channel + 1]) / r.norm_sqr(),
            round(self.covariance[0]) * r.norm_sqr(),
        ];
        row.covariance[0] = [noise[0], 0.0, noise[0]];
        row.covariance[channel + 1] = [noise[1], 0.0, noise[1]];
        (row.reference.norm() > 0.0).then_some(row)
    }

    /// Reals that the row tells beside the phases that nobody knows.
    pub(crate) fn reals(&self) -> f64 {
        match self.phases {
            OutputPhases::Measured => 6.0,
            OutputPhases::InCommon => 5.0,
            OutputPhases::Unread => (0..3).filter(|&j| self.tells(j)).count() as f64,
        }
    }

    /// Whether a phase of the row is unknown.
    pub(crate) fn is_free(&self) -> bool {
        self.phases != OutputPhases::Measured
    }

    /// Whether the reading of an output says something of S: without its phase it does where the geometry tells its sense.
    pub(crate) fn tells(&self, output: usize) -> bool {
        self.phases != OutputPhases::Unread || self.configuration.direction()[output].abs() >= TOLD
    }

    pub(crate) fn check(&self, index: usize) -> Result<(), Error> {
        let finite = |z: &Complex64| z.re.is_finite() && z.im.is_finite();
        if !(finite(&self.reference)
            && self.outputs.iter().all(finite)
            && self.frequency.is_finite()
            && self.configuration.inclination.is_finite()
            && self.configuration.rotation.is_finite())
        {
            return Err(Error::NotFinite {
                name: "phasor table",
                index,
            });
        }
        if self.reference.norm() == 0.0 {
            return Err(Error::OutOfRange {
                name: "reference acceleration",
                value: 0.0,
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        Ok(())
    }
}

/// Motion of the device's seat beside the excitation, relative to it, at one inclination and frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spurious {
    /// Inclination in radians.
    pub inclination: f64,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Complex ratios ε along x′, y′, z′; the whole motion is a (ε_x, ε_y, 1 + ε_z).
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 2]; 3]"))]
    pub ratio: [Complex64; 3],
    /// Covariance `[rr, ri, ii]` of each ratio.
    pub covariance: [[f64; 3]; 3],
    /// Degrees of freedom of these covariances.
    #[serde(default = "known")]
    pub dof: DegreesOfFreedom,
    /// What the ratio of each axis rests on.
    #[serde(skip)]
    pub basis: [Basis; 3],
}

impl Spurious {
    fn is_at(&self, frequency: f64) -> bool {
        (self.frequency / frequency - 1.0).abs() < 1e-6
    }
}

/// What a ratio of the motion of the bench rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// It was measured.
    #[default]
    Measured,
    /// Nobody measured it, and somebody states how large it may be: it is zero within that.
    Declared,
    /// Nobody measured it and nobody states anything: it is zero within what benches do, until the runs tell better.
    Assumed,
}

/// How large the motion of the bench is taken to be at a frequency, where nobody measured it: standard uncertainties of each part
/// of its ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct UnmeasuredAt {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Across the excitation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub across: Option<f64>,
    /// Along it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub along: Option<f64>,
}

/// First natural frequency of a wedge, Hz, where nobody measured how it moves: that of the published one of 55°.
///
/// **Source** `[Murgia2022]` 4.
const WEDGE: f64 = 3800.0;
/// Share of it from which on the motion is taken to grow no more.
const NEAREST: f64 = 0.9;

/// How far the face of a wedge may move more than the table, relative to that, where nobody measured it and nobody states anything: along the
/// excitation r²/(1 − r²), r the frequency over its first natural frequency ([`WEDGE`]). It is no part of the
/// ratio that is adjusted but of the uncertainty of the result: that several wedges agree does not tell that none bends.
pub(crate) fn bending(entry: &Spurious) -> f64 {
    let stiff = entry.basis[2] != Basis::Assumed || entry.inclination < 1e-6;
    if stiff {
        return 0.0;
    }
    let square = (entry.frequency / WEDGE).min(NEAREST).powi(2);
    square / (1.0 - square)
}

/// How large the motion of the bench may be where nobody measured it, as somebody states it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct UnmeasuredMotion {
    /// Standard uncertainty of the real and of the imaginary part of the ratios along x′ and y′, across the excitation; 0 for none.
    pub across: f64,
    /// The same along z′: how far the seat moves more or less than the reference.
    pub along: f64,
}

impl UnmeasuredMotion {
    /// What is assumed where nobody states it, until the runs tell better: across the excitation what a bench within the 10 % of
    /// `[ISO16063-21]` does, so that no run is accused of it; along it the 0.6 % of the published case, since no run tells what all
    /// wedges have in common there, and on a wedge what it bends in addition.
    ///
    /// **Source** `[Murgia2022]` 3.4.
    pub const ASSUMED: Self = Self {
        across: 0.03,
        along: 0.006,
    };

    /// Refuses what no ratio can be.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a value that is negative, or one or more.
    pub fn check(&self) -> Result<(), Error> {
        match self.impossible() {
            None => Ok(()),
            Some((name, value)) => Err(Error::OutOfRange {
                name,
                value,
                min: 0.0,
                max: 1.0,
            }),
        }
    }

    /// The first value, by its name, that no ratio can be.
    pub fn impossible(&self) -> Option<(&'static str, f64)> {
        let values = [("across", self.across), ("along", self.along)];
        let ratio = |value: &f64| (0.0..1.0).contains(value);
        values.into_iter().find(|(_, value)| !ratio(value))
    }
}

fn known() -> DegreesOfFreedom {
    DegreesOfFreedom::INFINITE
}

/// What is known of spurious motion over the bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpuriousTable {
    /// One entry per inclination and frequency that was measured.
    pub entries: Vec<Spurious>,
    /// Standard uncertainties of what ratios that nobody measured have in common, across the excitation and along it, by [`Share`];
    /// what each has by itself stands in its entry.
    #[serde(skip)]
    pub(crate) shared: [[f64; 2]; Share::ALL.len()],
    /// What all ratios that were measured have in common.
    #[serde(default, skip_serializing_if = "CommonMotion::is_empty")]
    pub common: CommonMotion,
}

/// What all measured ratios of a table have in common: the calibrations of the vibrometer and of the reference it was held against.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CommonMotion {
    /// At each frequency.
    pub at: Vec<CommonCauses>,
    /// Whether the reference was that of the campaign which is corrected, with the same calibration: its error is then in the ratio and in
    /// the acceleration alike, and goes out.
    pub same_reference: bool,
}

impl CommonMotion {
    /// Of these frequencies; nothing where no cause leaves anything open. Whose the reference was is not said.
    pub fn new(mut at: Vec<CommonCauses>) -> Self {
        let closed = |c: &CommonCauses| c.vibrometer == [0.0; 2] && c.reference == [0.0; 2];
        if at.iter().all(closed) {
            at.clear();
        }
        Self {
            at,
            same_reference: false,
        }
    }

    fn is_empty(&self) -> bool {
        self.at.is_empty()
    }

    /// At a frequency in Hz.
    pub fn at(&self, frequency: f64) -> Option<&CommonCauses> {
        let same = |c: &&CommonCauses| (c.frequency / frequency - 1.0).abs() < 1e-6;
        self.at.iter().find(same)
    }
}

/// Standard uncertainties that all ratios at a frequency have in common, and with those at the others: of a modulus (relative) and of a
/// phase (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CommonCauses {
    /// Hz.
    pub frequency: f64,
    /// Of the vibrometer.
    pub vibrometer: [f64; 2],
    /// Of the reference beside which it was read.
    pub reference: [f64; 2],
}

/// What a part of a ratio of the bench that nobody measured is common to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Share {
    /// The runs on a wedge at a frequency.
    Own,
    /// All wedges at a frequency: the table.
    Frequency,
    /// All frequencies on a wedge: its face.
    Wedge,
    /// Everything: the guides of the table.
    All,
}

impl Share {
    pub(crate) const ALL: [Self; 4] = [Self::Own, Self::Frequency, Self::Wedge, Self::All];

    /// Its word in a key of the budget.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Frequency => "frequency",
            Self::Wedge => "wedge",
            Self::All => "all",
        }
    }

    /// What it is, for a reader of the budget.
    pub(crate) fn description(self) -> String {
        let of = match self {
            Self::Own => "of each wedge at each frequency",
            Self::Frequency => "common to the wedges at a frequency",
            Self::Wedge => "of a wedge at all frequencies",
            Self::All => "common to all runs",
        };
        format!("motion of the bench that was not measured: {of}")
    }

    /// The keys it varies with, beside axis and part.
    pub(crate) fn varies_with(self) -> &'static [Key] {
        match self {
            Self::Own => &[Key::Frequency, Key::Inclination],
            Self::Frequency => &[Key::Frequency],
            Self::Wedge => &[Key::Inclination],
            Self::All => &[],
        }
    }
}

impl SpuriousTable {
    /// A table of what was measured.
    pub fn new(entries: Vec<Spurious>) -> Self {
        Self {
            entries,
            shared: Default::default(),
            common: CommonMotion::default(),
        }
    }

    /// The fewest degrees of freedom of an entry at a frequency; infinite where there is none.
    pub fn dof_at(&self, frequency: f64) -> DegreesOfFreedom {
        self.entries
            .iter()
            .filter(|e| e.is_at(frequency))
            .map(|e| e.dof)
            .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a })
    }

    /// The table with what is assumed where it says nothing: at places (inclination in radians, frequency in Hz) without an
    /// entry, and along axes whose ratio and uncertainty are both zero, as no measurement leaves them. `stated` is what somebody
    /// states, else [`UnmeasuredMotion::ASSUMED`] stands.
    #[must_use]
    pub fn completed(
        &self,
        places: impl IntoIterator<Item = (f64, f64)>,
        stated: Option<UnmeasuredMotion>,
    ) -> Self {
        let (motion, basis) = match stated {
            Some(motion) => (motion, Basis::Declared),
            None => (UnmeasuredMotion::ASSUMED, Basis::Assumed),
        };
        let mut table = self.clone();
        for (inclination, frequency) in places {
            if table.get(inclination, frequency).is_none() {
                table.entries.push(Spurious {
                    inclination,
                    frequency,
                    ratio: [Complex64::new(0.0, 0.0); 3],
                    covariance: [[0.0; 3]; 3],
                    dof: DegreesOfFreedom::INFINITE,
                    basis: [Basis::Measured; 3],
                });
            }
        }
        // What is common and what is not are alike as long as nobody knows better: a quarter of the variance each across the
        // excitation, half of it along: there a rigid seat moves as the table does, and what bends grows with frequency.
        let (across, along) = (motion.across / 2.0, motion.along / 2f64.sqrt());
        table.shared[Share::Frequency as usize] = [across, along];
        table.shared[Share::Wedge as usize] = [across, 0.0];
        table.shared[Share::All as usize] = [across, 0.0];
        for entry in &mut table.entries {
            for (axis, u) in [across, across, along].into_iter().enumerate() {
                let unknown = entry.ratio[axis] == Complex64::new(0.0, 0.0)
                    && entry.covariance[axis] == [0.0; 3];
                if unknown && u > 0.0 {
                    entry.basis[axis] = basis;
                    entry.covariance[axis] = [u * u, 0.0, u * u];
                }
            }
        }
        table
    }

    /// How large the motion is taken to be that nobody measured, at each of these frequencies (Hz) that has such.
    pub(crate) fn unmeasured(&self, frequencies: &[f64]) -> Vec<UnmeasuredAt> {
        let size = |frequency: f64, axes: &[usize]| {
            let of = |(e, axis): (&Spurious, usize)| {
                let common = self.shared.iter().map(|u| u[way(axis)].powi(2));
                let bent = if axis == 2 { bending(e) } else { 0.0 };
                let own = e.covariance[axis][0] + bent * bent;
                (e.basis[axis] != Basis::Measured).then(|| (own + common.sum::<f64>()).sqrt())
            };
            let here = self.entries.iter().filter(|e| e.is_at(frequency));
            let all = here.flat_map(|e| axes.iter().map(move |&axis| (e, axis)));
            all.filter_map(of).reduce(f64::max)
        };
        let at = |&frequency: &f64| {
            let (across, along) = (size(frequency, &[0, 1]), size(frequency, &[2]));
            (across.is_some() || along.is_some()).then_some(UnmeasuredAt {
                frequency,
                across,
                along,
            })
        };
        frequencies.iter().filter_map(at).collect()
    }

    /// What a draw of standard deviation one adds to a ratio of an entry: `part` 2 k + 1 is the second of axis k.
    pub(crate) fn step(&self, entry: &Spurious, share: Share, part: usize) -> Complex64 {
        let (axis, second) = (part / 2, part % 2);
        let u = self.shared[share as usize][way(axis)];
        match (share, second) {
            (Share::Own, _) => root(entry.covariance[axis])[second],
            (_, 0) => Complex64::new(u, 0.0),
            _ => Complex64::new(0.0, u),
        }
    }

    /// Multiplies variances of the motion that nobody measured, across the excitation and along it: of what each wedge has by itself those
    /// at a frequency.
    pub(crate) fn scale(&mut self, share: Share, frequency: Option<f64>, factors: [f64; 2]) {
        for (u, factor) in self.shared[share as usize].iter_mut().zip(factors) {
            *u *= factor.sqrt();
        }
        let Some(frequency) = frequency else { return };
        for entry in self.entries.iter_mut().filter(|e| e.is_at(frequency)) {
            for axis in 0..3 {
                if entry.basis[axis] != Basis::Measured {
                    let factor = factors[way(axis)];
                    entry.covariance[axis] = entry.covariance[axis].map(|v| factor * v);
                }
            }
        }
    }

    /// The entry of an inclination and a frequency.
    pub fn get(&self, inclination: f64, frequency: f64) -> Option<&Spurious> {
        self.entries
            .iter()
            .find(|e| (e.inclination - inclination).abs() < 1e-6 && e.is_at(frequency))
    }
}

/// One measurement of the spurious motion, or none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Correction {
    /// Label, such as `none` or `second`.
    pub label: String,
    /// The ratios.
    pub table: SpuriousTable,
}

impl Correction {
    /// That of a campaign without one.
    pub(crate) fn none() -> Self {
        Self {
            label: "none".to_owned(),
            table: SpuriousTable::default(),
        }
    }
}

/// Across the excitation (0) or along it (1).
pub(crate) fn way(axis: usize) -> usize {
    usize::from(axis == 2)
}

/// Two complex numbers whose multiples by independent draws of variance one have this covariance `[rr, ri, ii]`.
pub(crate) fn root([rr, ri, ii]: [f64; 3]) -> [Complex64; 2] {
    let l11 = rr.max(0.0).sqrt();
    let l21 = if l11 > 0.0 { ri / l11 } else { 0.0 };
    [
        Complex64::new(l11, l21),
        Complex64::new(0.0, (ii - l21 * l21).max(0.0).sqrt()),
    ]
}
