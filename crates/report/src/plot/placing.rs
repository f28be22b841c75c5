//! Where a label may stand: the ink of a drawing on a coarse grid, and the place that covers least of it.

/// Left, top, right, bottom in pixels.
pub(super) type Area = [f64; 4];

/// Side of a grid cell in pixels: finer than a letter, coarser than a line.
const CELL: f64 = 3.0;
/// Ink of a text, which nothing should cover.
pub(super) const TEXT: f32 = 20.0;
/// Ink of data.
pub(super) const DATA: f32 = 4.0;
/// Ink of lines that help reading.
pub(super) const AID: f32 = 1.0;

/// How much ink lies where.
pub(super) struct Ink {
    columns: usize,
    rows: usize,
    cells: Vec<f32>,
}

impl Ink {
    /// A white sheet.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let cells = |length: f64| (length / CELL).ceil().clamp(1.0, 4000.0) as usize;
        let (columns, rows) = (cells(width), cells(height));
        Self {
            columns,
            rows,
            cells: vec![0.0; columns * rows],
        }
    }

    /// Indices of the cells an area touches, within the sheet.
    fn touched(&self, area: &Area) -> impl Iterator<Item = usize> + use<> {
        let index = |v: f64, most: usize| (v / CELL).floor().clamp(0.0, (most - 1) as f64) as usize;
        let (left, right) = (index(area[0], self.columns), index(area[2], self.columns));
        let (top, bottom) = (index(area[1], self.rows), index(area[3], self.rows));
        let columns = self.columns;
        (top..=bottom).flat_map(move |row| (left..=right).map(move |c| row * columns + c))
    }

    /// Covers an area.
    pub(super) fn cover(&mut self, area: &Area, weight: f32) {
        for k in self.touched(area) {
            self.cells[k] = self.cells[k].max(weight);
        }
    }

    /// Covers a line through points.
    pub(super) fn line(&mut self, points: &[(f64, f64)], weight: f32) {
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let length = (b.0 - a.0).abs().max((b.1 - a.1).abs());
            // Lines reach far outside the sheet at most by ten times its size.
            let steps = (length / CELL).ceil().clamp(1.0, 20_000.0) as usize;
            for i in 0..=steps {
                let t = i as f64 / steps as f64;
                self.dot((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)), weight);
            }
        }
    }

    fn dot(&mut self, (x, y): (f64, f64), weight: f32) {
        let inside =
            x >= 0.0 && y >= 0.0 && x < CELL * self.columns as f64 && y < CELL * self.rows as f64;
        if inside {
            self.cover(&[x, y, x, y], weight);
        }
    }

    fn under(&self, area: &Area) -> f64 {
        self.touched(area).map(|k| f64::from(self.cells[k])).sum()
    }

    /// Takes the area with the least ink under it and a little of that around it, plus a handicap of its own;
    /// the first of equals. Its number, and the sheet is covered there; `None` without candidates.
    pub(super) fn place(&mut self, candidates: &[(Area, f64)]) -> Option<usize> {
        let cost = |(area, handicap): &(Area, f64)| {
            let [a, b, c, d] = *area;
            let around = [a - 9.0, b - 9.0, c + 9.0, d + 9.0];
            self.under(area) + 0.1 * self.under(&around) + handicap
        };
        let costs: Vec<f64> = candidates.iter().map(cost).collect();
        let best = (0..costs.len()).min_by(|&i, &j| costs[i].total_cmp(&costs[j]))?;
        self.cover(&candidates[best].0, TEXT);
        Some(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_label_avoids_ink_and_then_the_label_before_it() {
        let mut ink = Ink::new(100.0, 100.0);
        ink.line(&[(0.0, 20.0), (100.0, 20.0)], DATA);
        let at = |y: f64| ([10.0, y, 60.0, y + 9.0], 0.0);
        let places = [at(16.0), at(50.0), at(80.0)];
        assert_eq!(ink.place(&places), Some(1));
        assert_eq!(ink.place(&places), Some(2));
        assert_eq!(ink.place(&[]), None);
    }
}
