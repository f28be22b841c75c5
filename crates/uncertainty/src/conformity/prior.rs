//! The distribution of a production, taken apart into cells.

use super::Limits;
use super::measured::normal_tail;
use crate::Distribution;
use proofmass_core::Error;

/// Cells of a production, none of which a limit divides.
pub(super) struct Cells(Vec<Cell>);

/// A stretch of values and how many of the items it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub from: f64,
    pub middle: f64,
    pub to: f64,
    pub mass: f64,
    /// Of the three in Simpson's rule.
    weights: [f64; 3],
}

impl Cell {
    /// What a function of the items comes to over the cell.
    pub fn integral(&self, f: impl Fn(f64) -> f64) -> f64 {
        let values = [self.from, self.middle, self.to].map(f);
        values.iter().zip(self.weights).map(|(v, w)| v * w).sum()
    }
}

/// Cells are equally wide for the normal deviate z of their items, up to this one: 3·10⁻¹² of all lie beyond.
const END: f64 = 7.0;
const CELLS: usize = 14_000;

impl Cells {
    /// # Errors
    /// [`Error::OutOfRange`] for a distribution that is not continuous.
    pub fn of(production: &Distribution, limits: &Limits) -> Result<Self, Error> {
        production.check()?;
        let continuous = !matches!(
            production,
            Distribution::Discrete { .. }
                | Distribution::Poisson { .. }
                | Distribution::Samples { .. }
        );
        let value = |z: f64| match production {
            Distribution::Normal { mean, u } => mean + u * z,
            other => other.quantile(normal_tail(-z)),
        };
        let (low, high) = (value(-END), value(END));
        if !(continuous && low < high && (high - low).is_finite()) {
            return Err(Error::OutOfRange {
                name: "spread of the production, which needs a continuous distribution,",
                value: if continuous { high - low } else { 0.0 },
                min: f64::MIN_POSITIVE,
                max: f64::MAX,
            });
        }
        let mut edges: Vec<f64> = (0..=CELLS)
            .map(|k| END * (2.0 * k as f64 / CELLS as f64 - 1.0))
            .collect();
        for limit in [limits.lower, limits.upper].into_iter().flatten() {
            if limit > low && limit < high {
                edges.push(deviate(value, limit));
            }
        }
        edges.sort_by(f64::total_cmp);
        let values: Vec<f64> = edges.iter().map(|z| value(*z)).collect();
        let density = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
        let cells = edges.windows(2).zip(values.windows(2));
        let cells = cells.map(|(z, x)| {
            let (middle, sixth) = (0.5 * (z[0] + z[1]), (z[1] - z[0]) / 6.0);
            Cell {
                from: x[0],
                middle: value(middle),
                to: x[1],
                mass: share(z[0], z[1]),
                weights: [density(z[0]), 4.0 * density(middle), density(z[1])].map(|d| d * sixth),
            }
        });
        Ok(Self(cells.filter(|c| c.to > c.from).collect()))
    }

    pub fn iter(&self) -> impl Iterator<Item = Cell> + '_ {
        self.0.iter().copied()
    }
}

/// Share of a normal distribution between two deviates.
fn share(from: f64, to: f64) -> f64 {
    if from > 0.0 {
        normal_tail(from) - normal_tail(to)
    } else {
        normal_tail(-to) - normal_tail(-from)
    }
}

/// The deviate of a value, by bisection.
fn deviate(value: impl Fn(f64) -> f64, wanted: f64) -> f64 {
    let (mut low, mut high) = (-END, END);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
