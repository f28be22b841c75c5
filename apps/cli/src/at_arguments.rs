//! Values at which a calibration is to hold.

use proofmass::documents::AnyCalibration;

/// Values of quantities of the surroundings.
#[derive(clap::Args)]
pub(crate) struct AtArguments {
    /// Value of a quantity that the calibration follows (humidity, pressure, supply voltage), in its unit there: bias and scale are
    /// those at this value, with their uncertainty; more than once
    #[arg(long, value_name = "NAME=VALUE", value_parser = named_value)]
    pub(crate) at: Vec<(String, f64)>,
}

impl AtArguments {
    /// What they hold the calibration at, in words.
    pub(crate) fn words(&self, calibration: &AnyCalibration) -> Vec<String> {
        let blocks = match calibration {
            AnyCalibration::Constant(file) => file.environment.as_slice(),
            _ => &[],
        };
        let word = |(name, value): &(String, f64)| {
            let unit = blocks.iter().find(|b| b.name == *name);
            let unit = unit.map_or(String::new(), |b| format!(" {}", b.unit));
            format!("at {name} = {value}{unit}")
        };
        self.at.iter().map(word).collect()
    }
}

fn named_value(text: &str) -> Result<(String, f64), String> {
    let read = text.split_once('=').and_then(|(name, value)| {
        let value: f64 = value.trim().parse().ok()?;
        let name = name.trim();
        (value.is_finite() && !name.is_empty()).then(|| (name.to_owned(), value))
    });
    read.ok_or_else(|| "a name and a number are needed, such as humidity=60".to_owned())
}
