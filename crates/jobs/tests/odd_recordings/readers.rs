//! Every reader of recordings, as the commands call them.

use super::files::Odd;
use proofmass_core::Unwatched;
use proofmass_documents::{AnyCalibration, CalibrationFile};
use proofmass_io::{ColumnRef, Input, Source, TimeUnit, Unit, Waveform, WaveformOptions};
use proofmass_jobs::apply::{ApplyData, ApplyJob, Destination};
use proofmass_jobs::bias::BiasRecording;
use proofmass_jobs::campaign::{Campaign, Draft};
use proofmass_jobs::noise::{NoiseJob, NoiseReading, NoiseSamples};
use proofmass_jobs::response::ResponseRecordings;
use proofmass_jobs::static_test::{ReadingColumns, StaticTest, StaticTestFiles};
use proofmass_jobs::temperature::TemperatureRecording;
use proofmass_jobs::validation::ValidationRecording;
use proofmass_jobs::velocity::AxisSensors;
use proofmass_jobs::{ChannelReading, Job, Memory, RecordingReading, Trouble, WantedChannel};
use proofmass_static::static_test::Linearity;
use proofmass_uncertainty::Estimate;

/// How a reader finds the columns.
#[derive(Clone, Copy, PartialEq)]
pub enum Way {
    /// They are named.
    Named,
    /// By their headings.
    Alone,
    /// All columns of numbers are read.
    All,
    /// They are named, and rows have an order and no clock.
    Table,
    /// They are named, and no clock is needed.
    Clockless,
}

/// What a person says beside the file.
#[derive(Clone, Copy, Default)]
pub struct Said {
    pub time_unit: Option<TimeUnit>,
    pub unit: Option<Unit>,
    pub rate: Option<f64>,
    pub between: Option<[f64; 2]>,
}

/// How a file was read.
pub struct Read {
    /// The line that tells it.
    pub line: String,
    /// Mean of z, m/s², where the reader shows it.
    pub z: Option<f64>,
}

