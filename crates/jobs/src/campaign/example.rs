//! A full example of every kind of campaign, with its tables: what is written in place of a recording that is not there yet.

use crate::outcome::Job as _;
use crate::simulate::{
    SimulateJob, SimulatedMultiPosition, SimulatedPrimary, SimulatedShaker, SimulatedSpuriousMotion,
};
use crate::store::Sink;
use crate::trouble::{Result, Trouble};
use proofmass_core::Watch;
use proofmass_io::{Cell, Table};

/// Writes campaign.toml of a kind and its tables. Its numbers are simulated and belong to no device.
///
/// # Errors
/// A kind that there is not; a place that cannot be written.
pub fn example(kind: &str, sink: &dyn Sink, watch: &dyn Watch) -> Result<()> {
    let sink: &dyn Sink = &WithSchema { kind, sink };
    let simulated = |job: SimulateJob| job.evaluate(&sink, watch).map(|_| ());
    let write = |name: &str, bytes: Vec<u8>| Ok::<(), Trouble>(sink.write(name, bytes)?);
    match kind {
        "multi-position" => {
            simulated(SimulateJob::MultiPosition(SimulatedMultiPosition::default()))
        }
        "shaker-triaxial" => {
            let mut shaker = SimulatedShaker::default();
            (shaker.phasors, shaker.configurations) = (true, 12);
            shaker.frequencies = vec![80.0, 160.0, 315.0];
            shaker.sessions = 2;
            simulated(SimulateJob::Shaker(shaker))
        }
        "spurious-motion" => simulated(SimulateJob::SpuriousMotion(
            SimulatedSpuriousMotion::default(),
        )),
        "single-axis" => {
            write("readings.csv", readings()?)?;
            write("campaign.toml", campaign(kind, SINGLE_AXIS))
        }
        "shaker-single" => {
            write("runs.csv", comparison()?)?;
            write("reference.csv", certificate()?)?;
            write("campaign.toml", campaign(kind, SHAKER_SINGLE))
        }
        "shaker-primary" => {
            let mut primary = SimulatedPrimary::default();
            (primary.repeats, primary.duration) = (1, 0.1);
            primary.frequencies = vec![80.0, 160.0, 1000.0];
            simulated(SimulateJob::Primary(primary))
        }
        "transverse-sensitivity" => {
            write("runs.csv", turned()?)?;
            write("campaign.toml", campaign(kind, TRANSVERSE))
        }
        "free-living" => {
            write("wrist.csv", worn()?)?;
            write("campaign.toml", campaign(kind, FREE_LIVING))
        }
        other => Err(
            Trouble::request(format!("there is no campaign of the kind {other:?}"))
                .with_hint(format!("known kinds: {}", super::KINDS.join(", "))),
        ),
    }
}

/// Writes the campaign with the line of its schema.
struct WithSchema<'a> {
    kind: &'a str,
    sink: &'a dyn Sink,
}

impl Sink for WithSchema<'_> {
    fn write(&self, name: &str, mut bytes: Vec<u8>) -> proofmass_io::Result<()> {
        if name == "campaign.toml" {
            let line = super::schema_line(self.kind) + "\n";
            bytes = [line.into_bytes(), bytes].concat();
        }
        self.sink.write(name, bytes)
    }
}

fn campaign(kind: &str, tables: &str) -> Vec<u8> {
    format!(
        "# An example. Its numbers belong to no device: put your own in their place.\n\
         kind = \"{kind}\"\ntitle = \"Example of a {kind} campaign\"\n\n\
         [device]\nmanufacturer = \"…\"\nmodel = \"…\"\nserial = \"…\"\n\n{tables}"
    )
    .into_bytes()
}

/// Errors of readings that are the same on every machine, between −1 and 1.
fn error(k: usize) -> f64 {
    ((7919 * (k + 1)) % 13) as f64 / 6.0 - 1.0
}

/// One axis at twelve angles of a turntable.
fn readings() -> Result<Vec<u8>> {
    let mut table = Table::new(["angle_deg", "out_mV"]);
    for k in 0..12 {
        let angle = 30.0 * k as f64;
        table.push([
            angle,
            1.2 + 980.0 * angle.to_radians().cos() + 0.05 * error(k),
        ])?;
    }
    Ok(table.to_csv()?)
}

const FREQUENCIES: [f64; 7] = [10.0, 20.0, 40.0, 80.0, 160.0, 315.0, 630.0];

/// Three repeats at every frequency: 10 mV/(m/s²) beside a reference of 10.2 mV/(m/s²) at 10 m/s².
fn comparison() -> Result<Vec<u8>> {
    let mut table = Table::new([
        "run",
        "frequency_Hz",
        "transverse_%",
        "reference_mV",
        "reference_phase_deg",
        "output_mV",
        "output_phase_deg",
    ]);
    let runs = FREQUENCIES
        .iter()
        .flat_map(|f| (1..=3).map(move |r| (f, r)));
    for (k, (f, repeat)) in runs.enumerate() {
        table.push([
            Cell::from(format!("{f} Hz {repeat}").as_str()),
            Cell::from(*f),
            Cell::from(2.0),
            Cell::from(102.0),
            Cell::from(0.0),
            Cell::from(100.0 * (1.0 + 5e-4 * error(k))),
            Cell::from(-0.01 * f + 0.02 * error(k + 5)),
        ])?;
    }
    Ok(table.to_csv()?)
}

