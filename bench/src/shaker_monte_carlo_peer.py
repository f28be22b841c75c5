"""The peer of shaker_monte_carlo.rs: the same trials with numpy, in batches that fit the cache.

One frequency, 44 configurations: every error of the published bench is drawn with what shares it, the outputs
follow exactly. S is estimated twice: by ordinary least squares, with gains that are made once, and as ours is, by
weighted least squares in every trial, with the weights of the budget at what the trial predicts and an unknown of
declared uncertainty for every wedge, gluing, gain and the reference (one step from the ordinary estimate; ours takes
several). Prints seconds per million trials and u(Re S_xx).
"""
import time

import numpy as np

TRIALS, BATCH = 100_000, 1_000
WEIGHTED_TRIALS, WEIGHTED_BATCH = 4_000, 50


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
        return seen

    def ordinary(seen):
        return np.einsum("kr,nrj->nkj", estimator, seen)

    third = 1 / np.sqrt(3)
    drawn = directions(alpha, omega)
    by_alpha = np.stack([np.cos(alpha) * np.cos(omega), np.cos(alpha) * np.sin(omega), -np.sin(alpha)], axis=-1)
    by_omega = np.stack([-np.sin(alpha) * np.sin(omega), np.sin(alpha) * np.cos(omega), 0 * alpha], axis=-1)
    wedges = wedge.max() + 1
    # 18 reals of S, wedges, gluings, three gains, modulus and phase of the reference.
    unknowns = 18 + wedges + runs + 5
    along = 0.001**2 + 0.003**2 + (0.001**2 + 0.001**2 + 0.0015**2) / 3
    floor = 5e-6**2

    def weighted(seen):
        n = len(seen)
        start = ordinary(seen)
        m = drawn @ start
        a = np.zeros((n, runs, 3, unknowns), complex)
        for i in range(3):
            for j in range(3):
                a[:, :, j, 2 * (3 * i + j)] = drawn[:, i]
                a[:, :, j, 2 * (3 * i + j) + 1] = 1j * drawn[:, i]
        at = np.arange(runs)
        a[:, at, :, 18 + wedge] = np.moveaxis(np.radians(0.1) * third * (by_alpha @ start), 1, 0)
        a[:, at, :, 18 + wedges + at] = np.moveaxis(np.radians(1.0) * third * (by_omega @ start), 1, 0)
        for j in range(3):
            a[:, :, j, unknowns - 5 + j] = 0.0015 * third * m[:, :, j]
        a[..., unknowns - 2] = -0.002 * m
        a[..., unknowns - 1] = -0.003j * m
        # In the axes of each prediction its two parts are independent.
        size = np.abs(m)
        turn = np.conj(m) / size
        scale = 1 / np.sqrt(np.stack([along * size**2 + floor, 0.003**2 * size**2 + floor], axis=-1))
        a *= turn[..., None]
        residual = turn * (seen - m)
        rows = np.stack([a.real, a.imag], axis=3) * scale[..., None]
        left = (np.stack([residual.real, residual.imag], axis=-1) * scale).reshape(n, -1, 1)
        rows = rows.reshape(n, -1, unknowns)
        turned = rows.transpose(0, 2, 1)
        normal = turned @ rows
        normal[:, range(18, unknowns), range(18, unknowns)] += 1
        step = np.linalg.solve(normal, turned @ left)[:, :18, 0]
        return start + (step[:, 0::2] + 1j * step[:, 1::2]).reshape(n, 3, 3)

    def timed(name, estimate, trials, size):
        estimate(batch(size))
        start, used = time.perf_counter(), time.process_time()
        results = np.concatenate([estimate(batch(size)) for _ in range(trials // size)])
        np.quantile(results.real, [0.025, 0.975], axis=0)
        np.quantile(results.imag, [0.025, 0.975], axis=0)
        million = 1_000_000 / trials
        seconds, used = (time.perf_counter() - start) * million, (time.process_time() - used) * million
        u = results[:, 0, 0].real.std()
        print(name, seconds, u)
        print(name + "_processor", used, u)

    timed("one_frequency", ordinary, TRIALS, BATCH)
    timed("weighted", weighted, WEIGHTED_TRIALS, WEIGHTED_BATCH)


main()
