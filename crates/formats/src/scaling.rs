//! What a file declares to be done to the stored numbers of a channel.

/// Steps, of which each takes the numbers as stored or the result of a step before it; the last one gives the result.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Scaling {
    pub(crate) steps: Vec<Step>,
}

/// Where the numbers of a step come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum From {
    /// Stored, by the number of the source.
    Stored(usize),
    /// A step before.
    Step(usize),
}

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    Same(From),
    Linear {
        from: From,
        slope: f64,
        intercept: f64,
    },
    Polynomial {
        from: From,
        coefficients: Vec<f64>,
    },
    Table {
        from: From,
        /// Rising.
        stored: Vec<f64>,
        scaled: Vec<f64>,
    },
    Sum(From, From),
    /// The second less the first.
    Difference(From, From),
}

impl Scaling {
    /// Nothing is to be done.
    pub(crate) fn none() -> Self {
        Self::default()
    }

    /// A slope and an intercept.
    pub(crate) fn linear(slope: f64, intercept: f64) -> Self {
        Self {
            steps: vec![Step::Linear {
                from: From::Stored(0),
                slope,
                intercept,
            }],
        }
    }

    /// Words for the steps, joined.
    pub(crate) fn words(&self) -> Option<String> {
        let words = self.steps.iter().filter_map(|step| match step {
            Step::Same(_) => None,
            Step::Linear { .. } => Some("linear"),
            Step::Polynomial { .. } => Some("polynomial"),
            Step::Table { .. } => Some("table"),
            Step::Sum(..) => Some("sum"),
            Step::Difference(..) => Some("difference"),
        });
        let words: Vec<&str> = words.collect();
        (!words.is_empty()).then(|| words.join(" then "))
    }

    /// Whether every step takes what is there.
    pub(crate) fn holds(&self, sources: usize) -> bool {
        self.steps.iter().enumerate().all(|(i, step)| {
            let there = |from: &From| match from {
                From::Stored(s) => *s < sources,
                From::Step(s) => *s < i,
            };
            match step {
                Step::Sum(a, b) | Step::Difference(a, b) => there(a) && there(b),
                step => step.from().as_ref().is_some_and(there),
            }
        })
    }

    /// Whether each step takes what the one before gives, the first one the first numbers as stored.
    pub(crate) fn is_chain(&self) -> bool {
        self.steps.iter().enumerate().all(|(i, step)| {
            let before = match i.checked_sub(1) {
                None => From::Stored(0),
                Some(before) => From::Step(before),
            };
            step.from() == Some(before)
        })
    }

    /// The scaled numbers in place of the stored ones, by steps that are a chain.
    pub(crate) fn apply_chain(&self, numbers: &mut [f64]) {
        self.steps.iter().for_each(|step| step.apply(numbers));
    }

    /// The scaled numbers of the stored ones.
    pub(crate) fn apply(&self, mut stored: Vec<Vec<f64>>) -> Vec<f64> {
        let Some(last) = self.steps.len().checked_sub(1) else {
            return stored.drain(..).next().unwrap_or_default();
        };
        let mut done: Vec<Vec<f64>> = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let of = |from: From| match from {
                From::Stored(s) => stored.get(s),
                From::Step(s) => done.get(s),
            };
            let next = match step {
                Step::Sum(a, b) => pairs(of(*a), of(*b), |a, b| a + b),
                Step::Difference(a, b) => pairs(of(*a), of(*b), |a, b| b - a),
                step => {
                    let mut numbers = step.from().and_then(of).cloned().unwrap_or_default();
                    step.apply(&mut numbers);
                    numbers
                }
            };
            done.push(next);
        }
        done.swap_remove(last)
    }
}

impl Step {
    /// Where the numbers come from; nothing where they come from two places.
    fn from(&self) -> Option<From> {
        match self {
            Self::Same(from)
            | Self::Linear { from, .. }
            | Self::Polynomial { from, .. }
            | Self::Table { from, .. } => Some(*from),
            Self::Sum(..) | Self::Difference(..) => None,
        }
    }

    /// Puts what comes out in place of each number; a step that takes two is not asked.
    fn apply(&self, numbers: &mut [f64]) {
        match self {
            Self::Same(_) | Self::Sum(..) | Self::Difference(..) => {}
            Self::Linear {
                slope, intercept, ..
            } => {
                for v in numbers {
                    *v = *v * slope + intercept;
                }
            }
            Self::Polynomial { coefficients, .. } => {
                for v in numbers {
                    let terms = coefficients.iter().rev();
                    let sum = terms.copied().reduce(|sum, c| sum * *v + c);
                    *v = sum.unwrap_or(0.0);
                }
            }
            Self::Table { stored, scaled, .. } => {
                for v in numbers {
                    *v = between(stored, scaled, *v);
                }
            }
        }
    }
}

fn pairs(a: Option<&Vec<f64>>, b: Option<&Vec<f64>>, of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let pairs = a.into_iter().flatten().zip(b.into_iter().flatten());
    pairs.map(|(a, b)| of(*a, *b)).collect()
}

/// Straight lines between the rows of a table, constant beyond its ends.
fn between(x: &[f64], y: &[f64], v: f64) -> f64 {
    let above = x.partition_point(|x| *x <= v);
    let (Some(first), Some(last)) = (y.first(), y.last()) else {
        return v;
    };
    if above == 0 {
        return *first;
    }
    match (x.get(above), y.get(above)) {
        (Some(x1), Some(y1)) => {
            let (x0, y0) = (x[above - 1], y[above - 1]);
            (y1 - y0) / (x1 - x0) * (v - x0) + y0
        }
        _ => *last,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_steps_in_a_row() {
        let from = From::Stored(0);
        let scaling = Scaling {
            steps: vec![
                Step::Linear {
                    from,
                    slope: 2.0,
                    intercept: 1.0,
                },
                Step::Polynomial {
                    from: From::Step(0),
                    coefficients: vec![1.0, 0.0, 3.0],
                },
                Step::Table {
                    from: From::Step(1),
                    stored: vec![4.0, 28.0],
                    scaled: vec![0.0, 12.0],
                },
            ],
        };
        assert!(scaling.holds(1) && !scaling.holds(0));
        // 2·v + 1 = 1, 3, 5; 1 + 3·x² = 4, 28, 76; the table ends at 28.
        assert_eq!(scaling.apply(vec![vec![0.0, 1.0, 2.0]]), [0.0, 12.0, 12.0]);
        let mut numbers = [0.0, 1.0, 2.0];
        scaling.apply_chain(&mut numbers);
        assert!(scaling.is_chain());
        assert_eq!(numbers, [0.0, 12.0, 12.0]);
        assert_eq!(
            scaling.words().as_deref(),
            Some("linear then polynomial then table")
        );
        let two = Scaling {
            steps: vec![Step::Difference(From::Stored(0), From::Stored(1))],
        };
        assert!(!two.is_chain());
        assert_eq!(two.apply(vec![vec![1.0], vec![5.0]]), [4.0]);
    }
}
