//! What a result is filed with: device, conditions, date, inputs. The caller knows it, not the mathematics.

use proofmass_core::Gravity;
use proofmass_documents::{Ambient, Device};
use proofmass_io::{Input, ReadGravity, Software};
use proofmass_uncertainty::{DegreesOfFreedom, Quantity};
use serde::{Deserialize, Serialize};

/// Everything about a result that is no result: who, what, when, from which files.
#[doc(alias("provenance"))]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// One line for the head of the report; where it is missing the job has one of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The device.
    pub device: Device,
    /// Conditions.
    pub ambient: Ambient,
    /// Day of the evaluation, as it is to be printed (ISO 8601).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Files it was computed from.
    pub inputs: Vec<Input>,
    /// Program that computed it.
    pub software: Software,
}

/// Gravity as a quantity of a calibration.
pub(crate) fn gravity_quantity(gravity: Gravity) -> Quantity {
    Quantity {
        name: "gravity".to_owned(),
        unit: "m/s²".to_owned(),
        value: gravity.value(),
        standard_uncertainty: gravity.standard_uncertainty(),
        dof: DegreesOfFreedom::INFINITE,
    }
}

/// Local gravity with who says it: nobody, a place, or whoever stated the value.
pub(crate) fn gravity_of(gravity: Gravity, standard: bool, place: Option<[f64; 2]>) -> ReadGravity {
    let by = match (standard, place) {
        (true, _) => "standard gravity".to_owned(),
        (false, Some([latitude, height])) => {
            format!("by latitude {latitude}° and height {height} m")
        }
        (false, None) => "as stated".to_owned(),
    };
    ReadGravity {
        normal_at: place.filter(|_| !standard),
        ..read_gravity(gravity, by)
    }
}

/// Local gravity and where it comes from, for the line that tells how a recording was read.
pub(crate) fn read_gravity(gravity: Gravity, by: impl Into<String>) -> ReadGravity {
    ReadGravity {
        value: gravity.value(),
        standard_uncertainty: gravity.standard_uncertainty(),
        by: by.into(),
        normal_at: None,
    }
}

/// Files that were read each in its own way and open a page or a message.
pub(crate) const READINGS: usize = 3;

/// A long path by its last two parts, which tell it apart; the list of inputs has it whole.
fn shortened(path: &str) -> String {
    /// Parts that are shown.
    const PARTS: usize = 3;
    let parts: Vec<&str> = path.split(['/', '\\']).filter(|p| !p.is_empty()).collect();
    match parts[..] {
        [.., folder, file] if parts.len() > PARTS => format!("…/{folder}/{file}"),
        _ => path.to_owned(),
    }
}

/// How each recording was read, in one line each; files that were read alike share a line.
fn readings(inputs: &[Input]) -> Vec<String> {
    let mut groups: Vec<(String, usize, String)> = Vec::new();
    for input in inputs {
        let Some(reading) = input.reading.as_deref() else {
            continue;
        };
        let said = reading.to_string();
        match groups.iter_mut().find(|g| g.2 == said) {
            Some(group) => group.1 += 1,
            None => groups.push((shortened(&input.path), 0, said)),
        }
    }
    let line = |(path, more, said): (String, usize, String)| match more {
        0 => format!("{path}: {said}"),
        more => format!("{path} and {more} more: {said}"),
    };
    groups.into_iter().map(line).collect()
}

/// The first files by name, and how many more there are.
pub(crate) fn named(names: &[&str]) -> String {
    /// Files that are named.
    const NAMED: usize = 4;
    match names {
        [first @ .., _] if first.len() >= NAMED => {
            let more = names.len() - NAMED;
            format!("{} and {more} more", names[..NAMED].join(", "))
        }
        all => all.join(", "),
    }
}

/// What a message begins with: how the recordings were read, else which files, which have no columns to tell.
pub(crate) fn what_was_read(inputs: &[Input]) -> Vec<String> {
    let mut lines = readings(inputs);
    if lines.is_empty() && !inputs.is_empty() {
        let files: Vec<&str> = inputs.iter().map(|i| i.path.as_str()).collect();
        lines = vec![named(&files)];
    }
    if lines.len() > READINGS {
        let more = lines.len() - READINGS;
        lines.truncate(READINGS);
        lines.push(format!("{more} more"));
    }
    lines
}

impl Record {
    /// The title that was given, or one from the name of the device: `Calibration of …`.
    pub fn title(&self, of: &str, without: &str) -> String {
        self.title_of(&self.device, of, without)
    }

    /// The title that was given, or one from the name of a device that the result itself names.
    pub(crate) fn title_of(&self, device: &Device, of: &str, without: &str) -> String {
        if let Some(title) = &self.title {
            return title.clone();
        }
        match device.line().as_str() {
            "" => without.to_owned(),
            device => format!("{of} {device}"),
        }
    }

    /// How each recording was read, in one line each: what a page and a summary begin with.
    pub fn readings(&self) -> Vec<(String, String)> {
        let lines = readings(&self.inputs).into_iter();
        lines.map(|line| ("Read".to_owned(), line)).collect()
    }

    /// Label and value of what is known of device and conditions.
    pub fn meta(&self) -> Vec<(String, String)> {
        let device = &self.device;
        [
            ("Manufacturer", device.manufacturer.clone()),
            ("Model", device.model.clone()),
            ("Serial number", device.serial.clone()),
            ("Device", device.description.clone()),
            (
                "Temperature",
                self.ambient.temperature_deg_c.map(|t| format!("{t} °C")),
            ),
            ("Conditions", self.ambient.description.clone()),
            ("Evaluated on", self.date.clone()),
        ]
        .into_iter()
        .filter_map(|(label, value)| Some((label.to_owned(), value?)))
        .collect()
    }

    /// Names and digests of the inputs.
    pub fn digests(&self) -> Vec<(String, String)> {
        self.inputs
            .iter()
            .flat_map(Input::files)
            .map(|i| (i.path.clone(), i.sha256.clone()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_long_path_is_told_by_its_end() {
        assert_eq!(shortened("bench/runs/1.csv"), "bench/runs/1.csv");
        assert_eq!(shortened("/data/bench/runs/1.csv"), "…/runs/1.csv");
        assert_eq!(shortened("C:\\data\\runs\\1.csv"), "…/runs/1.csv");
        assert_eq!(shortened("1.csv"), "1.csv");
    }

    #[test]
    fn law_a_few_files_are_named_and_the_rest_counted() {
        assert_eq!(named(&["a", "b", "c", "d"]), "a, b, c, d");
        assert_eq!(
            named(&["a", "b", "c", "d", "e", "f"]),
            "a, b, c, d and 2 more"
        );
        assert_eq!(named(&[]), "");
    }
}
