//! Choices of an analysis as words: `oadev`, `10/decade`, `N`, `stable32`.

use crate::{Bias, EdfFormula, NoiseType, Statistic, Taus, Term};
use std::str::FromStr;

impl FromStr for Statistic {
    type Err = String;

    /// By its abbreviation, in either case.
    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL
            .into_iter()
            .find(|s| s.abbreviation().eq_ignore_ascii_case(text));
        found.ok_or_else(|| format!("{text:?} is no known statistic"))
    }
}

impl FromStr for Term {
    type Err = String;

    /// By its letter, in either case.
    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL
            .into_iter()
            .find(|t| t.symbol().eq_ignore_ascii_case(text.trim()));
        found.ok_or_else(|| format!("{text:?} is not one of the terms Q, N, B, K, R, G, A"))
    }
}

impl FromStr for Bias {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "by-noise-type" => Ok(Self::ByNoiseType),
            "from-record" => Ok(Self::FromRecord),
            "as-defined" => Ok(Self::AsDefined),
            _ => Err(format!(
                "{text:?} is no correction (by-noise-type, from-record, as-defined)"
            )),
        }
    }
}

impl FromStr for EdfFormula {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "published" => Ok(Self::Published),
            "stable32" => Ok(Self::Stable32),
            _ => Err(format!("{text:?} is neither published nor stable32")),
        }
    }
}

impl FromStr for NoiseType {
    type Err = String;

    /// By its exponent α.
    fn from_str(text: &str) -> Result<Self, String> {
        let alpha = text.parse().ok();
        let found = alpha.and_then(Self::from_alpha);
        found.ok_or_else(|| format!("{text:?} is no exponent from -4 to 2"))
    }
}

impl FromStr for Taus {
    type Err = String;

    /// `octave`, `decade`, `all`, a number per decade (`10/decade`), or times in seconds (`0.1,1,10`).
    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || format!("{text:?} is not one of octave, decade, all, 10/decade, 0.1,1,10");
        match text {
            "octave" => return Ok(Self::Octave),
            "decade" => return Ok(Self::Decade),
            "all" => return Ok(Self::All),
            _ => {}
        }
        if let Some(count) = text.strip_suffix("/decade") {
            return match count.trim().parse() {
                Ok(count @ 1..=1000) => Ok(Self::PerDecade(count)),
                _ => Err(refused()),
            };
        }
        let seconds = text.split(',').map(|t| t.trim().parse::<f64>());
        let seconds = seconds.collect::<Result<Vec<_>, _>>();
        seconds.map(Self::Chosen).map_err(|_| refused())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_words_name_what_they_say() {
        for statistic in Statistic::ALL {
            assert_eq!(statistic.abbreviation().parse(), Ok(statistic));
        }
        for term in Term::ALL {
            assert_eq!(term.symbol().to_lowercase().parse(), Ok(term));
        }
        assert_eq!("-2".parse(), Ok(NoiseType::RandomWalk));
        assert_eq!("10/decade".parse(), Ok(Taus::PerDecade(10)));
        assert_eq!("0.1, 1".parse(), Ok(Taus::Chosen(vec![0.1, 1.0])));
        assert_eq!("stable32".parse(), Ok(EdfFormula::Stable32));
    }

    #[test]
    fn refuses_other_words() {
        assert!("xdev".parse::<Statistic>().is_err());
        assert!("Z".parse::<Term>().is_err());
        assert!("0/decade".parse::<Taus>().is_err());
        assert!("1,,2".parse::<Taus>().is_err());
        assert!("3".parse::<NoiseType>().is_err());
        assert!("none".parse::<Bias>().is_err());
        assert!("sp1065".parse::<EdfFormula>().is_err());
    }
}
