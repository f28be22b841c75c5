//! Days of a logger as raw 32-bit floats, read piece by piece.

use super::FreeLivingWindows;
use crate::campaign::FreeLivingCampaign;
use crate::trouble::{Result, Trouble};
use proofmass_core::{STANDARD_GRAVITY, Watch};
use proofmass_io::{ColumnRef, Source};
use proofmass_static::StillWindows;
use std::io::Read;

/// Instants of a piece.
const PIECE: usize = 1 << 15;

impl FreeLivingCampaign {
    /// Little-endian floats, the channels of one instant side by side, nothing else in the file.
    pub(super) fn load_floats(
        &self,
        mut source: Source,
        watch: &dyn Watch,
    ) -> Result<FreeLivingWindows> {
        let table = &self.recording;
        let name = source.name().display().to_string();
        let Some(rate) = table.sampling_rate_hz else {
            return Err(
                Trouble::request(format!("{name}: the sampling rate is not known"))
                    .with_hint("raw floats say no time: add `sampling_rate_Hz` to [recording]"),
            );
        };
        let axes = [&table.columns.x, &table.columns.y, &table.columns.z];
        let wanted = axes.into_iter().chain(&table.temperature);
        let places: Vec<usize> = wanted
            .map(|column| match column {
                ColumnRef::Index(number) if *number > 0 => Ok(number - 1),
                other => Err(Trouble::request(format!(
                    "{name}: raw floats have no headings, and {other} is no number of a channel"
                ))
                .with_hint("count the channels from 1: columns = { x = 1, y = 2, z = 3 }")),
            })
            .collect::<Result<_>>()?;
        let last = places.iter().max().map_or(0, |last| last + 1);
        let count = table.channel_count.unwrap_or(last);
        if count < last {
            return Err(
                Trouble::request(format!("{name}: channel {last} of {count} channels")).with_hint(
                    "`channel_count` in [recording] says how many channels the file has",
                ),
            );
        }
        let Some(unit) = table.unit else {
            return Err(
                Trouble::request(format!("{name}: the unit of the axes is not said")).with_hint(
                    "raw floats have no headings: add unit = \"g\" (or \"m/s²\") to [recording]",
                ),
            );
        };
        let (si, factor) = unit.si();
        if !si.is_acceleration() {
            return Err(Trouble::data(format!("{name}: {unit} is no acceleration"))
                .with_hint("auto-calibration needs outputs in g or m/s²"));
        }
        let factor = factor / STANDARD_GRAVITY;
        let mut windows = StillWindows::new(self.job()?.rule)?;
        let size = source.size().unwrap_or(0);
        let frame = 4 * count;
        let mut piece = vec![0u8; PIECE * frame];
        let (mut held, mut instant) = (0, 0usize);
        loop {
            watch.step("reading", source.bytes_read(), size)?;
            let read = source.read(&mut piece[held..]);
            let read = read.map_err(|error| Trouble::data(format!("{name}: {error}")))?;
            held += read;
            let whole = held - held % frame;
            for bytes in piece[..whole].chunks_exact(frame) {
                let at = |place: usize| {
                    let b = &bytes[4 * place..4 * place + 4];
                    f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                };
                let output = [0, 1, 2].map(|axis| factor * at(places[axis]));
                if output.iter().any(|v| !v.is_finite()) {
                    return Err(Trouble::data(format!(
                        "{name}: instant {} (counted from 1) holds a value that is not finite",
                        instant + 1
                    ))
                    .with_hint("the file is damaged there, has another number of channels (`channel_count`), or is no file of little-endian 32-bit floats"));
                }
                let temperature = places.get(3).map(|place| at(*place));
                windows.push(instant as f64 / rate, output, temperature);
                instant += 1;
            }
            piece.copy_within(whole..held, 0);
            held -= whole;
            if read == 0 {
                break;
            }
        }
        if held > 0 || instant == 0 {
            return Err(Trouble::data(format!(
                "{name}: {} bytes are no whole number of instants of {count} channels of 4 bytes",
                instant * frame + held
            ))
            .with_hint("the file is empty or was cut short, or `channel_count` in [recording] is not that of the file"));
        }
        Ok(FreeLivingWindows {
            seen: windows.seen(),
            findings: super::filled(&windows).into_iter().collect(),
            still: windows.finish(),
            inputs: vec![self.source.input.clone(), source.finish()?],
            name,
            columns: Some(axes.map(Clone::clone)),
        })
    }
}