fn certificate() -> Result<Vec<u8>> {
    let mut table = Table::new([
        "frequency_Hz",
        "sensitivity_mV/(m/s2)",
        "phase_deg",
        "U_relative_%",
        "U_phase_deg",
    ]);
    for f in FREQUENCIES {
        table.push([f, 10.2, 0.0, 0.5, 0.3])?;
    }
    Ok(table.to_csv()?)
}

/// Along the axis, and across it in twelve directions: 2 % at most, at 30°.
fn turned() -> Result<Vec<u8>> {
    let mut table = Table::new([
        "run",
        "frequency_Hz",
        "inclination_deg",
        "rotation_deg",
        "reference_m/s2",
        "reference_phase_deg",
        "output_mV",
        "output_phase_deg",
    ]);
    for f in [80.0, 160.0] {
        let mut row = |name: String, angles: [f64; 2], output: f64| {
            let (modulus, phase) = match output < 0.0 {
                true => (-output, 178.0),
                false => (output, -2.0),
            };
            table.push([
                Cell::from(name.as_str()),
                Cell::from(f),
                Cell::from(angles[0]),
                Cell::from(angles[1]),
                Cell::from(10.0),
                Cell::from(0.0),
                Cell::from(modulus),
                Cell::from(phase),
            ])
        };
        row(format!("{f} Hz along"), [0.0, 0.0], 100.0)?;
        for k in 0..12 {
            let degrees = 30.0 * k as f64;
            let across = 2.0 * (degrees - 30.0).to_radians().cos() + 0.05 * error(k);
            row(format!("{f} Hz at {degrees}"), [90.0, degrees], across)?;
        }
    }
    Ok(table.to_csv()?)
}

/// Two and a half hours of a logger at two samples a second, a minute in each of 150 postures all over the sphere: x reads 1 % and 25 mg
/// too much.
fn worn() -> Result<Vec<u8>> {
    const POSTURES: usize = 150;
    const SAMPLES: usize = 120;
    let mut table = Table::new(["t_s", "x_g", "y_g", "z_g"]);
    for k in 0..POSTURES * SAMPLES {
        let posture = (k / SAMPLES) as f64;
        // The golden angle apart, one after the other from pole to pole and back, so that no hour sees one side alone.
        let up = ((posture * 0.618_034).fract() - 0.5) * 2.0;
        let (around, across) = (2.4 * posture, (1.0 - up * up).sqrt());
        let noise = |axis: usize| 2e-3 * error(k + 5 * axis + k / 7);
        let g = |v: f64| (1e4 * v).round() / 1e4;
        table.push([
            0.5 * k as f64,
            g(1.01 * across * around.cos() + 0.025 + noise(0)),
            g(across * around.sin() + noise(1)),
            g(up + noise(2)),
        ])?;
    }
    Ok(table.to_csv()?)
}

const SINGLE_AXIS: &str = r#"[recording]
file = "readings.csv"              # a line for each reading; or files = ["up.csv", "down.csv"] with angles_deg below
column = "out"
angle = "angle"                    # of the axis to the vertical; or position: 1 up, -1 down
# unit = "mV"                      # where the heading does not say it

[position]
# angles_deg = [0, 180]            # of files, in their order
levelling_deg = 0.1                # standard uncertainties of the fixture
zero_deg = 0.05
lean_deg = 0.1
out_of_plane_deg = 0.2

[gravity]
latitude_deg = 52.3                # or value = … and standard_uncertainty = …, m/s²
height_m = 80

[method]
confidence = 0.95
"#;

const SHAKER_SINGLE: &str = r#"[runs]
file = "runs.csv"                  # phasors; or a column `file` with the recordings, and [recording]

# [recording]
# format = "text"                  # or "f32", "wav"
# channels = { reference = 1, output = 2 }
# sampling_rate_Hz = 51200
# between_s = [1.0, 3.0]           # of every file

[reference]
file = "reference.csv"             # the certificate
k = 2

[reading]
u_relative = 0.001                 # of the ratio of one run: front end, cables, mounting
u_phase_deg = 0.1

[transverse]
"sensitivity_%" = 2                # of the device

[datasheet]
sensitivity = 10
tolerance = 0.5
unit = "mV/(m/s²)"

[ambient]
temperature_degC = 23
"#;

const TRANSVERSE: &str = r#"[runs]
file = "runs.csv"

[mounting]
u_tilt_deg = 0.05                  # of the base, in each of two directions
u_rotation_deg = 1.0

[datasheet]
"transverse_%" = 5
"#;

const FREE_LIVING: &str = r#"[recording]
file = "wrist.csv"                 # days of a logger: put your recording in its place
columns = { x = "x", y = "y", z = "z" }
time = "t"
# unit = "g"                       # where the headings do not say it
# temperature = "temperature"

# [gravity]                        # where it was worn; without it anywhere on the ground
# latitude_deg = 52.3
# height_m = 80

[method]
confidence = 0.95
"#;
