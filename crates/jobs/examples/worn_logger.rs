//! A file of a logger on a wrist with known sensitivities and offsets, as CWA (Axivity AX3) or gt3x (ActiGraph), written as it is
//! recorded: a week takes no memory.
//!
//!     cargo run --release -p proofmass-jobs --example worn_logger -- 7 100 week.cwa
//!     proofmass calibrate week.cwa --free-living --latitude 45

use std::io::{BufWriter, Result, Write};

/// Sensitivities and offsets of the logger: output = (g − c (T − 25 °C)) / s − o, in g.
pub const SCALE: [f64; 3] = [0.990, 1.012, 0.985];
/// Offsets, g.
pub const OFFSET: [f64; 3] = [-0.020, 0.035, 0.050];
/// Standard deviation of its noise, g.
const NOISE: f64 = 0.006;
/// Seconds of a posture.
const POSTURE: f64 = 300.0;

/// Samples of a logger that is worn: at rest in a posture for four minutes, then moved.
pub struct Wear {
    state: u64,
    rate: f64,
    sample: u64,
    up: [f64; 3],
}

impl Wear {
    /// From its beginning.
    pub fn new(rate: f64) -> Self {
        Self {
            state: 17,
            rate,
            sample: 0,
            up: [0.0, 0.0, 1.0],
        }
    }

