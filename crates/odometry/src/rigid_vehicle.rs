//! The rigid vehicle that several wheels show together, and what each wheel has beyond it.

use proofmass_core::Matrix3;
use proofmass_core::numeric::upper_median;
use proofmass_motion::episode::quiet;

/// Share of the squares that one wheel may leave unexplained.
const UNEXPLAINED: f64 = 0.1;

/// Largest coefficients that a vehicle has: radius, track, and square of wheelbase over track of a steered axle, of which the
/// mean takes half. Without curves creep of the tyres would pass for larger ones.
const MOST: [f64; 3] = [1.0, 0.15, 6.0];

/// Mean speed and half the difference of the sides, at a window.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    ahead: f64,
    turning: f64,
}

/// Sides on which so many wheels may stand: −1, 1 and 0 for the middle.
pub(crate) fn sides(count: usize) -> Vec<Vec<f64>> {
    match count {
        3 => vec![
            vec![0.0, -1.0, 1.0],
            vec![-1.0, 0.0, 1.0],
            vec![-1.0, 1.0, 0.0],
        ],
        4 => vec![
            vec![-1.0, 1.0, -1.0, 1.0],
            vec![-1.0, -1.0, 1.0, 1.0],
            vec![-1.0, 1.0, 1.0, -1.0],
        ],
        _ => {
            let alternate = |i: usize| match i {
                i if i + 1 == count && count % 2 == 1 => 0.0,
                i if i % 2 == 0 => -1.0,
                _ => 1.0,
            };
            vec![(0..count).map(alternate).collect()]
        }
    }
}

/// The rigid vehicle that all wheels show together, and what each has beyond it.
pub(crate) struct Rigid {
    sides: Vec<f64>,
    body: Vec<Body>,
    /// Of each wheel, per window.
    pub(crate) beyond: Vec<Vec<f64>>,
    /// Sum of the medians of what is left.
    pub(crate) typical: f64,
}

impl Rigid {
    pub(crate) fn new(speeds: &[Vec<f64>], sides: &[f64], moves: &[bool], w: usize) -> Self {
        let all = vec![true; sides.len()];
        let body: Vec<Body> = (0..moves.len())
            .map(|k| fitted(sides, &all, |i| speeds[i][k]).unwrap_or_default())
            .collect();
        let columns: Vec<[f64; 3]> = body
            .iter()
            .map(|b| {
                let quotient = b.turning * b.turning / b.ahead;
                let steered = if quotient.is_finite() { quotient } else { 0.0 };
                [b.ahead, b.turning, steered]
            })
            .collect();
        // Windows that hardly overlap are enough for three coefficients.
        let used: Vec<usize> = (0..moves.len())
            .step_by((w / 4).max(1))
            .filter(|k| moves[*k])
            .collect();
        let used = determining(speeds, sides, &body, used);
        let mut typical = 0.0;
        let beyond = speeds
            .iter()
            .zip(sides)
            .map(|(speed, side)| {
                let raw = |k: usize| speed[k] - body[k].ahead - side * body[k].turning;
                let coefficients = robust(&used, &columns, raw);
                let rest = |k: usize| raw(k) - proofmass_core::dot(coefficients, columns[k]);
                let mut sizes: Vec<f64> = used.iter().map(|k| rest(*k).abs()).collect();
                typical += upper_median(&mut sizes).unwrap_or(0.0);
                (0..moves.len()).map(rest).collect()
            })
            .collect();
        Self {
            sides: sides.to_vec(),
            body,
            beyond,
            typical,
        }
    }

