//! Words of a command line that are no numbers and no types of their own.

/// A stretch of time, `FROM,TO` in seconds.
pub(crate) fn stretch(text: &str) -> Result<[f64; 2], String> {
    let wrong = || format!("{text:?} is no interval of time: write FROM,TO in seconds");
    let (from, to) = text.split_once(',').ok_or_else(wrong)?;
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from < to => Ok([from, to]),
        _ => Err(wrong()),
    }
}

/// One of the words that a type has in files.
pub(crate) fn word<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, String> {
    let words = serde::de::value::StrDeserializer::<serde::de::value::Error>::new(text);
    T::deserialize(words).map_err(|e| e.to_string())
}

/// A number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err(format!("{text:?} is no positive number")),
    }
}

#[cfg(test)]
mod tests {
    use crate::simulate::{
        SimulatedAxis, SimulatedMultiPosition, SimulatedNoise, SimulatedShaker,
        SimulatedSpuriousMotion, SimulatedTransducer,
    };
    use crate::{ChannelReading, RecordingReading, noise::NoiseReading};
    use clap::{Args, Command};
    use std::fmt::Debug;

    fn same<T: Args + Default + PartialEq + Debug>() {
        let command = T::augment_args(Command::new("request"));
        let parsed = T::from_arg_matches(&command.get_matches_from(["request"]));
        assert_eq!(parsed.expect("no option is needed"), T::default());
    }

    #[test]
    fn law_without_options_a_request_is_its_default() {
        same::<SimulatedAxis>();
        same::<SimulatedMultiPosition>();
        same::<SimulatedNoise>();
        same::<SimulatedShaker>();
        same::<SimulatedSpuriousMotion>();
        same::<SimulatedTransducer>();
        same::<NoiseReading>();
        same::<RecordingReading>();
        same::<ChannelReading>();
    }

    #[test]
    fn refuses_stretches_that_end_before_they_begin() {
        assert_eq!(super::stretch("0.5, 2"), Ok([0.5, 2.0]));
        assert!(super::stretch("2,0.5").is_err());
        assert!(super::stretch("1").is_err());
        assert!(super::stretch("0,inf").is_err());
        assert!(super::positive("0").is_err());
    }
}
