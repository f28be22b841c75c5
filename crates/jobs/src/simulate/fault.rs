//! Faults to practise on.

use proofmass_rig::bench::laboratory::BenchFault;
use serde::{Deserialize, Serialize};

/// What goes wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Practice {
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
    /// Every fault.
    pub const ALL: [Self; 7] = [
        Self::SwappedCables,
        Self::InvertedChannel,
        Self::Clipped,
        Self::WrongFrequency,
        Self::WrongMounting,
        Self::MissingRun,
        Self::DoubleRun,
    ];

    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::SwappedCables => "swapped-cables",
            Self::InvertedChannel => "inverted-channel",
            Self::Clipped => "clipped",
            Self::WrongFrequency => "wrong-frequency",
            Self::WrongMounting => "wrong-mounting",
            Self::MissingRun => "missing-run",
            Self::DoubleRun => "double-run",
        }
    }

    /// What happens on the bench; `None` for what happens to the table.
    pub(super) fn on_the_bench(self) -> Option<BenchFault> {
        match self {
            Self::SwappedCables => Some(BenchFault::SwappedCables),
            Self::InvertedChannel => Some(BenchFault::InvertedChannel),
            Self::Clipped => Some(BenchFault::Clipped),
            Self::WrongFrequency => Some(BenchFault::WrongFrequency),
            Self::WrongMounting => Some(BenchFault::WrongMounting),
            Self::MissingRun | Self::DoubleRun => None,
        }
    }

    /// Whether only samples show it.
    pub(super) fn needs_samples(self) -> bool {
        matches!(self, Self::Clipped | Self::WrongFrequency)
    }
}

/// A fault and the number of its run, as text `swapped-cables:17`; without a number the run in the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PracticeFault {
    /// What goes wrong.
    pub(crate) practice: Practice,
    /// In which run, from one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) run: Option<usize>,
}

impl std::str::FromStr for PracticeFault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, run) = match text.split_once(':') {
            Some((name, number)) => match number.parse::<usize>() {
                Ok(n) if n > 0 => (name, Some(n)),
                _ => return Err(format!("`{number}` is not the number of a run, from 1 up")),
            },
            None => (text, None),
        };
        let found = Practice::ALL.iter().find(|p| p.name() == name);
        let practice = *found.ok_or_else(|| {
            let names: Vec<&str> = Practice::ALL.iter().map(|p| p.name()).collect();
            format!("there is no fault `{name}`; known: {}", names.join(", "))
        })?;
        Ok(Self { practice, run })
    }
}
