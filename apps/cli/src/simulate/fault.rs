//! Faults to practise on.

use proofmass::rig::bench::laboratory::Fault;
use serde::Serialize;

/// What goes wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Practice {
    /// Cables of x and y exchanged in one run
    SwappedCables,
    /// Output z inverted in one run
    InvertedChannel,
    /// Output x beyond full scale in one run
    Clipped,
    /// Generator a tenth above the frequency of the table in one run
    WrongFrequency,
    /// Device glued 45° further than the table says in one run
    WrongMounting,
    /// One run is missing
    MissingRun,
    /// One configuration stands twice in the table
    DoubleRun,
}

impl Practice {
    /// What happens on the bench; `None` for what happens to the table.
    pub(super) fn on_the_bench(self) -> Option<Fault> {
        match self {
            Self::SwappedCables => Some(Fault::SwappedCables),
            Self::InvertedChannel => Some(Fault::InvertedChannel),
            Self::Clipped => Some(Fault::Clipped),
            Self::WrongFrequency => Some(Fault::WrongFrequency),
            Self::WrongMounting => Some(Fault::WrongMounting),
            Self::MissingRun | Self::DoubleRun => None,
        }
    }

    /// Whether only samples show it.
    pub(super) fn needs_samples(self) -> bool {
        matches!(self, Self::Clipped | Self::WrongFrequency)
    }
}

/// A fault and the number of its run, `swapped-cables:17`; without a number the run in the middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chosen {
    pub(super) practice: Practice,
    pub(super) run: Option<usize>,
}

impl std::str::FromStr for Chosen {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        use clap::ValueEnum;
        let (name, run) = match text.split_once(':') {
            Some((name, number)) => match number.parse::<usize>() {
                Ok(n) if n > 0 => (name, Some(n)),
                _ => return Err(format!("`{number}` is not the number of a run, from 1 up")),
            },
            None => (text, None),
        };
        let practice = Practice::from_str(name, false).map_err(|_| {
            let names: Vec<String> = Practice::value_variants()
                .iter()
                .filter_map(|p| Some(p.to_possible_value()?.get_name().to_owned()))
                .collect();
            format!("there is no fault `{name}`; known: {}", names.join(", "))
        })?;
        Ok(Self { practice, run })
    }
}