type Answer = Result<Read, Trouble>;
pub type Reader = (&'static str, Way, fn(&Odd, &Said) -> Answer);

pub const READERS: [Reader; 19] = [
    ("calibrate RECORDING --columns", Way::Named, drafted),
    ("calibrate RECORDING", Way::Alone, found),
    ("calibrate, a tumble", Way::Named, tumbled),
    ("calibrate RECORDING --free-living", Way::Alone, worn),
    ("single-axis", Way::Named, one_axis),
    ("noise", Way::All, noise),
    ("noise --columns", Way::Named, noise_of_axes),
    ("noise --stream", Way::All, noise_stream),
    ("validate", Way::Named, validated),
    ("validate, streamed", Way::Named, validated_stream),
    ("apply", Way::Clockless, applied),
    ("bias", Way::Named, bias),
    ("test zero-g", Way::Named, rest),
    ("test temperature", Way::Named, temperature),
    ("test shock", Way::Named, channel),
    ("test impact", Way::Named, response),
    ("velocity", Way::Named, velocity),
    ("a shaker campaign", Way::Named, waveform),
    // Rows of a table have an order and no clock.
    ("test linearity", Way::Table, table),
];

/// Every reader that has a clock, and one thing that is said.
pub fn stated(odd: &Odd, say: impl Fn(&mut Said)) -> Vec<(&'static str, String)> {
    let mut said = Said::default();
    say(&mut said);
    let clockless = |way: Way| way == Way::Clockless || way == Way::Table;
    let clocked = READERS.iter().filter(|reader| !clockless(reader.1));
    clocked
        .map(|(name, _, read)| match read(odd, &said) {
            Ok(read) => (*name, read.line),
            Err(trouble) => panic!("{}, {name}: {trouble} {:?}", odd.name, trouble.hint()),
        })
        .collect()
}

fn source(odd: &Odd) -> Source {
    Source::from_bytes(odd.name, odd.bytes.clone()).unwrap()
}

/// Of the inputs the one that was read as a recording.
fn told(inputs: &[Input], z: Option<f64>) -> Answer {
    let input = inputs.iter().find(|input| input.reading.is_some());
    let input = input.expect("a recording tells how it was read");
    let reading = input.reading.as_ref().unwrap();
    Ok(Read {
        line: reading.line(&input.path),
        z,
    })
}

fn mean(values: &[f64]) -> Option<f64> {
    Some(values.iter().sum::<f64>() / values.len() as f64)
}

fn axes(odd: &Odd) -> Vec<ColumnRef> {
    odd.axes
        .iter()
        .map(|axis| ColumnRef::from_word(axis))
        .collect()
}

fn draft(odd: &Odd, said: &Said, change: impl FnOnce(&mut Draft)) -> Answer {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(odd.name);
    std::fs::write(&path, &odd.bytes).unwrap();
    let mut draft = Draft::default();
    draft.unit = said.unit;
    draft.time_unit = said.time_unit;
    draft.rate_hz = said.rate;
    draft.between = said.between;
    draft.gravity = Some((9.81, 1e-4));
    change(&mut draft);
    match draft.campaign(&path)? {
        Campaign::MultiPosition(campaign) => {
            let files = campaign.load(&Unwatched)?;
            told(files.inputs(), mean(files.data().outputs[2]))
        }
        Campaign::FreeLiving(campaign) => told(&campaign.load(&Unwatched)?.inputs, None),
        _ => panic!("another kind"),
    }
}

fn drafted(odd: &Odd, said: &Said) -> Answer {
    draft(odd, said, |d| d.columns = Some(odd.axes.map(str::to_owned)))
}

fn found(odd: &Odd, said: &Said) -> Answer {
    draft(odd, said, |_| {})
}

fn tumbled(odd: &Odd, said: &Said) -> Answer {
    draft(odd, said, |d| {
        d.columns = Some(odd.axes.map(str::to_owned));
        d.rows = proofmass_jobs::campaign::RowsAre::Tumble;
    })
}

fn worn(odd: &Odd, said: &Said) -> Answer {
    draft(odd, said, |d| {
        d.free_living = true;
        d.gravity = None;
    })
}

fn one_axis(odd: &Odd, said: &Said) -> Answer {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(odd.name), &odd.bytes).unwrap();
    let column = match odd.axes[2].parse::<usize>() {
        Ok(number) => number.to_string(),
        Err(_) => format!("{:?}", odd.axes[2]),
    };
    let mut text = format!(
        "kind = \"single-axis\"\n[recording]\nfiles = [{:?}]\ncolumn = {column}\n",
        odd.name
    );
    if let Some(unit) = said.unit {
        text += &format!("unit = \"{unit}\"\n");
    }
    if let Some(unit) = said.time_unit {
        text += &format!("time_unit = \"{unit}\"\n");
    }
    if let Some(rate) = said.rate {
        text += &format!("sampling_rate_Hz = {rate}\n");
    }
    if let Some([from, to]) = said.between {
        text += &format!("between_s = [{from:?}, {to:?}]\n");
    }
    text += "[position]\nangles_deg = [0]\n[gravity]\nvalue = 9.81\nstandard_uncertainty = 1e-4\n";
    let path = folder.path().join("campaign.toml");
    std::fs::write(&path, text).unwrap();
    let Campaign::SingleAxis(campaign) = Campaign::open(&path)? else {
        panic!("another kind");
    };
    let files = campaign.load(&Unwatched)?;
    told(&campaign.record(&files, None).inputs, None)
}

fn noise_reading(said: &Said) -> NoiseReading {
    let mut reading = NoiseReading::default();
    reading.unit = said.unit;
    reading.time_unit = said.time_unit;
    reading.rate = said.rate;
    reading.between = said.between.map(|b| b.to_vec());
    // A unit that is said is that of the columns which are named.
    if said.unit.is_some() {
        reading.columns = Some(["ax", "ay", "az"].map(ColumnRef::from).to_vec());
    }
    reading
}

fn noise_read(odd: &Odd, reading: &NoiseReading) -> Answer {
    let recording = reading.read(source(odd))?;
    let NoiseSamples::Slices { channels, .. } = recording.data().samples else {
        panic!("a stream");
    };
    let z = channels
        .iter()
        .find(|c| c.name == "az" || c.name == "column 4");
    told(&[recording.input()], z.and_then(|z| mean(z.rate)))
}

