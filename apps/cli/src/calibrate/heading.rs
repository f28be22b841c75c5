//! Head of a report: the title and what is known of device and conditions.

use crate::clock;
use proofmass::io::{Ambient, Device};

/// The title that was given, or one from the name of the device.
pub(super) fn title(given: Option<&String>, device: &Device, without: &str) -> String {
    given.cloned().unwrap_or_else(|| {
        let words: Vec<&str> = [&device.manufacturer, &device.model, &device.serial]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        if words.is_empty() {
            without.to_owned()
        } else {
            format!("Calibration of {}", words.join(" "))
        }
    })
}

/// Label and value of what is known.
pub(super) fn meta(device: &Device, ambient: &Ambient) -> Vec<(String, String)> {
    [
        ("Manufacturer", device.manufacturer.clone()),
        ("Model", device.model.clone()),
        ("Serial number", device.serial.clone()),
        ("Device", device.description.clone()),
        (
            "Temperature",
            ambient.temperature_deg_c.map(|t| format!("{t} °C")),
        ),
        ("Conditions", ambient.description.clone()),
        ("Evaluated on", Some(clock::today())),
    ]
    .into_iter()
    .filter_map(|(label, value)| Some((label.to_owned(), value?)))
    .collect()
}
