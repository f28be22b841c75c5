//! Outputs of any length in bounded memory: neighbours averaged in pairs, as often as it takes.

/// Means of as many neighbouring rows as keep the number of means within a bound.
#[derive(Clone, Debug)]
pub(super) struct Averages {
    most: usize,
    /// Rows of one mean.
    per: usize,
    outputs: [Vec<f64>; 3],
    /// Means before which time pauses.
    breaks: Vec<usize>,
    sum: [f64; 3],
    pending: usize,
}

impl Averages {
    /// At most so many means, an even number.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            per: 1,
            outputs: [Vec::new(), Vec::new(), Vec::new()],
            breaks: Vec::new(),
            sum: [0.0; 3],
            pending: 0,
        }
    }

    pub fn push(&mut self, row: [f64; 3]) {
        for (sum, value) in self.sum.iter_mut().zip(row) {
            *sum += value;
        }
        self.pending += 1;
        if self.pending < self.per {
            return;
        }
        for (output, sum) in self.outputs.iter_mut().zip(&mut self.sum) {
            output.push(*sum / self.per as f64);
            *sum = 0.0;
        }
        self.pending = 0;
        if self.outputs[0].len() >= self.most {
            self.fold();
        }
    }

    /// Rows of one mean.
    pub fn rows_of_one(&self) -> usize {
        self.per
    }

    /// Time pauses before the next row: no mean reaches across, and the rows of one that is not full are left out.
    pub fn pause(&mut self) {
        self.sum = [0.0; 3];
        self.pending = 0;
        let here = self.outputs[0].len();
        if here > 0 && self.breaks.last() != Some(&here) {
            self.breaks.push(here);
        }
    }

    /// Averages pairs. The last one of an odd stretch is left out; that of the stretch that goes on is half of the next mean.
    fn fold(&mut self) {
        let start = self.breaks.last().copied().unwrap_or(0);
        if (self.outputs[0].len() - start) % 2 == 1 {
            for (output, sum) in self.outputs.iter_mut().zip(&mut self.sum) {
                *sum = output.pop().unwrap_or(0.0) * self.per as f64;
            }
            self.pending = self.per;
        }
        let n = self.outputs[0].len();
        let mut stretches = Vec::with_capacity(self.breaks.len() + 1);
        let mut start = 0;
        for end in self.breaks.iter().copied().chain([n]) {
            stretches.push((start, (end - start) / 2));
            start = end;
        }
        for output in &mut self.outputs {
            let mut to = 0;
            for &(start, pairs) in &stretches {
                for k in 0..pairs {
                    output[to] = 0.5 * (output[start + 2 * k] + output[start + 2 * k + 1]);
                    to += 1;
                }
            }
            output.truncate(to);
        }
        self.breaks.clear();
        let mut at = 0;
        for (_, pairs) in stretches {
            if at > 0 && self.breaks.last() != Some(&at) {
                self.breaks.push(at);
            }
            at += pairs;
        }
        self.breaks.retain(|b| *b < at);
        self.per *= 2;
    }

    /// The means, the places of the pauses, and the rows of one mean.
    pub fn finish(mut self) -> ([Vec<f64>; 3], Vec<usize>, usize) {
        let n = self.outputs[0].len();
        self.breaks.retain(|b| *b < n);
        (self.outputs, self.breaks, self.per)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_means_are_those_of_their_rows_and_never_cross_a_pause() {
        let mut averages = Averages::new(16);
        // Two stretches of 45 and 100 rows: 0, 1, 2, … and 1000, 1001, ….
        for k in 0..45 {
            averages.push([f64::from(k), 0.0, 1.0]);
        }
        averages.pause();
        for k in 0..100 {
            averages.push([1000.0 + f64::from(k), 0.0, 1.0]);
        }
        let ([x, y, z], breaks, per) = averages.finish();
        assert!(x.len() <= 16 && y.iter().all(|v| *v == 0.0) && z.iter().all(|v| *v == 1.0));
        assert_eq!(breaks.len(), 1);
        let middle = 0.5 * (per as f64 - 1.0);
        for (k, mean) in x[..breaks[0]].iter().enumerate() {
            assert_eq!(*mean, (k * per) as f64 + middle);
        }
        for (k, mean) in x[breaks[0]..].iter().enumerate() {
            assert_eq!(*mean, 1000.0 + (k * per) as f64 + middle);
        }
    }

    #[test]
    fn known_short_recordings_are_kept_row_by_row() {
        let mut averages = Averages::new(16);
        (0..15).for_each(|k| averages.push([f64::from(k); 3]));
        let (outputs, breaks, per) = averages.finish();
        assert_eq!((outputs[2].len(), breaks.len(), per), (15, 0, 1));
    }
}
