//! The functions a record is fitted with, and their exact inner products.

use super::Coefficients;
use super::pass::Look;
use super::tables::Tables;
use faer::Mat;
use num_complex::Complex64;

/// One real function Re(u τᵖ e^{jkω n}) about the middle of the record; k = 0 is the trend.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub(crate) coefficient: Complex64,
    multiple: usize,
    power: usize,
}

impl Term {
    pub(crate) fn new(coefficient: Complex64, multiple: usize, power: usize) -> Self {
        Self {
            coefficient,
            multiple,
            power,
        }
    }

    /// Σ Re(u τᵖ e^{jkωn}) e^{−jωn} over one block = ½ (u E_p(k − 1) + ū Ē_p(k + 1)).
    pub(crate) fn demodulated(&self, tables: &Tables, block: usize) -> Complex64 {
        let sums = |k: usize| tables.block_sums(k, block)[self.power];
        let below = match self.multiple {
            0 => sums(1).conj(),
            k => sums(k - 1),
        };
        let above = sums(self.multiple + 1).conj();
        (self.coefficient * below + self.coefficient.conj() * above) * 0.5
    }
}

/// Offset, drift where asked, cosine and sine of every harmonic.
pub(crate) struct Basis {
    terms: Vec<Term>,
    drift: bool,
    harmonics: usize,
    /// Σ τᵖ e^{jkωn} for p = 0, 1, 2 and k = 0 … 2H.
    sums: [Vec<Complex64>; 3],
}

impl Basis {
    /// Over some blocks of a record.
    pub(crate) fn new(
        tables: &Tables,
        drift: bool,
        harmonics: usize,
        blocks: impl Iterator<Item = usize> + Clone,
    ) -> Self {
        let one = Complex64::new(1.0, 0.0);
        let mut terms = vec![Term::new(one, 0, 0)];
        if drift {
            terms.push(Term::new(one, 0, 1));
        }
        for h in 1..=harmonics {
            terms.push(Term::new(one, h, 0));
            terms.push(Term::new(Complex64::new(0.0, -1.0), h, 0));
        }
        Self {
            terms,
            drift,
            harmonics,
            sums: tables.power_sums(blocks),
        }
    }

    pub(crate) fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Positions of the cosine and the sine of the fundamental.
    pub(crate) fn fundamental(&self) -> (usize, usize) {
        let first = 1 + usize::from(self.drift);
        (first, first + 1)
    }

    /// Σ Re(u τᵖ e^{jkωn}) Re(v τ^q e^{jlωn}) = ½ Re[u v Σ_{p+q}(k + l) + u v̄ Σ_{p+q}(k − l)].
    pub(crate) fn inner(&self, a: &Term, b: &Term) -> f64 {
        let sums = &self.sums[a.power + b.power];
        let (u, v) = (a.coefficient, b.coefficient);
        let plus = sums[a.multiple + b.multiple];
        let minus = if a.multiple >= b.multiple {
            sums[a.multiple - b.multiple]
        } else {
            sums[b.multiple - a.multiple].conj()
        };
        0.5 * (u * v * plus + u * v.conj() * minus).re
    }

    pub(crate) fn gram(&self) -> Mat<f64> {
        let p = self.terms.len();
        Mat::from_fn(p, p, |i, j| self.inner(&self.terms[i], &self.terms[j]))
    }

    /// ⟨basis, x⟩ from the moments ⟨x, e^{jkωn}⟩ of a channel.
    pub(crate) fn project(&self, moments: &Look) -> Mat<f64> {
        let mut right = vec![moments.sum];
        if self.drift {
            right.push(moments.slope);
        }
        for z in &moments.demodulated {
            // z = Σ x e^{−jkωn}, so Σ x cos = Re z and Σ x sin = −Im z.
            right.push(z.re);
            right.push(-z.im);
        }
        Mat::from_fn(right.len(), 1, |i, _| right[i])
    }

    pub(crate) fn coefficients(&self, solution: &Mat<f64>) -> Coefficients {
        let (first, _) = self.fundamental();
        Coefficients {
            offset: solution[(0, 0)],
            drift: if self.drift { solution[(1, 0)] } else { 0.0 },
            amplitudes: (0..self.harmonics)
                .map(|h| {
                    Complex64::new(
                        solution[(first + 2 * h, 0)],
                        -solution[(first + 2 * h + 1, 0)],
                    )
                })
                .collect(),
        }
    }
}
