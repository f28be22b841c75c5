//! Discrete Fourier transforms of real signals, without scaling.

pub use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use std::cell::RefCell;
use std::sync::Arc;

/// A length, and how its transform is made.
type Plan = (usize, Arc<dyn RealToComplex<f64>>);

thread_local! {
    /// The last plan of this thread: recordings of a campaign have one length, and a plan takes as long as its transform.
    static LAST: RefCell<Option<Plan>> = const { RefCell::new(None) };
}

/// How a forward transform of this length is made.
pub(crate) fn plan(n: usize) -> Arc<dyn RealToComplex<f64>> {
    LAST.with_borrow_mut(|last| match last {
        Some((length, plan)) if *length == n => plan.clone(),
        _ => {
            let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
            *last = Some((n, plan.clone()));
            plan
        }
    })
}

/// X_k = Σ_n x_n e^{−2πikn/N} for 0 ≤ k ≤ N/2.
///
/// **Shapes** the result has N/2 + 1 elements (rounded down). Empty for an empty signal. Any length is
/// accepted; lengths with small prime factors ([`fast_length`]) are fastest.
///
/// ```
/// let spectrum = proofmass_signal::fourier::forward(&[1.0, 2.0, 3.0, 4.0]);
/// assert!((spectrum[0].re - 10.0).abs() < 1e-15);
/// assert!((spectrum[1].re + 2.0).abs() < 1e-15 && (spectrum[1].im - 2.0).abs() < 1e-15);
/// ```
pub fn forward(signal: &[f64]) -> Vec<Complex<f64>> {
    forward_owned(signal.to_vec())
}

/// [`forward`] using the signal as working space.
pub fn forward_owned(mut signal: Vec<f64>) -> Vec<Complex<f64>> {
    if signal.is_empty() {
        return Vec::new();
    }
    let plan = plan(signal.len());
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut signal, &mut spectrum)
        .expect("buffers have the lengths the plan was made for");
    spectrum
}

/// x_n = 1/N Σ_k X_k e^{2πikn/N}, the inverse of [`forward`], for a signal of `n` samples.
///
/// The imaginary parts at zero and at the Nyquist frequency, which a real signal cannot have, are left out.
///
/// **Shapes** `spectrum.len() == n / 2 + 1`, otherwise `None`.
pub fn inverse(mut spectrum: Vec<Complex<f64>>, n: usize) -> Option<Vec<f64>> {
    if n == 0 || spectrum.len() != n / 2 + 1 {
        return None;
    }
    spectrum[0].im = 0.0;
    if n.is_multiple_of(2) {
        spectrum[n / 2].im = 0.0;
    }
    let plan = RealFftPlanner::<f64>::new().plan_fft_inverse(n);
    let mut signal = plan.make_output_vec();
    plan.process(&mut spectrum, &mut signal).ok()?;
    signal.iter_mut().for_each(|v| *v /= n as f64);
    Some(signal)
}

/// Smallest length ≥ n with no prime factor above 5.
///
/// ```
/// assert_eq!(proofmass_signal::fourier::fast_length(1021), 1024);
/// assert_eq!(proofmass_signal::fourier::fast_length(1025), 1080);
/// ```
pub fn fast_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (n.max(1)..).find(|&m| smooth(m)).unwrap_or(n)
}

/// Σ_n x_n x_{n+l} for lags below the padded length minus the signal's, through the spectrum (Wiener and Khinchin).
///
/// **Shapes** `padded` elements, `padded >= signal.len()`.
pub fn autocorrelation(signal: &[f64], padded: usize) -> Vec<f64> {
    let mut long = signal.to_vec();
    long.resize(padded, 0.0);
    let power = forward_owned(long)
        .iter()
        .map(|x| Complex::new(x.norm_sqr(), 0.0))
        .collect();
    inverse(power, padded).unwrap_or_default()
}
