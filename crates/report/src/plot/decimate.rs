//! Fewer points for the same picture: of each run of points within one pixel column the first, the lowest, the
//! highest and the last are kept.

/// A line in pixels with at most four points for every run of points in one pixel column.
///
/// What is drawn is the same to within half a pixel: every column keeps its extremes, and neighbouring columns
/// are joined where the data join them. Points are kept in their order; for a series that runs back and forth
/// within a few columns nothing is gained and nothing is lost.
pub(super) fn line(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    kept(points).into_iter().map(|(_, point)| point).collect()
}

/// Indices of the points that [`line`] keeps.
pub(super) fn indices(points: impl Iterator<Item = (f64, f64)>) -> Vec<usize> {
    kept(points).into_iter().map(|(index, _)| index).collect()
}

fn kept(points: impl Iterator<Item = (f64, f64)>) -> Vec<(usize, (f64, f64))> {
    let mut kept = Vec::new();
    let mut run = Run::default();
    for (index, point) in points.enumerate() {
        let column = point.0.floor();
        if run.count > 0 && column != run.column {
            run.flush(&mut kept);
        }
        run.push(column, (index, point));
    }
    run.flush(&mut kept);
    kept
}

#[derive(Default)]
struct Run {
    column: f64,
    count: usize,
    /// (index, point): first, lowest, highest, last.
    kept: [(usize, (f64, f64)); 4],
}

impl Run {
    fn push(&mut self, column: f64, entry: (usize, (f64, f64))) {
        let (_, point) = entry;
        if self.count == 0 {
            self.column = column;
            self.kept = [entry; 4];
        } else {
            if point.1 < self.kept[1].1.1 {
                self.kept[1] = entry;
            }
            if point.1 > self.kept[2].1.1 {
                self.kept[2] = entry;
            }
            self.kept[3] = entry;
        }
        self.count += 1;
    }

    fn flush(&mut self, out: &mut Vec<(usize, (f64, f64))>) {
        if self.count > 0 {
            self.kept.sort_by_key(|entry| entry.0);
            let mut previous = None;
            for entry in self.kept {
                if previous != Some(entry.0) {
                    out.push(entry);
                }
                previous = Some(entry.0);
            }
        }
        self.count = 0;
    }
}

/// Indices of markers, one for every cell of a pixel: a second marker on the same place would not be seen.
pub(super) fn markers(points: &[(f64, f64)]) -> Vec<usize> {
    let mut seen = std::collections::HashSet::new();
    (0..points.len())
        .filter(|&i| seen.insert((points[i].0.round() as i64, points[i].1.round() as i64)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_extremes_of_every_column_survive() {
        let points: Vec<(f64, f64)> = (0..100_000)
            .map(|i| {
                let t = i as f64 / 100_000.0;
                (
                    600.0 * t,
                    (1e4 * t).sin() * 50.0 + if i == 31_415 { 500.0 } else { 0.0 },
                )
            })
            .collect();
        let kept = line(points.iter().copied());
        assert!(kept.len() <= 4 * 601);
        let max = |p: &[(f64, f64)]| p.iter().map(|q| q.1).fold(f64::MIN, f64::max);
        let min = |p: &[(f64, f64)]| p.iter().map(|q| q.1).fold(f64::MAX, f64::min);
        for column in 0..600 {
            let within = |p: &[(f64, f64)]| -> Vec<(f64, f64)> {
                p.iter()
                    .copied()
                    .filter(|q| q.0.floor() == f64::from(column))
                    .collect()
            };
            assert_eq!(max(&within(&points)), max(&within(&kept)));
            assert_eq!(min(&within(&points)), min(&within(&kept)));
        }
        assert_eq!(line([(1.0, 2.0)].into_iter()), [(1.0, 2.0)]);
        assert!(line(std::iter::empty()).is_empty());
    }
}
