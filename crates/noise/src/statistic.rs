//! The statistics by name: the family of two-sample and three-sample variances.

use serde::{Deserialize, Serialize};

/// A stability statistic. All are deviations (square roots of variances).
///
/// **Source** `[SP1065] 5.2`; the formula stands at each function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Statistic {
    /// ADEV, neighbouring averages without overlap.
    Allan,
    /// OADEV, every start: the usual choice.
    OverlappingAllan,
    /// MDEV: tells white from flicker phase noise.
    ModifiedAllan,
    /// TDEV = τ MDEV/√3, in U·s.
    Time,
    /// HDEV: three samples, blind to a linear drift of the rate.
    Hadamard,
    /// OHDEV, every start.
    OverlappingHadamard,
    /// TOTDEV: the record extended by odd reflection, reaches τ = T/2.
    Total,
    /// MTOTDEV: the total idea applied to the modified variance.
    ModifiedTotal,
    /// TTOTDEV = τ MTOTDEV/√3, in U·s.
    TimeTotal,
    /// HTOTDEV: the total idea applied to the Hadamard variance.
    HadamardTotal,
    /// THEO1: reaches τ = 3T/4; even m of at least 10 only, effective τ = 0.75 m τ0.
    Theo1,
    /// THEOH: the overlapping Allan deviation up to a fifth of the record, beyond THEO1 scaled to it.
    TheoHybrid,
    /// PDEV, the parabolic deviation: as MDEV tells white from flicker phase noise, with less scatter.
    Parabolic,
}

impl Statistic {
    /// Every statistic, in the order of the documentation.
    pub const ALL: [Self; 13] = [
        Self::Allan,
        Self::OverlappingAllan,
        Self::ModifiedAllan,
        Self::Time,
        Self::Hadamard,
        Self::OverlappingHadamard,
        Self::Total,
        Self::ModifiedTotal,
        Self::TimeTotal,
        Self::HadamardTotal,
        Self::Theo1,
        Self::TheoHybrid,
        Self::Parabolic,
    ];

    /// Usual abbreviation.
    pub fn abbreviation(self) -> &'static str {
        match self {
            Self::Allan => "ADEV",
            Self::OverlappingAllan => "OADEV",
            Self::ModifiedAllan => "MDEV",
            Self::Time => "TDEV",
            Self::Hadamard => "HDEV",
            Self::OverlappingHadamard => "OHDEV",
            Self::Total => "TOTDEV",
            Self::ModifiedTotal => "MTOTDEV",
            Self::TimeTotal => "TTOTDEV",
            Self::HadamardTotal => "HTOTDEV",
            Self::Theo1 => "THEO1",
            Self::TheoHybrid => "THEOH",
            Self::Parabolic => "PDEV",
        }
    }

    /// Whether it is a time and not a rate: in U·s.
    pub fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::TimeTotal)
    }

    /// Unit of a deviation of a rate in this unit: itself, or times s.
    pub fn unit(self, rate: &str) -> String {
        if self.is_time() {
            crate::Term::Quantisation.unit(rate)
        } else {
            rate.to_owned()
        }
    }

    /// Effective averaging time of factor m: m τ0, and 0.75 m τ0 for THEO1.
    pub fn tau(self, m: usize, sample_rate: f64) -> f64 {
        let tau = m as f64 / sample_rate;
        if self == Self::Theo1 { 0.75 * tau } else { tau }
    }

    pub(crate) fn even_factors_only(self) -> bool {
        self == Self::Theo1
    }

    /// Smallest and largest averaging factor for a record of so many phase points.
    pub(crate) fn factor_range(self, phase_points: usize) -> (usize, usize) {
        let n = phase_points.saturating_sub(1);
        match self {
            Self::Allan | Self::OverlappingAllan => (1, n / 2),
            Self::Parabolic => (1, n.saturating_sub(1) / 2),
            Self::ModifiedAllan | Self::Time | Self::ModifiedTotal | Self::TimeTotal => {
                (1, (n + 1) / 3)
            }
            Self::Hadamard | Self::OverlappingHadamard | Self::HadamardTotal => (1, n / 3),
            // The extension has N − 2 points on either side.
            Self::Total => (1, n.saturating_sub(1)),
            Self::Theo1 => (10, n),
            Self::TheoHybrid => (1, 3 * n / 4),
        }
    }

    /// Phase points that factor m needs.
    pub(crate) fn points_needed(self, m: usize) -> usize {
        match self {
            Self::Allan | Self::OverlappingAllan => 2 * m + 1,
            Self::Parabolic => 2 * m + 2,
            Self::ModifiedAllan | Self::Time | Self::ModifiedTotal | Self::TimeTotal => 3 * m,
            Self::Hadamard | Self::OverlappingHadamard | Self::HadamardTotal => 3 * m + 1,
            Self::Total => m + 2,
            Self::Theo1 => m + 1,
            Self::TheoHybrid => 4 * m / 3 + 1,
        }
    }
}
