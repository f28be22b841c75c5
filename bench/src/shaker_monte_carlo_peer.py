"""The peer of shaker_monte_carlo.rs: the same trials with numpy, in batches that fit the cache.

One frequency, 44 configurations: every error of the published bench is drawn with what shares it, the outputs
follow exactly, S is their ordinary least-squares estimate. Prints seconds per million trials and u(Re S_xx).
"""
import time

import numpy as np

TRIALS, BATCH = 100_000, 1_000


def plan():
    yield from ((0.0, 90.0 * i) for i in range(4))
    for a in (15.0, 35.0, 55.0, 75.0, 90.0):
        yield from ((a, 45.0 * i) for i in range(8))


def main():
    rng = np.random.default_rng(1)
    configurations = np.radians(np.array(list(plan())))
    alpha, omega = configurations.T
    wedge = np.unique(alpha, return_inverse=True)[1]
    runs = len(alpha)
    s = np.full((3, 3), 3e-4 + 1e-5j)
    np.fill_diagonal(s, 0.0104 + 1e-5j)

    def directions(a, w):
        return np.stack([np.sin(a) * np.cos(w), np.sin(a) * np.sin(w), np.cos(a) + 0 * w], axis=-1)

    estimator = np.linalg.pinv(directions(alpha, omega))

    def rectangular(half, *shape):
        return rng.uniform(-half, half, shape)

    def batch(n):
        a = alpha + rectangular(np.radians(0.1), n, wedge.max() + 1)[:, wedge]
        w = omega + rectangular(np.radians(1.0), n, runs)
        o = directions(a, w) @ s
        relative = 1 + 0.001 * rng.standard_normal((n, runs, 3))
        relative *= 1 + 0.003 * rng.standard_normal((n, runs, 3))
        for half in (0.001, 0.001, 0.0015):
            relative *= 1 + rectangular(half, n, runs, 3)
        relative *= 1 + rectangular(0.0015, n, 1, 3)
        phase = 0.003 * rng.standard_normal((n, runs, 3)) - 0.003 * rng.standard_normal((n, 1, 1))
        noise = 5e-6 * (rng.standard_normal((n, runs, 3)) + 1j * rng.standard_normal((n, runs, 3)))
        reference = 1 + 0.002 * rng.standard_normal((n, 1, 1))
        seen = (o * relative * np.exp(1j * phase) + noise) / reference
        return np.einsum("kr,nrj->nkj", estimator, seen)

    batch(BATCH)
    start, used = time.perf_counter(), time.process_time()
    results = np.concatenate([batch(BATCH) for _ in range(TRIALS // BATCH)])
    np.quantile(results.real, [0.025, 0.975], axis=0)
    np.quantile(results.imag, [0.025, 0.975], axis=0)
    million = 1_000_000 / TRIALS
    seconds, used = (time.perf_counter() - start) * million, (time.process_time() - used) * million
    u = results[:, 0, 0].real.std()
    print("one_frequency", seconds, u)
    print("one_frequency_processor", used, u)


main()
