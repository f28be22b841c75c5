//! A record of any length as averages, in bounded memory.

/// Averages of 2^k neighbouring samples, k as small as the room allows.
///
/// The average of m samples is a difference of the phase over m τ0: the averaged record has the same noise coefficients
/// (the phase seen at every m-th point), without what lies above its own Nyquist frequency. NaN marks a gap.
#[derive(Clone, Debug)]
pub(crate) struct Averages {
    capacity: usize,
    factor: usize,
    values: Vec<f64>,
    sum: f64,
    summed: usize,
}

impl Averages {
    /// An empty record with room for so many averages; an even number.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            capacity: capacity.max(2).next_multiple_of(2),
            factor: 1,
            values: Vec::new(),
            sum: 0.0,
            summed: 0,
        }
    }

    /// Samples in one average.
    pub(crate) fn factor(&self) -> usize {
        self.factor
    }

    /// The averages so far, without the one that is not complete.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    pub(crate) fn push(&mut self, samples: &[f64]) {
        for &v in samples {
            self.sum += v;
            self.summed += 1;
            if self.summed == self.factor {
                let average = self.sum / self.factor as f64;
                self.append(average);
            }
        }
    }

    /// Samples are missing here: an average that was begun is given up.
    pub(crate) fn gap(&mut self) {
        if self.values.last().is_some_and(|v| v.is_finite()) || self.summed > 0 {
            self.append(f64::NAN);
        }
    }

    fn append(&mut self, value: f64) {
        self.values.push(value);
        (self.sum, self.summed) = (0.0, 0);
        if self.values.len() == self.capacity {
            let half = self.capacity / 2;
            for k in 0..half {
                self.values[k] = 0.5 * (self.values[2 * k] + self.values[2 * k + 1]);
            }
            self.values.truncate(half);
            self.factor *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_averages_are_those_of_the_record() {
        let record: Vec<f64> = (0..960).map(|k| f64::from(k * k % 37)).collect();
        let mut averages = Averages::new(64);
        for piece in record.chunks(7) {
            averages.push(piece);
        }
        assert_eq!(averages.factor(), 16);
        assert_eq!(averages.values().len(), 60);
        for (k, value) in averages.values().iter().enumerate() {
            let mean = record[16 * k..16 * (k + 1)].iter().sum::<f64>() / 16.0;
            assert!((value - mean).abs() < 1e-12);
        }
        averages.gap();
        averages.gap();
        averages.push(&[1.0; 16]);
        let tail = &averages.values()[60..];
        assert!(tail[0].is_nan() && tail[1..] == [1.0]);
    }
}