fn noise(odd: &Odd, said: &Said) -> Answer {
    noise_read(odd, &noise_reading(said))
}

fn noise_of_axes(odd: &Odd, said: &Said) -> Answer {
    let mut reading = noise_reading(said);
    reading.columns = Some(axes(odd));
    noise_read(odd, &reading)
}

fn noise_stream(odd: &Odd, said: &Said) -> Answer {
    let mut stream = noise_reading(said).stream(source(odd))?;
    let data = stream.data();
    let NoiseSamples::Stream { blocks, .. } = &data.samples else {
        panic!("no stream");
    };
    while blocks.lock().unwrap().next_block()?.is_some() {}
    if blocks.lock().unwrap().rate().is_none() {
        let mut again = noise_reading(said).stream(source(odd))?;
        let refused = NoiseJob::default().evaluate(&again.data(), &Unwatched);
        return Err(refused.expect_err("a rate"));
    }
    drop(data);
    told(&[stream.finish()?], None)
}

fn recording_reading(odd: &Odd, said: &Said) -> RecordingReading {
    let mut reading = RecordingReading::default();
    reading.columns = Some(axes(odd));
    reading.unit = said.unit;
    reading.time_unit = said.time_unit;
    reading.rate = said.rate;
    reading.between = said.between.map(|b| b.to_vec());
    reading
}

fn calibration() -> CalibrationFile {
    let k = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let estimate = Estimate::new(vec![], vec![]).unwrap();
    CalibrationFile::new("full", Unit::MetrePerSecondSquared, k, [0.0; 3], estimate)
}

fn calibration_source() -> Source {
    Source::from_bytes("c.json", calibration().to_json().unwrap()).unwrap()
}

fn validated(odd: &Odd, said: &Said) -> Answer {
    let reading = recording_reading(odd, said);
    let read = ValidationRecording::read(calibration_source(), source(odd), &reading, None)?;
    told(&read.record(None).inputs, mean(read.data().outputs[2]))
}

fn validated_stream(odd: &Odd, said: &Said) -> Answer {
    let reading = recording_reading(odd, said);
    let read =
        ValidationRecording::stream(calibration_source(), source(odd), &reading, &Unwatched)?;
    told(&read.record(None).inputs, mean(read.data().outputs[2]))
}

fn applied(odd: &Odd, said: &Said) -> Answer {
    let mut job = ApplyJob::default();
    job.reading = recording_reading(odd, said);
    let (calibration, mut bytes) = (AnyCalibration::from(calibration()), Vec::new());
    let data = ApplyData::new(&calibration, source(odd), Destination::Bytes(&mut bytes));
    told(
        &[job.evaluate(&data, &Unwatched)?.recording().clone()],
        None,
    )
}

fn bias(odd: &Odd, said: &Said) -> Answer {
    let read = BiasRecording::read(source(odd), &recording_reading(odd, said), None, None)?;
    told(&read.record(None).inputs, mean(read.data().outputs[2]))
}

fn rest(odd: &Odd, said: &Said) -> Answer {
    let read = StaticTestFiles::rest(source(odd), &recording_reading(odd, said))?;
    told(&read.record(None).inputs, None)
}

/// The position is a thermometer as good as any.
fn temperature(odd: &Odd, said: &Said) -> Answer {
    let named = |text: String| text.replacen("p (m)", "p (°C)", 1);
    let coded = |unit: fn([u8; 2]) -> u16, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let pairs = odd.bytes.chunks_exact(2).map(|p| unit([p[0], p[1]]));
        let text = String::from_utf16(&pairs.collect::<Vec<u16>>()).unwrap();
        named(text).encode_utf16().flat_map(bytes).collect()
    };
    let odd_bytes = match odd.bytes[..] {
        [0xFF, 0xFE, ..] => coded(u16::from_le_bytes, u16::to_le_bytes),
        [0xFE, 0xFF, ..] => coded(u16::from_be_bytes, u16::to_be_bytes),
        _ => match String::from_utf8(odd.bytes.clone()) {
            Ok(text) => named(text).into_bytes(),
            Err(_) => odd.bytes.clone(),
        },
    };
    let source = Source::from_bytes(odd.name, odd_bytes).unwrap();
    let column = ColumnRef::from_word(odd.position);
    let read =
        TemperatureRecording::read(source, column, &[], &recording_reading(odd, said), None)?;
    told(&read.record(None).inputs, None)
}

