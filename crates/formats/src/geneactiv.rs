//! GENEActiv loggers (.bin): a text of pages with hexadecimal samples, each page with its time.
//!
//! **Source** `[GENEActiv]`.

use crate::bytes::Order;
use crate::calendar::days;
use crate::raw::{Extent, Kind, Raw};
use crate::scaling::{From as Taken, Scaling, Step};
use crate::stream::{Clock, Column, Contents, Line, Remark, SeekRead, Source, Stream};
use crate::{Error, Result};
use std::io::{BufRead, BufReader, Read, SeekFrom};
use std::sync::Arc;

/// Digits of a sample: x, y and z of three, and three of light and button.
const SAMPLE: u64 = 12;
/// Digits of a whole page.
const PAGE: u64 = 3600;
/// No line of a whole file is longer.
const LINE: u64 = 8192;
/// Pages state their time in steps of half a second.
const RESOLUTION: f64 = 0.5;
/// From so many seconds on their resolution is no more than a thousandth of the rate that they give.
const LONG: f64 = 500.0;

pub(crate) fn read(file: &mut dyn SeekRead, _size: u64) -> Result<Contents> {
    file.seek(SeekFrom::Start(0))?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let mut found = Found::default();
    let (mut line, mut at) = (Vec::new(), 0);
    loop {
        line.clear();
        let length = reader.by_ref().take(LINE).read_until(b'\n', &mut line)? as u64;
        if length == 0 {
            break;
        }
        found.line(&line, at);
        at += length;
    }
    found.end();
    found.contents()
}

/// What the lines before the pages say; the rest of them are passed over.
#[derive(Debug, Default)]
struct Header {
    gains: [Option<f64>; 3],
    offsets: [Option<f64>; 3],
    volts: Option<f64>,
    lux: Option<f64>,
    pages: Option<u64>,
}

impl Header {
    fn line(&mut self, key: &str, value: &str) {
        let number = value.parse::<f64>().ok().filter(|v| v.is_finite());
        for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
            match key.strip_prefix(axis) {
                Some(" gain") => self.gains[i] = number.filter(|g| *g != 0.0),
                Some(" offset") => self.offsets[i] = number,
                _ => {}
            }
        }
        match key {
            "Volts" => self.volts = number.filter(|v| *v > 0.0),
            "Lux" => self.lux = number,
            "Number of Pages" => self.pages = value.parse().ok(),
            _ => {}
        }
    }
}

/// What the lines of a page say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Page {
    at: u64,
    sequence: Option<u64>,
    /// s.
    time: Option<f64>,
    temperature: Option<f64>,
    rate: Option<f64>,
}

/// Pages that follow one another, and sums over them.
#[derive(Debug, Default)]
struct Run {
    samples: u64,
    pages: f64,
    start: f64,
    /// Of the number of the first sample of a page, of its time from `start` on, of their products.
    number: f64,
    time: f64,
    square: f64,
    product: f64,
    last: f64,
    /// Smallest and largest distance of a time from the rate that is stated.
    off: [f64; 2],
}

impl Run {
    fn page(&mut self, time: f64, count: u64, rate: f64) {
        if self.samples == 0 {
            self.start = time;
        }
        let (number, time) = (self.samples as f64, time - self.start);
        let off = time - number / rate;
        self.off = [self.off[0].min(off), self.off[1].max(off)];
        self.pages += 1.0;
        self.number += number;
        self.time += time;
        self.square += number * number;
        self.product += number * time;
        self.last = time;
        self.samples += count;
    }

    /// Sums of squares and products about the means.
    fn about_means(&self) -> (f64, f64) {
        let square = self.square - self.number * self.number / self.pages;
        let product = self.product - self.number * self.time / self.pages;
        (square, product)
    }

    /// Time of its first sample, where the rate is known.
    fn begin(&self, rate: f64) -> f64 {
        self.start + (self.time - self.number / rate) / self.pages
    }
}

#[derive(Default)]
struct Found {
    header: Header,
    page: Option<Page>,
    /// A page whose samples are not all there, where they begin and how many they are: the last of the file, or damaged.
    short: Option<(Page, u64, u64)>,
    /// The last one with its samples.
    last: Option<(Page, u64)>,
    rate: Option<f64>,
    extents: Vec<Extent>,
    temperatures: Vec<Line>,
    runs: Vec<Run>,
    damaged: u64,
    first_damaged: Option<u64>,
    cut: Option<u64>,
}