    /// The wheels that explain the change from window `k` to window `k + w`, and the first one's part in it.
    pub(crate) fn to_blame(
        &self,
        changes: &[Change],
        moves: &[bool],
        k: usize,
        w: usize,
    ) -> (Vec<usize>, f64) {
        let count = self.sides.len();
        let (before, after) = (self.body[k], self.body[k + w]);
        let body = Body {
            ahead: after.ahead - before.ahead,
            turning: after.turning - before.turning,
        };
        let change: Vec<f64> = (0..count)
            .map(|i| body.ahead + self.sides[i] * body.turning + changes[i].size(k))
            .collect();
        // A vehicle goes on as it did before the change began.
        let trend = match k.checked_sub(2 * w).filter(|j| moves[*j] && moves[*j + w]) {
            Some(j) => Body {
                ahead: self.body[j + w].ahead - self.body[j].ahead,
                turning: self.body[j + w].turning - self.body[j].turning,
            },
            None => Body::default(),
        };
        let total: f64 = (0..count).map(|i| changes[i].size(k).powi(2)).sum();
        // Departure from the trend, squares that are left, wheels and the first one's part.
        let explain = |wheels: Vec<usize>| {
            let keep: Vec<bool> = (0..count).map(|i| !wheels.contains(&i)).collect();
            let own = fitted(&self.sides, &keep, |i| change[i])?;
            let off = |i: usize| change[i] - own.ahead - self.sides[i] * own.turning;
            let left: f64 = (0..count)
                .filter(|i| keep[*i])
                .map(|i| off(i) * off(i))
                .sum();
            let away = (own.ahead - trend.ahead).hypot(own.turning - trend.turning);
            let part = off(wheels[0]);
            Some((away, left, wheels, part))
        };
        let least = |list: Vec<(f64, f64, Vec<usize>, f64)>| {
            list.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let single: Vec<_> = (0..count)
            .filter_map(|i| explain(vec![i]))
            .filter(|e| e.1 <= UNEXPLAINED * total)
            .collect();
        let pairs = || {
            let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
            pairs
                .filter(|(i, j)| self.sides[*i] != self.sides[*j])
                .filter_map(|(i, j)| explain(vec![i, j]))
                .collect()
        };
        match least(single).or_else(|| least(pairs())) {
            Some((_, _, wheels, part)) => (wheels, part),
            None => (Vec::new(), 0.0),
        }
    }
}

/// The windows that tell the coefficients: without those that turn more than three times as fast as half of them do, while
/// a wheel departs from that turning by more than the turning itself.
///
/// In a curve both axles turn, whatever their tracks; where one wheel spins on a straight road half of what it has more is
/// left beside a turning of a quarter, and a coefficient of the turning would take it for the vehicle's.
fn determining(speeds: &[Vec<f64>], sides: &[f64], body: &[Body], used: Vec<usize>) -> Vec<usize> {
    let median = |mut x: Vec<f64>| {
        x.sort_by(f64::total_cmp);
        x.get(x.len() / 2).copied().unwrap_or(0.0)
    };
    let raw = |i: usize, k: usize| speeds[i][k] - body[k].ahead - sides[i] * body[k].turning;
    let radii: Vec<f64> = (0..sides.len())
        .map(|i| {
            let ahead = used.iter().filter(|k| body[**k].ahead != 0.0);
            median(ahead.map(|&k| raw(i, k) / body[k].ahead).collect())
        })
        .collect();
    let turns = |k: usize| body[k].turning.abs();
    let often = median(used.iter().map(|k| turns(*k)).collect());
    let contradicts = |k: usize| {
        let mut off = (0..sides.len()).map(|i| (raw(i, k) - radii[i] * body[k].ahead).abs());
        turns(k) > 3.0 * often && off.any(|off| off > turns(k))
    };
    let kept: Vec<usize> = used.iter().copied().filter(|k| !contradicts(*k)).collect();
    // Below half of them nothing is typical any more.
    if 2 * kept.len() < used.len() {
        used
    } else {
        kept
    }
}

/// Change of what a wheel has beyond the vehicle, from one window to the next.
pub(crate) struct Change {
    /// `None` where the vehicle hardly moves.
    values: Vec<Option<f64>>,
    centre: f64,
    pub(crate) deviation: f64,
}

impl Change {
    pub(crate) fn of(beyond: &[f64], moves: &[bool], w: usize) -> Self {
        let values: Vec<Option<f64>> = (0..beyond.len() - w)
            .map(|k| (moves[k] && moves[k + w]).then(|| beyond[k + w] - beyond[k]))
            .collect();
        let known: Vec<f64> = values.iter().flatten().copied().collect();
        let (centre, deviation) = match known.len() {
            0 => (0.0, f64::INFINITY),
            _ => quiet(&known),
        };
        Self {
            values,
            centre,
            deviation,
        }
    }

