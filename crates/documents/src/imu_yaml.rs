//! The noise file of visual–inertial programs: flat `imu.yaml` (Kalibr) and `kalibr_imu_chain.yaml` (OpenVINS).

use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// One number with the reason for it, which becomes its comment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImuValue {
    /// The number.
    pub value: f64,
    /// Unit and reason, on one line.
    pub reason: String,
}

/// Noise of one sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImuSensorNoise {
    /// Continuous-time white noise density, two-sided: σ of a sample over the root of the rate.
    pub noise_density: ImuValue,
    /// Continuous-time density of the random walk of the bias.
    pub random_walk: ImuValue,
}

/// What the file says, in the order of the keys.
///
/// **Units** m/s²/√Hz and m/s³/√Hz, rad/s/√Hz and rad/s²/√Hz, Hz.
///
/// ```
/// use proofmass_documents::{ImuSensorNoise, ImuValue, ImuYaml};
///
/// let value = |value| ImuValue { value, reason: "largest of 3 axes".into() };
/// let noise = ImuSensorNoise { noise_density: value(2.0e-3), random_walk: value(3.0e-5) };
/// let file = ImuYaml {
///     rostopic: "/imu0".into(),
///     update_rate: 200.0,
///     accelerometer: Some(noise.clone()),
///     gyroscope: Some(noise),
/// };
/// let text = file.to_text();
/// assert!(text.contains("accelerometer_noise_density: 2.000000e-3"));
/// assert!(text.contains("rostopic: /imu0\n") && text.contains("update_rate: 200.0\n"));
/// assert!(file.to_chain_text().starts_with("%YAML:1.0"));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImuYaml {
    /// Topic of the messages.
    pub rostopic: String,
    /// Messages per second.
    pub update_rate: f64,
    /// The accelerometer, where it was recorded.
    pub accelerometer: Option<ImuSensorNoise>,
    /// The gyroscope, where it was recorded.
    pub gyroscope: Option<ImuSensorNoise>,
}

impl ImuYaml {
    /// Whether a text can be the name of a topic: letters, digits and `/ ~ _ - .`, no more than 255 of them.
    pub fn is_topic(text: &str) -> bool {
        let allowed = |c: char| c.is_ascii_alphanumeric() || "/~_-.".contains(c);
        !text.is_empty() && text.len() <= 255 && text.chars().all(allowed)
    }

    /// The topic, in quotes where a stored one is no plain word.
    fn topic(&self) -> String {
        match Self::is_topic(&self.rostopic) {
            true => self.rostopic.clone(),
            false => serde_json::Value::from(self.rostopic.as_str()).to_string(),
        }
    }

    /// The flat file that Kalibr reads.
    pub fn to_text(&self) -> String {
        let mut text = String::from(
            "# Continuous-time noise densities; standard deviation of one sample = noise_density * sqrt(update_rate).\n",
        );
        self.sensors(&mut text, "");
        let _ = writeln!(text, "rostopic: {}", self.topic());
        let _ = writeln!(text, "update_rate: {:?}", rounded(self.update_rate));
        text
    }

    /// The chain that OpenVINS reads: the same numbers for one unit whose frame is the body's.
    pub fn to_chain_text(&self) -> String {
        let mut text = String::from("%YAML:1.0\n\nimu0:\n");
        text.push_str("  T_i_b:\n");
        for row in 0..4 {
            let cells: Vec<&str> = (0..4)
                .map(|c| if c == row { "1.0" } else { "0.0" })
                .collect();
            let _ = writeln!(text, "    - [{}]", cells.join(", "));
        }
        self.sensors(&mut text, "  ");
        text.push_str("  model: kalibr\n");
        let _ = writeln!(text, "  rostopic: {}", self.topic());
        text.push_str("  time_offset: 0.0\n");
        let _ = writeln!(text, "  update_rate: {:?}", rounded(self.update_rate));
        text
    }

    fn sensors(&self, text: &mut String, indent: &str) {
        for (key, noise, density, walk) in [
            (
                "accelerometer",
                &self.accelerometer,
                "m/s^2/sqrt(Hz)",
                "m/s^3/sqrt(Hz)",
            ),
            (
                "gyroscope",
                &self.gyroscope,
                "rad/s/sqrt(Hz)",
                "rad/s^2/sqrt(Hz)",
            ),
        ] {
            let Some(noise) = noise else {
                let _ = writeln!(text, "{indent}# {key}: not in this recording");
                continue;
            };
            for (name, value, unit) in [
                ("noise_density", &noise.noise_density, density),
                ("random_walk", &noise.random_walk, walk),
            ] {
                let _ = writeln!(
                    text,
                    "{indent}{key}_{name}: {:.6e}  # {unit}; {}",
                    value.value,
                    value.reason.replace('\n', " ")
                );
            }
        }
    }
}

/// Nine digits: a rate read from stamps has more that mean nothing.
fn rounded(rate: f64) -> f64 {
    format!("{rate:.8e}").parse().unwrap_or(rate)
}