impl Found {
    fn line(&mut self, bytes: &[u8], at: u64) {
        let blank = |b: &u8| b.is_ascii_whitespace() || *b == 0;
        let begin = at + bytes.iter().take_while(|b| blank(b)).count() as u64;
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_matches(|c: char| c == '\0' || c.is_ascii_whitespace());
        if text == "Recorded Data" {
            self.leave();
            let new = Page::default();
            self.page = Some(Page { at, ..new });
            return;
        }
        let pair = text.split_once(':');
        let pair = pair.map(|(key, value)| (key.trim(), value.trim()));
        match (&mut self.page, pair) {
            (None, Some((key, value))) if self.extents.is_empty() && self.damaged == 0 => {
                self.header.line(key, value);
            }
            (Some(page), Some((key, value))) => {
                let number = || value.parse::<f64>().ok().filter(|v| v.is_finite());
                match key {
                    "Sequence Number" => page.sequence = value.parse().ok(),
                    "Page Time" => page.time = seconds(value),
                    "Temperature" => page.temperature = number(),
                    "Measurement Frequency" => page.rate = number().filter(|r| *r >= 1.0),
                    _ => {}
                }
            }
            (Some(page), None) if !text.is_empty() => {
                let page = *page;
                self.page = None;
                let digits = text.len() as u64;
                let sound = text.bytes().all(|b| b.is_ascii_hexdigit()) && digits <= PAGE;
                if sound && digits < PAGE {
                    self.short = Some((page, begin, digits / SAMPLE));
                } else if !sound || !self.samples(page, begin, digits / SAMPLE) {
                    self.damage(page.at);
                }
            }
            _ => {}
        }
    }

    fn damage(&mut self, at: u64) {
        self.damaged += 1;
        self.first_damaged.get_or_insert(at);
    }

    /// Another page begins, so that one without all of its samples is damaged.
    fn leave(&mut self) {
        let page = self
            .page
            .take()
            .or(self.short.take().map(|(page, ..)| page));
        if let Some(page) = page {
            self.damage(page.at);
        }
    }

    /// The file ends, and a page without all of its samples is cut.
    fn end(&mut self) {
        if let Some((page, begin, count)) = self.short.take() {
            self.cut = Some(page.at);
            if count > 0 {
                self.samples(page, begin, count);
            }
        }
        self.cut = self.cut.or(self.page.map(|page| page.at));
    }

    /// Takes in the samples of a page; whether it says what is needed, and the rate of those before it.
    fn samples(&mut self, page: Page, begin: u64, count: u64) -> bool {
        let (Some(time), Some(sequence), Some(temperature), Some(rate)) =
            (page.time, page.sequence, page.temperature, page.rate)
        else {
            return false;
        };
        if *self.rate.get_or_insert(rate) != rate {
            return false;
        }
        let goes_on = self.last.is_some_and(|(last, count)| {
            let step = time - last.time.unwrap_or(time);
            last.sequence.and_then(|s| s.checked_add(1)) == Some(sequence)
                && (step - count as f64 / rate).abs() <= 2.0 * RESOLUTION
        });
        if !goes_on {
            self.runs.push(Run::default());
        }
        if let Some(run) = self.runs.last_mut() {
            run.page(time, count, rate);
        }
        self.extents.push(Extent {
            at: begin,
            stride: SAMPLE,
            count,
            chunks: 1,
            step: 0,
        });
        self.temperatures.push(Line {
            count,
            first: temperature,
            step: 0.0,
        });
        self.last = Some((page, count));
        true
    }

    /// The rate by the times of all pages, unless these are few and agree with the one that is stated.
    fn measured_rate(&self) -> Option<f64> {
        let stated = self.rate?;
        let longest = self.runs.iter().map(|run| run.last).fold(0.0, f64::max);
        let agree = |run: &Run| run.off[1] - run.off[0] <= RESOLUTION;
        if longest < LONG && self.runs.iter().all(agree) {
            return Some(stated);
        }
        let sums = self.runs.iter().map(Run::about_means);
        let (square, product) = sums.fold((0.0, 0.0), |(s, p), (a, b)| (s + a, p + b));
        let rate = square / product;
        // Where the times tell no rate near it, the stated one stands.
        Some(if (rate / stated - 1.0).abs() < 0.1 {
            rate
        } else {
            stated
        })
    }

