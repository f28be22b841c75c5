#!/usr/bin/env python3
"""The Python package beside the packages of others, in one run, as ratios of the best of several times.

    python bench/src/python_peers.py

Needs the package as it is published (optimised: `just wheel`), uncertainties, GTC and allantools.
"""

import time
import warnings

import allantools
import GTC
import numpy as np
import proofmass
import uncertainties
from uncertainties import unumpy

warnings.simplefilter("ignore")


def best(work, times=5):
    took = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        took.append(time.perf_counter() - began)
    return min(took)


def row(task, ours, theirs, peer):
    print(f"| {task} | {1e3 * ours:.3g} ms | {peer} {theirs / ours:.3g} × |")


rng = np.random.default_rng(1)
values, others = rng.uniform(1, 2, (2, 1_000_000))
a, b = proofmass.uarray(values, 0.01), proofmass.uarray(others, 0.02)
few = 50_000
c, d = unumpy.uarray(values[:few], 0.01), unumpy.uarray(others[:few], 0.02)
print("| task | proofmass | against |\n|---|---|---|")
ours = best(lambda: (a * b).u)
row("10⁶ uncertain numbers multiplied, with their u", ours, 20 * best(lambda: unumpy.std_devs(c * d), 2), "uncertainties")


def chain(number, sine):
    x = number(5.0, 0.01)
    for _ in range(50):
        x = sine(x) * number(2.0, 0.01) + x / number(3.0, 0.02)
    return x


ours = best(lambda: chain(proofmass.ufloat, np.sin).u)
theirs = best(lambda: chain(uncertainties.ufloat, uncertainties.umath.sin).std_dev)
row("a chain of 200 operations on numbers, 101 causes", ours, theirs, "uncertainties")
row("the same", ours, best(lambda: chain(GTC.ureal, GTC.sin).u), "GTC")
noise = rng.normal(size=1_000_000)
ours = best(lambda: proofmass.allan_deviation(noise, 100.0))
theirs = best(lambda: allantools.oadev(noise, 100.0, data_type="freq", taus="octave"))
row("OADEV of 10⁶ samples, with intervals (theirs without)", ours, theirs, "allantools")
small = rng.normal(size=64)
ours = best(lambda: [proofmass.fit_sine(small, 100.0, 5.0) for _ in range(1000)]) / 1000
print(f"| a sine in 64 samples, one call | {1e6 * ours:.3g} µs | |")


def numpy_trials():
    draws = np.random.default_rng(1)
    total = sum(draws.uniform(-1, 1, 1_000_000) for _ in range(4))
    return total.mean(), total.std(), np.quantile(total, [0.025, 0.975])


known = dict.fromkeys("wxyz", {"value": 0.0, "half_width": 1.0})
ours = best(lambda: proofmass.monte_carlo(lambda w, x, y, z: w + x + y + z, known, trials=1_000_000), 3)
row("10⁶ trials of a function of four inputs", ours, best(numpy_trials, 3), "numpy by hand")
