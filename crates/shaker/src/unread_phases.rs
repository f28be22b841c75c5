//! Runs of which the moduli of the outputs were read and no phases.
//!
//! The sense of a reading is told by the mounting where the excitation has a share of [`TOLD`](crate::observation::TOLD) or more along the
//! axis of the output: no cross term turns it over. There the modulus is that of the part of the output in phase with its main term, but
//! for the square of the rest. So S is stated with main terms that are real and positive and with cross terms in phase with them; how
//! large the rest of a cross term may be is told by the readings across the axis ([`quadrature`]).

use super::matrix::Matrix;
use super::observation::PhasorRow;
use super::plan::conditioning;
use faer::Mat;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::cholesky;

/// Part of a cross term out of phase with the main term, over that, where no reading across the axis tells it.
pub(super) const ASSUMED: f64 = 0.01;

/// The moduli of one frequency with the phases that the mounting gives them, and the S they agree with; `None` where the runs do not
/// determine it.
pub(super) fn restored(
    rows: &[PhasorRow],
    d: &[[Complex64; 3]],
    y: &[[Complex64; 3]],
) -> Option<(Vec<[Complex64; 3]>, Matrix)> {
    let mut s: Matrix = [[Complex64::ZERO; 3]; 3];
    for j in 0..3 {
        let column = along_axis(rows, d, y, j)?;
        for (row, value) in s.iter_mut().zip(column) {
            row[j] = Complex64::new(value, 0.0);
        }
    }
    let turned = rows.iter().zip(d).zip(y).map(|((row, d), y)| {
        std::array::from_fn(|j| {
            let prediction: Complex64 = (0..3).map(|a| d[a] * s[a][j]).sum();
            // A wild run may have turned the prediction over, and never the mounting.
            let sense = if row.tells(j) { d[j] } else { prediction };
            match sense.norm() > 0.0 {
                true => sense / sense.norm() * y[j].norm(),
                false => Complex64::new(y[j].norm(), 0.0),
            }
        })
    });
    Some((turned.collect(), s))
}

/// Sensitivities of output j to the three axes, by least squares on the readings whose sense is told.
fn along_axis(
    rows: &[PhasorRow],
    d: &[[Complex64; 3]],
    y: &[[Complex64; 3]],
    j: usize,
) -> Option<[f64; 3]> {
    let (mut gram, mut right) = (Mat::<f64>::zeros(3, 3), Mat::<f64>::zeros(3, 1));
    for i in (0..rows.len()).filter(|&i| rows[i].tells(j)) {
        let turn = d[i][j].conj() / d[i][j].norm();
        let in_phase = d[i].map(|d| (d * turn).re);
        for a in 0..3 {
            right[(a, 0)] += in_phase[a] * y[i][j].norm();
            for b in 0..3 {
                gram[(a, b)] += in_phase[a] * in_phase[b];
            }
        }
    }
    let s = cholesky(&gram).ok()?.solve(&right);
    let column = [0, 1, 2].map(|a| s[(a, 0)]);
    column.iter().all(|v| v.is_finite()).then_some(column)
}

/// Refuses runs whose readings do not determine S without their phases: each output needs three directions that are independent and have
/// a share along its axis.
pub(super) fn determined(rows: &[&PhasorRow]) -> Result<(), Error> {
    for j in 0..3 {
        let told = rows.iter().filter(|r| r.tells(j));
        let plan: Vec<_> = told.map(|r| r.configuration).collect();
        // The same refusal as for a plan that does not span, by the same measure.
        if plan.len() < 3 || conditioning(&plan).is_err() {
            return Err(Error::Unobservable {
                parameter: MODULI,
                condition: f64::INFINITY,
            });
        }
    }
    Ok(())
}

/// What no run tells of an output whose phases nobody read.
const MODULI: &str = "cross terms of an output whose phases were not read: runs are needed that excite its axis together with each of the others";

/// Standard uncertainty of the part of the cross terms of an output that is out of phase with its main term, by the readings across its
/// axis: what they have beyond the part in phase, which is known to `u`. `None` without such readings.
pub(super) fn quadrature(
    rows: &[&PhasorRow],
    predictions: &[[Complex64; 3]],
    j: usize,
    u: f64,
) -> Option<f64> {
    let (mut whole, mut in_phase, mut across) = (0.0, 0.0, 0.0);
    for (row, prediction) in rows.iter().zip(predictions) {
        if !row.tells(j) {
            whole += row.ratios()[j].norm_sqr();
            in_phase += prediction[j].norm_sqr();
            across += 1.0 - row.configuration.direction()[j].powi(2);
        }
    }
    let known = ((in_phase / across).sqrt() - u).max(0.0);
    (across > 0.0).then(|| (whole / across - known * known).max(0.0).sqrt())
}