    fn contents(self) -> Result<Contents> {
        let (Some(rate), Some(first)) = (self.measured_rate(), self.runs.first()) else {
            return Err(
                Error::new("is a recording of a GENEActiv logger without a whole page")
                    .with_hint("fetch the file again from the logger"),
            );
        };
        let mut remarks = Vec::new();
        let pages = self.extents.len() as u64;
        if let Some(at) = self.cut {
            remarks.push(Remark::cut(format!(
                "the file ends inside the page at byte {at}"
            )));
        } else if let Some(more) = self.header.pages.filter(|p| *p > pages + self.damaged) {
            remarks.push(Remark::cut(format!(
                "the file ends behind {} pages of the {more} that it announces",
                pages + self.damaged
            )));
        }
        if let Some(at) = self.first_damaged {
            let count = self.damaged;
            remarks.push(Remark::damaged(format!(
                "{count} pages, the first at byte {at}"
            )));
        }
        let rows = self.runs.iter().map(|run| run.samples).sum();
        let clock = match self.runs.len() {
            1 => Clock::Rate {
                hz: rate,
                start_s: 0.0,
            },
            _ => Clock::Times,
        };
        let zero = first.begin(rate);
        let times = self.runs.iter().map(|run| Line {
            count: run.samples,
            first: run.begin(rate) - zero,
            step: 1.0 / rate,
        });
        let times = Source::lines(times.collect());
        let extents = Arc::new(self.extents);
        let source =
            |kind, place: u64| Source::Raw(Raw::behind(&extents, kind, Order::Big, 3 * place));
        let mut stream = Stream::new("samples", clock, rows);
        for (place, axis) in (0..).zip(["acc_x", "acc_y", "acc_z"]) {
            let index = place as usize;
            let (gain, offset) = (self.header.gains[index], self.header.offsets[index]);
            let Some((gain, offset)) = gain.zip(offset) else {
                remarks.push(Remark::damaged(format!(
                    "the header has no gain and offset of {axis}, so that its numbers are as stored"
                )));
                stream.push(axis, None, Column::of(source(Kind::Hex, place)));
                continue;
            };
            let column = Column::scaled(source(Kind::Hex, place), to_g(gain, offset));
            stream.push(axis, Some("g".to_owned()), column);
            if let Some(channel) = stream.channels.last_mut() {
                channel.scaling = Some("linear".to_owned());
            }
        }
        let light = source(Kind::HexBits(2, 10), 3);
        let light = match self.header.lux.zip(self.header.volts) {
            Some((lux, volts)) => (
                Column::scaled(light, Scaling::linear(lux / volts, 0.0)),
                "lux",
            ),
            None => (Column::of(light), ""),
        };
        let unit = Some(light.1.to_owned()).filter(|u| !u.is_empty());
        stream.push("light", unit, light.0);
        stream.push("button", None, Column::of(source(Kind::HexBits(1, 1), 3)));
        let temperatures = Column::of(Source::lines(self.temperatures));
        stream.push("temperature", Some("°C".to_owned()), temperatures);
        if clock == Clock::Times {
            stream.push_times(times);
        }
        Ok(Contents {
            streams: vec![stream],
            remarks,
        })
    }
}

/// (100·raw − offset)/gain; the difference is exact, where that of two quotients would not be.
fn to_g(gain: f64, offset: f64) -> Scaling {
    let step = |from, slope, intercept| Step::Linear {
        from,
        slope,
        intercept,
    };
    Scaling {
        steps: vec![
            step(Taken::Stored(0), 100.0, -offset),
            step(Taken::Step(0), 1.0 / gain, 0.0),
        ],
    }
}

/// Seconds from some day on of `2013-05-30 10:12:54:500`.
fn seconds(text: &str) -> Option<f64> {
    let numbers = text
        .split(['-', ' ', ':'])
        .map(|part| part.parse::<u16>().ok());
    let numbers: Vec<i64> = numbers.map(|n| n.map(i64::from)).collect::<Option<_>>()?;
    let [year, month, day, hour, minute, second, thousandths] = numbers[..] else {
        return None;
    };
    let fits = (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && hour < 24
        && minute < 60
        && second < 61
        && thousandths < 1000;
    let whole = ((days(year, month, day) * 24 + hour) * 60 + minute) * 60 + second;
    fits.then_some(whole as f64 + thousandths as f64 / 1000.0)
}

#[cfg(test)]
mod tests;
