//! Position from raw encoder signals over a whole recording.

use crate::findings;
use proofmass_core::Error;
use proofmass_core::encoder::{Decoding, Quadrature, Unwrap, gray_to_binary};
use proofmass_uncertainty::Finding;

/// A decoded recording.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Decoded {
    /// Count at every sample or edge, continued over rollovers.
    pub count: Vec<i64>,
    /// Samples at which the index came, with the count there.
    pub index: Vec<(usize, i64)>,
    /// Samples of illegal transitions.
    pub illegal: Vec<usize>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

/// One change of a channel with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedEdge {
    /// Time, s.
    pub time: f64,
    /// Level of A after it.
    pub a: bool,
    /// Level of B after it.
    pub b: bool,
    /// Level of the index after it.
    pub index: bool,
}

/// Quadrature from samples of the logic levels.
///
/// # Errors
/// [`Error::Length`] for channels of unequal length, [`Error::TooFew`] for empty ones.
pub fn quadrature(
    decoding: Decoding,
    a: &[bool],
    b: &[bool],
    index: Option<&[bool]>,
) -> Result<Decoded, Error> {
    for (name, channel) in [("channel B", Some(b)), ("index", index)] {
        if let Some(channel) = channel
            && channel.len() != a.len()
        {
            return Err(Error::Length {
                name,
                expected: a.len(),
                got: channel.len(),
            });
        }
    }
    let levels = (0..a.len()).map(|k| (a[k], b[k], index.is_some_and(|z| z[k])));
    run(decoding, levels)
}

/// Quadrature from time-stamped edges: the count after every edge.
///
/// # Errors
/// [`Error::NotIncreasing`] with the index of the first edge that is earlier than the one before (equal times
/// are refused too: their order is unknown), [`Error::NotFinite`], [`Error::TooFew`].
pub fn quadrature_edges(decoding: Decoding, edges: &[TimedEdge]) -> Result<Decoded, Error> {
    if let Some(index) = edges.iter().position(|e| !e.time.is_finite()) {
        return Err(Error::NotFinite {
            name: "edge time",
            index,
        });
    }
    if let Some(k) = edges.windows(2).position(|w| w[1].time <= w[0].time) {
        return Err(Error::NotIncreasing {
            name: "edge time",
            index: k + 1,
        });
    }
    run(decoding, edges.iter().map(|e| (e.a, e.b, e.index)))
}

fn run(
    decoding: Decoding,
    mut levels: impl Iterator<Item = (bool, bool, bool)>,
) -> Result<Decoded, Error> {
    let Some((a, b, z)) = levels.next() else {
        return Err(Error::TooFew {
            name: "logic samples",
            needed: 1,
            got: 0,
        });
    };
    let mut decoder = Quadrature::new(decoding, a, b);
    decoder.update(a, b, z);
    let mut index: Vec<(usize, i64)> = decoder
        .indexed()
        .map(|c| (0, i64::from(c)))
        .into_iter()
        .collect();
    let mut wide = Unwrap::new(32, 0);
    let (mut count, mut illegal, mut high) = (vec![0], Vec::new(), z);
    for (k, (a, b, z)) in levels.enumerate() {
        let k = k + 1;
        if decoder.update(a, b, z).is_none() {
            illegal.push(k);
        }
        // The decoder counts modulo 2³²; the first word is 0 by construction.
        let total = wide.update(decoder.count() as u32);
        count.push(total);
        if z && !high {
            index.push((k, total));
        }
        high = z;
    }
    let mut findings = Vec::new();
    if !illegal.is_empty() {
        findings.push(findings::illegal_transitions(
            illegal.len(),
            count.len(),
            illegal[0],
        ));
    }
    if let Some(finding) = index_consistency(&index) {
        findings.push(finding);
    }
    Ok(Decoded {
        count,
        index,
        illegal,
        findings,
    })
}