    fn size(&self, k: usize) -> f64 {
        self.values[k].map_or(0.0, |c| c - self.centre)
    }

    /// In standard deviations of the quiet part; zero for what rounding can do.
    pub(crate) fn deviations(&self, k: usize, rounding: f64) -> f64 {
        let size = self.size(k).abs();
        if size > rounding {
            size / self.deviation
        } else {
            0.0
        }
    }
}

/// Least squares of the body's two speeds through the wheels that are kept.
fn fitted(sides: &[f64], keep: &[bool], value: impl Fn(usize) -> f64) -> Option<Body> {
    let (mut n, mut y, mut yy, mut v, mut yv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, side) in sides.iter().enumerate().filter(|(i, _)| keep[*i]) {
        let value = value(i);
        n += 1.0;
        y += side;
        yy += side * side;
        v += value;
        yv += side * value;
    }
    let determinant = n * yy - y * y;
    (determinant > 1e-9).then(|| Body {
        ahead: (yy * v - y * yv) / determinant,
        turning: (n * yv - y * v) / determinant,
    })
}

/// Coefficients of three columns with Huber's weights; those that nothing determines are zero.
fn robust(used: &[usize], columns: &[[f64; 3]], value: impl Fn(usize) -> f64) -> [f64; 3] {
    let size = |c: usize| {
        let sum: f64 = used.iter().map(|k| columns[*k][c].powi(2)).sum();
        (sum / used.len() as f64).sqrt()
    };
    let sizes: [f64; 3] = std::array::from_fn(|c| match size(c) {
        s if s > 0.0 => s,
        _ => 1.0,
    });
    let mut coefficients = [0.0; 3];
    let mut weights = vec![1.0; used.len()];
    for _ in 0..10 {
        let mut normal = Matrix3([[0.0; 3]; 3]);
        let mut right = [0.0; 3];
        for (k, weight) in used.iter().zip(&weights) {
            let x: [f64; 3] = std::array::from_fn(|c| columns[*k][c] / sizes[c]);
            for i in 0..3 {
                right[i] += weight * x[i] * value(*k);
                for j in 0..3 {
                    normal.0[i][j] += weight * x[i] * x[j];
                }
            }
        }
        // A drive straight ahead does not tell the coefficients of turning: a millionth of the weights holds them.
        let total: f64 = weights.iter().sum();
        for i in 0..3 {
            normal.0[i][i] += 1e-6 * total;
        }
        let Ok(inverse) = normal.inverse() else { break };
        let scaled = inverse.times(right);
        coefficients = std::array::from_fn(|c| (scaled[c] / sizes[c]).clamp(-MOST[c], MOST[c]));
        let rest: Vec<f64> = used
            .iter()
            .map(|k| (value(*k) - proofmass_core::dot(coefficients, columns[*k])).abs())
            .collect();
        let mut sorted = rest.clone();
        // Median of |normal| is 0.6745 σ.
        let sigma = (upper_median(&mut sorted).unwrap_or(0.0) / 0.6745).max(f64::MIN_POSITIVE);
        for (weight, rest) in weights.iter_mut().zip(&rest) {
            *weight = (1.345 * sigma / rest.max(f64::MIN_POSITIVE)).min(1.0);
        }
    }
    coefficients
}