fn clock(said: &Said) -> ChannelReading {
    let mut clock = ChannelReading::default();
    clock.time_unit = said.time_unit;
    clock.rate = said.rate;
    clock.between = said.between.map(|b| b.to_vec());
    clock
}

fn channel(odd: &Odd, said: &Said) -> Answer {
    let z = ColumnRef::from_word(odd.axes[2]);
    let wanted = [WantedChannel::new(z, said.unit, "--unit")];
    let read = clock(said).read(source(odd), &wanted)?;
    told(
        std::slice::from_ref(&read.input),
        mean(&read.channels[0].data),
    )
}

fn response(odd: &Odd, said: &Said) -> Answer {
    let [x, z] = [0, 2].map(|axis| ColumnRef::from_word(odd.axes[axis]));
    let wanted = [
        WantedChannel::new(x, said.unit, "--input-unit"),
        WantedChannel::new(z, said.unit, "--output-unit"),
    ];
    let read = ResponseRecordings::read([source(odd)], &clock(said), &wanted)?;
    told(&read.inputs(), mean(read.data().recordings[0][1].data))
}

fn velocity(odd: &Odd, said: &Said) -> Answer {
    let files = Memory::new().file(odd.name, odd.bytes.clone());
    let mut sensors = AxisSensors::default();
    sensors.recording = odd.name.into();
    sensors.reading.position = Some(vec![odd.position.into()]);
    sensors.acceleration = vec![odd.axes[2].into()];
    sensors.acceleration_unit = said.unit;
    sensors.time_unit = said.time_unit;
    sensors.rate = said.rate;
    sensors.between = said.between.map(|b| b.to_vec());
    let read = sensors.load(&files, None, &Unwatched)?;
    told(
        &read.record(None).inputs,
        mean(&read.data().record.acceleration),
    )
}

fn table(odd: &Odd, _: &Said) -> Answer {
    let test = StaticTest::Linearity(Linearity::default());
    let [x, z] = [0, 2].map(|axis| ColumnRef::from_word(odd.axes[axis]));
    let read = StaticTestFiles::readings(source(odd), &test, &x, &ReadingColumns::new(z))?;
    told(&read.record(None).inputs, None)
}

/// A recording of a shaker, in a text table.
fn waveform(odd: &Odd, said: &Said) -> Answer {
    let options = WaveformOptions {
        sampling_rate_hz: said.rate,
        channels: vec![("x".to_owned(), ColumnRef::from_word(odd.axes[2]))],
        channel_count: 1,
        unit: said.unit,
        quantity: Unit::MetrePerSecondSquared,
        time_unit: said.time_unit,
        between: said.between,
        ..WaveformOptions::default()
    };
    let read = Waveform::from_source(source(odd), &options)?;
    let mut answer = told(&[read.input()], mean(&read.channels[0]))?;
    // What the column is taken for stands behind its name.
    assert!(answer.line.contains(" as x "), "{}", answer.line);
    answer.line = answer.line.replace(" as x ", " ");
    Ok(answer)
}

/// A recording without the columns of the calibration: what `validate` and `apply` say of it.
pub fn without_columns_of_the_calibration() -> [Trouble; 2] {
    let all = Odd::all();
    let odd = all.iter().find(|odd| odd.name == "seconds.csv").unwrap();
    let mut file = calibration();
    file.columns = Some(["a", "b", "c"].map(ColumnRef::from).to_vec());
    let json = file.to_json().unwrap();
    let reading = RecordingReading::default();
    let of_file = Source::from_bytes("c.json", json).unwrap();
    let validated = ValidationRecording::read(of_file, source(odd), &reading, None);
    let (calibration, mut bytes) = (AnyCalibration::from(file), Vec::new());
    let data = ApplyData::new(&calibration, source(odd), Destination::Bytes(&mut bytes));
    let applied = ApplyJob::default().evaluate(&data, &Unwatched);
    [validated.err().unwrap(), applied.err().unwrap()]
}
