"""The peers of uncertainty.rs: the same calculations with numpy and with the package `uncertainties`.

Prints one line per measurement: name, seconds of the best of five, and a figure to compare.
"""
import time


def best(function, repeats=5):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        value = function()
        times.append(time.perf_counter() - start)
    return min(times), value


def end_gauge(trials=1_000_000):
    """GUM H.1 with the distributions of Supplement 1, 9.5; mean, u and the symmetric 99 % interval."""
    import numpy as np

    rng = np.random.default_rng(1)
    t = lambda m, s, nu: m + s * rng.standard_t(nu, trials)
    l_s, d = t(50_000_623.0, 25.0, 18), t(215.0, 5.8, 24)
    d1, d2 = t(0.0, 3.9, 5), t(0.0, 6.7, 8)
    alpha = rng.uniform(9.5e-6, 13.5e-6, trials)
    theta0 = rng.normal(-0.1, 0.2, trials)
    delta = 0.5 * np.sin(2 * np.pi * rng.random(trials))

    def curvilinear(low, high, inexact):
        a = low - inexact + 2 * inexact * rng.random(trials)
        return a + (low + high - 2 * a) * rng.random(trials)

    d_alpha, d_theta = curvilinear(-1e-6, 1e-6, 0.1e-6), curvilinear(-0.05, 0.05, 0.025)
    y = l_s + d + d1 + d2 - l_s * (d_alpha * (theta0 + delta) + alpha * d_theta) - 50_000_000.0
    np.quantile(y, [0.005, 0.995])
    y.mean()
    return y.std()


def inverse():
    """Inverse of a 3 × 3 matrix of nine independent elements, with the full 9 × 9 covariance."""
    import uncertainties as un

    values = [[4.0, 1.0, 0.5], [0.3, 5.0, 0.2], [0.1, 0.7, 6.0]]
    m = [[un.ufloat(v, 0.01) for v in row] for row in values]
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    out = [
        (e * i - f * h) / det, (c * h - b * i) / det, (b * f - c * e) / det,
        (f * g - d * i) / det, (a * i - c * g) / det, (c * d - a * f) / det,
        (d * h - e * g) / det, (b * g - a * h) / det, (a * e - b * d) / det,
    ]
    return un.covariance_matrix(out)[0][0]


if __name__ == "__main__":
    print("end_gauge", *best(end_gauge))
    inverse()
    seconds, value = best(inverse, 50)
    print("inverse", seconds, value)
