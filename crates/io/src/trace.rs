//! The course of a signal in as few points as a picture shows, its extremes kept.

/// Groups of rows that a course is kept in.
const MOST: usize = 1 << 11;

/// The course of one column: time against value, smallest and largest of each group of rows.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Trace {
    /// Number of the column, from one.
    pub number: usize,
    /// Seconds from the first time stamp on; rows where there is no clock.
    pub x: Vec<f64>,
    /// Values in the unit of the column.
    pub y: Vec<f64>,
}

/// Rows that are drawn as one.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Place of the first row.
    x: f64,
    /// The extreme that came first, and the other.
    ends: [f64; 2],
}

impl Group {
    fn joined(self, next: Self) -> Self {
        let mut joined = self;
        next.ends.into_iter().for_each(|value| joined.add(value));
        joined
    }

    fn add(&mut self, value: f64) {
        let [first, second] = self.ends;
        let (low, high) = (first.min(second), first.max(second));
        // A new extreme takes the place of the old one of its kind, and is then the later one.
        if value > high {
            self.ends = [low, value];
        } else if value < low {
            self.ends = [high, value];
        }
    }
}

/// Takes the values of a column one by one.
#[derive(Debug)]
pub(crate) struct Tracer {
    groups: Vec<Group>,
    /// Rows of a full group, and of the last one.
    rows: u64,
    last: u64,
}

impl Tracer {
    pub(crate) fn new() -> Self {
        Self {
            groups: Vec::new(),
            rows: 1,
            last: 1,
        }
    }

    pub(crate) fn add(&mut self, x: f64, value: f64) {
        if !value.is_finite() || !x.is_finite() {
            return;
        }
        if self.last < self.rows
            && let Some(group) = self.groups.last_mut()
        {
            group.add(value);
            self.last += 1;
            return;
        }
        if self.groups.len() == MOST {
            let pairs = self.groups.as_chunks::<2>().0;
            self.groups = pairs.iter().map(|[a, b]| a.joined(*b)).collect();
            self.rows *= 2;
        }
        let ends = [value; 2];
        self.groups.push(Group { x, ends });
        self.last = 1;
    }

    pub(crate) fn trace(self, number: usize) -> Trace {
        let mut trace = Trace {
            number,
            ..Trace::default()
        };
        for Group { x, ends: [a, b] } in self.groups {
            let ends = [a, b];
            for value in &ends[..if a == b { 1 } else { 2 }] {
                trace.x.push(x);
                trace.y.push(*value);
            }
        }
        trace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_extremes_stay_and_points_are_few() {
        for count in [1_usize, 3, MOST, MOST + 1, 100_003] {
            let mut tracer = Tracer::new();
            let value = |i: usize| match i {
                _ if i == count / 2 => 9.0,
                _ if i == count / 3 => -7.0,
                _ => (i as f64 * 0.1).sin(),
            };
            for i in 0..count {
                tracer.add(i as f64, value(i));
            }
            let trace = tracer.trace(1);
            assert!(trace.y.len() <= 2 * MOST && trace.x.is_sorted());
            let extreme = |f: fn(f64, f64) -> f64| {
                let all = (0..count).map(value).fold(value(0), f);
                (all, trace.y.iter().copied().fold(value(0), f))
            };
            let ((a, b), (c, d)) = (extreme(f64::max), extreme(f64::min));
            assert_eq!((a, c), (b, d));
            if count <= MOST {
                assert_eq!(trace.y, (0..count).map(value).collect::<Vec<_>>());
            }
        }
    }
}