    /// Uniform between ±1.
    fn draw(&mut self) -> f64 {
        self.state = self
            .state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The next sample, g.
    pub fn next_sample(&mut self) -> [f64; 3] {
        let time = self.sample as f64 / self.rate;
        let before = (self.sample as f64 - 1.0) / self.rate;
        if self.sample == 0 || (time / POSTURE).floor() > (before / POSTURE).floor() {
            let v: [f64; 3] = std::array::from_fn(|_| self.draw());
            let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
            self.up = v.map(|c| c / length);
        }
        self.sample += 1;
        let moved = time % POSTURE > 0.8 * POSTURE;
        std::array::from_fn(|k| {
            let motion = match moved {
                true => 0.3 * (time * (7.0 + k as f64)).sin(),
                false => 0.0,
            };
            // Three of them together are nearly normal.
            let noise = NOISE * (self.draw() + self.draw() + self.draw());
            (self.up[k] + motion) / SCALE[k] - OFFSET[k] + noise
        })
    }
}

/// Whole steps of a converter, as they are stored.
fn steps(sample: [f64; 3], per_g: f64, most: i16) -> [i16; 3] {
    sample.map(|v| ((v * per_g).round() as i16).clamp(-most, most))
}

/// Writes so many blocks of 120 samples as CWA: 256 steps for 1 g, three axes of ten bits in a word. The rate is 3200 Hz over a power
/// of two.
pub fn cwa(to: &mut dyn Write, blocks: u32, rate: f64) -> Result<()> {
    let mut header = b"MD\xFC\x03".to_vec();
    header.resize(1024, 0xFF);
    to.write_all(&header)?;
    let code = 15 - (3200.0 / rate).log2().round() as u8;
    let mut wear = Wear::new(rate);
    for sequence in 0..blocks {
        let begin = f64::from(sequence) * 120.0 / rate;
        let whole = begin.floor() as u32;
        let part = ((begin - begin.floor()) * 32_768.0).round().min(32_767.0) as u16;
        let late = (i64::from(part) * 2 * rate.floor() as i64) >> 16;
        let (day, second) = (whole / 86_400, whole % 86_400);
        let stamp = 26 << 26 | 3 << 22 | (1 + day) << 17;
        let stamp = stamp | (second / 3600) << 12 | (second / 60 % 60) << 6 | (second % 60);
        let mut block = b"AX\xFC\x01".to_vec();
        block.extend((0x8000 | part).to_le_bytes());
        block.extend([0; 4]);
        block.extend(sequence.to_le_bytes());
        block.extend(stamp.to_le_bytes());
        // Light; 266 steps of the thermometer are 27.9 °C; events, battery.
        block.extend([0, 0, 0x0A, 0x01, 0, 0]);
        block.extend([0x40 | code, 0x30]);
        block.extend((-late as i16).to_le_bytes());
        block.extend(120_u16.to_le_bytes());
        for _ in 0..120 {
            // Ten bits with an exponent of two: what does not fit is stored with fewer bits.
            let [x, y, z] = steps(wear.next_sample(), 256.0, 2047);
            let largest = [x, y, z].map(i16::unsigned_abs).into_iter().max();
            let exponent = if largest > Some(511) { 2 } else { 0 };
            let bits = |v: i16| u32::from((v >> exponent) as u16 & 0x3FF);
            let word = bits(x) | bits(y) << 10 | bits(z) << 20 | exponent << 30;
            block.extend(word.to_le_bytes());
        }
        block.resize(510, 0);
        let words = block
            .chunks_exact(2)
            .map(|w| u16::from_le_bytes([w[0], w[1]]));
        let sum = words.fold(0_u16, u16::wrapping_add);
        block.extend(sum.wrapping_neg().to_le_bytes());
        to.write_all(&block)?;
    }
    Ok(())
}

/// Writes so many seconds as gt3x: 256 steps for 1 g, sixteen bits, an archive without packing.
pub fn gt3x(to: &mut dyn Write, seconds: u32, rate: u32) -> Result<()> {
    let info = format!("Sample Rate: {rate}\r\nAcceleration Scale: 256.0\r\n");
    let mut wear = Wear::new(f64::from(rate));
    let mut log = Vec::new();
    for second in 0..seconds {
        let payload: Vec<u8> = (0..rate)
            .flat_map(|_| steps(wear.next_sample(), 256.0, 2047))
            .flat_map(i16::to_le_bytes)
            .collect();
        let mut record = vec![0x1E, 26];
        record.extend((1_700_000_000 + second).to_le_bytes());
        record.extend((payload.len() as u16).to_le_bytes());
        record.extend(payload);
        record.push(!record.iter().fold(0, |sum, v| sum ^ v));
        log.extend(record);
    }
    let (mut all, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in [("info.txt", info.as_bytes()), ("log.bin", &log)] {
        let common = [
            &[20, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
            &crc(content).to_le_bytes(),
            &(content.len() as u32).to_le_bytes(),
            &(content.len() as u32).to_le_bytes(),
            &(name.len() as u16).to_le_bytes(),
            &[0, 0],
        ]
        .concat();
        let at = (all.len() as u32).to_le_bytes();
        directory.extend([&b"PK\x01\x02\x14\0"[..], &common, &[0; 10], &at].concat());
        directory.extend(name.as_bytes());
        all.extend([&b"PK\x03\x04"[..], &common, name.as_bytes(), content].concat());
    }
    let end = [
        &b"PK\x05\x06\0\0\0\0\x02\0\x02\0"[..],
        &(directory.len() as u32).to_le_bytes(),
        &(all.len() as u32).to_le_bytes(),
        &[0, 0],
    ];
    to.write_all(&[all, directory, end.concat()].concat())
}

/// The check sum of ZIP.
fn crc(bytes: &[u8]) -> u32 {
    let bit = |sum: u32| (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg());
    let byte = |sum: u32, b: &u8| (0..8).fold(sum ^ u32::from(*b), |sum, _| bit(sum));
    !bytes.iter().fold(u32::MAX, byte)
}

#[allow(dead_code, reason = "not called where a test includes this file")]
fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let parsed = match &arguments[..] {
        [days, rate, file] => days
            .parse::<f64>()
            .ok()
            .zip(rate.parse::<f64>().ok())
            .zip(Some(file)),
        _ => None,
    };
    let Some(((days, rate), file)) = parsed else {
        eprintln!("usage: worn_logger DAYS RATE FILE.cwa|FILE.gt3x");
        std::process::exit(2);
    };
    let mut to = BufWriter::new(std::fs::File::create(file)?);
    match file.ends_with(".gt3x") {
        true => gt3x(&mut to, (days * 86_400.0) as u32, rate as u32)?,
        false => cwa(&mut to, (days * 86_400.0 * rate / 120.0) as u32, rate)?,
    }
    to.flush()
}
