"""The peer of sine.rs: three-parameter sine fits of four channels with numpy.

Prints one line per measurement: name, seconds of the best of several, and the modulus of the first channel.
"""
import time

import numpy as np

SAMPLES, CHANNELS, OMEGA = 1 << 20, 4, 0.0123


def best(function, clock=time.perf_counter, repeats=5):
    times = []
    for _ in range(repeats):
        start = clock()
        value = function()
        times.append(clock() - start)
    return min(times), value


def main():
    rng = np.random.default_rng(1)
    n = np.arange(SAMPLES)
    x = np.cos(OMEGA * n + 0.2)[:, None] + 1e-3 * rng.standard_normal((SAMPLES, CHANNELS))
    basis = np.column_stack([np.cos(OMEGA * n), np.sin(OMEGA * n), np.ones(SAMPLES)])

    def least_squares():
        solution = np.linalg.lstsq(basis, x, rcond=None)[0]
        return np.hypot(solution[0, 0], solution[1, 0])

    def normal_equations():
        solution = np.linalg.solve(basis.T @ basis, basis.T @ x)
        return np.hypot(solution[0, 0], solution[1, 0])

    print("least_squares", *best(least_squares))
    print("normal_equations", *best(normal_equations))
    print("least_squares_processor", *best(least_squares, time.process_time))


main()