/// Counts between index pulses in the same sense must repeat; lost counts show here.
fn index_consistency(index: &[(usize, i64)]) -> Option<Finding> {
    let turns: Vec<i64> = index
        .windows(2)
        .map(|w| (w[1].1 - w[0].1).abs())
        .filter(|&n| n > 1)
        .collect();
    let (least, most) = (turns.iter().min()?, turns.iter().max()?);
    (least != most).then(|| findings::unequal_turns(*least, *most))
}

/// Rising edges of a level up to each sample; a pass counts after the level was below a third of its range.
pub fn teeth(level: &[f64]) -> Vec<i64> {
    let high = level.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = level.iter().copied().fold(f64::INFINITY, f64::min);
    let at = |share: f64| low + share * (high - low);
    let (mut count, mut armed) = (0, false);
    level
        .iter()
        .map(|v| {
            if *v <= at(1.0 / 3.0) {
                armed = true;
            } else if armed && *v > at(2.0 / 3.0) {
                armed = false;
                count += 1;
            }
            count
        })
        .collect()
}

/// Levels in volts, cut half way between the lowest and the highest.
pub fn levels(volts: &[f64]) -> Vec<bool> {
    let high = volts.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = volts.iter().copied().fold(f64::INFINITY, f64::min);
    volts.iter().map(|v| *v > 0.5 * (low + high)).collect()
}

/// Counts as words of a counter of 1 to 32 bits, with a sign or without.
///
/// # Errors
/// The index of a count that does not fit.
pub fn counter_words(counts: &[i64], bits: u32) -> Result<Vec<u32>, usize> {
    let range = 1i64 << bits;
    let word = |(k, c): (usize, &i64)| {
        let fits = *c >= -(range / 2) && *c < range;
        fits.then(|| c.rem_euclid(range) as u32).ok_or(k)
    };
    counts.iter().enumerate().map(word).collect()
}

/// Code of an absolute encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AbsoluteCode {
    /// Plain binary.
    Binary,
    /// Gray code.
    Gray,
}

