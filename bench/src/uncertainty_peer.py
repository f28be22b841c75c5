"""The peers of uncertainty.rs: the same calculations with numpy, with GTC and with the package `uncertainties`.

Prints one line per measurement: name, seconds of the best run, and a figure to compare.
"""
import math
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


def inverse_of(elements, covariance):
    """Inverse of a 3 × 3 matrix of nine independent elements, with the full 9 × 9 covariance."""
    a, b, c, d, e, f, g, h, i = elements
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    out = [
        (e * i - f * h) / det, (c * h - b * i) / det, (b * f - c * e) / det,
        (f * g - d * i) / det, (a * i - c * g) / det, (c * d - a * f) / det,
        (d * h - e * g) / det, (b * g - a * h) / det, (a * e - b * d) / det,
    ]
    return covariance(out)


MATRIX = [4.0, 1.0, 0.5, 0.3, 5.0, 0.2, 0.1, 0.7, 6.0]


def inverse():
    import uncertainties as un

    return inverse_of([un.ufloat(v, 0.01) for v in MATRIX], un.covariance_matrix)[0][0]


def inverse_gtc():
    import GTC

    def covariance(out):
        return [[GTC.get_covariance(a, b) for b in out] for a in out]

    return inverse_of([GTC.ureal(v, 0.01) for v in MATRIX], covariance)[0][0]


# GUM H.1: estimates, standard uncertainties, degrees of freedom.
GAUGE = [
    (50_000_623.0, 25.0, 18), (215.0, 5.8, 24), (0.0, 3.9, 5), (0.0, 6.7, 8), (11.5e-6, 2e-6 / math.sqrt(3), math.inf),
    (-0.1, 0.2, math.inf), (0.0, 0.5 / math.sqrt(2), math.inf), (0.0, 1e-6 / math.sqrt(3), 50),
    (0.0, 0.05 / math.sqrt(3), 2),
]


def gauge(x):
    l_s, d, d1, d2, alpha, theta0, delta, d_alpha, d_theta = x
    return l_s + d + d1 + d2 - l_s * (d_alpha * (theta0 + delta) + alpha * d_theta)


def gauge_uncertainties():
    import uncertainties as un

    return gauge([un.ufloat(v, u) for v, u, _ in GAUGE]).std_dev


def gauge_gtc():
    import GTC

    y = gauge([GTC.ureal(*x) for x in GAUGE])
    y.df
    return y.u


# GUM H.2: means and their covariance, from five readings of each quantity together.
READINGS = [
    [5.007, 4.994, 5.005, 4.990, 4.999],
    [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
    [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],
]


def impedance_uncertainties():
    import numpy as np
    import uncertainties as un
    from uncertainties import umath

    data = np.array(READINGS)
    v, i, phi = un.correlated_values(data.mean(axis=1), np.cov(data) / 5)
    out = [v / i * umath.cos(phi), v / i * umath.sin(phi), v / i]
    return un.covariance_matrix(out)[0][0]


def impedance_gtc():
    import GTC

    v, i, phi = GTC.type_a.multi_estimate_real(READINGS)
    out = [v / i * GTC.cos(phi), v / i * GTC.sin(phi), v / i]
    [y.df for y in out]
    return [[GTC.get_covariance(a, b) for b in out] for a in out][0][0]


if __name__ == "__main__":
    print("end_gauge", *best(end_gauge))
    for name in ("inverse", "inverse_gtc", "gauge_uncertainties", "gauge_gtc", "impedance_uncertainties", "impedance_gtc"):
        globals()[name]()
        print(name, *best(globals()[name], 50))