/// Words of an absolute encoder (or of a counter that rolls over) of 1 to 32 bits as a continuous count.
///
/// # Errors
/// [`Error::OutOfRange`] for a number of bits outside 1…32 or a word that does not fit, [`Error::TooFew`] for
/// none.
pub fn absolute(code: AbsoluteCode, bits: u32, words: &[u32]) -> Result<Decoded, Error> {
    if !(1..=32).contains(&bits) {
        return Err(Error::OutOfRange {
            name: "bits",
            value: f64::from(bits),
            min: 1.0,
            max: 32.0,
        });
    }
    let limit = (1u64 << bits) - 1;
    if let Some(word) = words.iter().find(|&&w| u64::from(w) > limit) {
        return Err(Error::OutOfRange {
            name: "word",
            value: f64::from(*word),
            min: 0.0,
            max: limit as f64,
        });
    }
    let binary = |w: u32| match code {
        AbsoluteCode::Binary => w,
        AbsoluteCode::Gray => gray_to_binary(w),
    };
    let Some(&first) = words.first() else {
        return Err(Error::TooFew {
            name: "words",
            needed: 1,
            got: 0,
        });
    };
    let mut counter = Unwrap::new(bits, binary(first));
    let count: Vec<i64> = words.iter().map(|&w| counter.update(binary(w))).collect();
    let largest = count
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .max()
        .unwrap_or(0);
    let mut findings = Vec::new();
    if largest as f64 > 0.25 * limit as f64 {
        findings.push(findings::large_step(largest, limit + 1));
    }
    Ok(Decoded {
        count,
        index: Vec::new(),
        illegal: Vec::new(),
        findings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass_core::encoder::binary_to_gray;

    /// Levels of A and B at a position in quarters.
    fn levels(quarter: i64) -> (bool, bool) {
        [(false, false), (true, false), (true, true), (false, true)][quarter.rem_euclid(4) as usize]
    }

    #[test]
    fn law_samples_and_edges_give_the_same_position() {
        let path: Vec<i64> = (0..4000)
            .map(|k| (60.0 * (0.01 * f64::from(k)).sin()).round() as i64)
            .collect();
        let (a, b): (Vec<bool>, Vec<bool>) = path.iter().map(|&q| levels(q)).unzip();
        let z: Vec<bool> = path.iter().map(|&q| q == 20).collect();
        let decoded = quadrature(Decoding::Quadruple, &a, &b, Some(&z)).unwrap();
        assert_eq!(decoded.count, path);
        assert!(decoded.illegal.is_empty());
        assert!(decoded.index.iter().all(|&(_, c)| c == 20));
        let edges: Vec<TimedEdge> = (0..path.len())
            .filter(|&k| k == 0 || path[k] != path[k - 1])
            .map(|k| TimedEdge {
                time: k as f64,
                a: a[k],
                b: b[k],
                index: z[k],
            })
            .collect();
        let decoded = quadrature_edges(Decoding::Quadruple, &edges).unwrap();
        for (count, edge) in decoded.count.iter().zip(&edges) {
            assert_eq!(*count, path[edge.time as usize]);
        }
        let mut wrong = edges.clone();
        wrong[5].time = wrong[3].time;
        let error = quadrature_edges(Decoding::Quadruple, &wrong);
        assert!(matches!(error, Err(Error::NotIncreasing { index: 5, .. })));
    }

    #[test]
    fn law_double_and_single_decoding_follow_within_their_step() {
        let path: Vec<i64> = (0..4000)
            .map(|k| (60.0 * (0.01 * f64::from(k)).sin()).round() as i64)
            .collect();
        let (a, b): (Vec<bool>, Vec<bool>) = path.iter().map(|&q| levels(q)).unzip();
        for (decoding, quarters) in [(Decoding::Double, 2), (Decoding::Single, 4)] {
            let decoded = quadrature(decoding, &a, &b, None).unwrap();
            for (count, place) in decoded.count.iter().zip(&path) {
                assert!((count * quarters - place).abs() < quarters);
            }
        }
    }

    #[test]
    fn law_too_fast_an_axis_is_said() {
        let path: Vec<i64> = (0..100).map(|k| if k < 50 { k } else { k + 2 }).collect();
        let (a, b): (Vec<bool>, Vec<bool>) = path.iter().map(|&q| levels(q)).unzip();
        // From 49 to 52 is a jump of three, seen as one back; a jump of two is illegal.
        let decoded = quadrature(Decoding::Quadruple, &a, &b, None).unwrap();
        assert_eq!(decoded.illegal.len(), 0);
        let path: Vec<i64> = (0..100).map(|k| if k < 50 { k } else { k + 1 }).collect();
        let (a, b): (Vec<bool>, Vec<bool>) = path.iter().map(|&q| levels(q)).unzip();
        let decoded = quadrature(Decoding::Quadruple, &a, &b, None).unwrap();
        assert_eq!(decoded.illegal, [50]);
        assert_eq!(decoded.findings[0].code(), "illegal-transitions");
    }

    #[test]
    fn law_absolute_words_of_16_and_32_bits_roll_over() {
        for bits in [16u32, 32] {
            let mask = ((1u64 << bits) - 1) as u32;
            let truth: Vec<i64> = (0..2000).map(|k| i64::from(mask) - 500 + k).collect();
            for code in [AbsoluteCode::Binary, AbsoluteCode::Gray] {
                let words: Vec<u32> = truth
                    .iter()
                    .map(|&c| (c as u32) & mask)
                    .map(|w| {
                        if code == AbsoluteCode::Gray {
                            binary_to_gray(w)
                        } else {
                            w
                        }
                    })
                    .collect();
                assert_eq!(absolute(code, bits, &words).unwrap().count, truth);
            }
        }
        assert!(absolute(AbsoluteCode::Binary, 8, &[256]).is_err());
        assert!(absolute(AbsoluteCode::Binary, 33, &[1]).is_err());
    }
}
