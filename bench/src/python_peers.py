#!/usr/bin/env python3
"""The Python package beside the packages of others, in one run, as ratios of the best of several times.

    python bench/src/python_peers.py

Needs the package as it is published (optimised: `just wheel`), uncertainties, GTC, allantools and scipy.
"""

import time
import warnings

import allantools
import GTC
import numpy as np
import proofmass
import uncertainties.umath
from scipy.optimize import curve_fit
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
row(
    "10⁶ uncertain numbers multiplied, with their u",
    ours,
    20 * best(lambda: unumpy.std_devs(c * d), 2),
    "uncertainties",
)


def chain(number, sine):
    x = number(5.0, 0.01)
    for _ in range(50):
        # Each number is used once: `uncertainties` takes twice as long for every step that uses one twice.
        x = sine(x) * number(2.0, 0.01) + number(3.0, 0.02)
    return x


ours = best(lambda: chain(proofmass.ufloat, np.sin).u)
theirs = best(lambda: chain(uncertainties.ufloat, uncertainties.umath.sin).std_dev)
row("a chain of 150 operations on numbers, 101 causes", ours, theirs, "uncertainties")
row("the same", ours, best(lambda: chain(GTC.ureal, GTC.sin).u), "GTC")
noise = rng.normal(size=1_000_000)
ours = best(lambda: proofmass.allan_deviation(noise, 100.0))
theirs = best(lambda: allantools.oadev(noise, 100.0, data_type="freq", taus="octave"))
row("OADEV of 10⁶ samples, with intervals (theirs without)", ours, theirs, "allantools")
t = np.arange(100_000) / 10_000
wave = 2 * np.cos(2 * np.pi * 159.7 * t + 0.4) + 0.1 + rng.normal(0, 0.01, t.size)


def fitted():
    def sine(t, f, a, b, c):
        return a * np.cos(2 * np.pi * f * t) + b * np.sin(2 * np.pi * f * t) + c

    spectrum = np.abs(np.fft.rfft(wave - wave.mean()))
    start = np.argmax(spectrum) / (t.size / 10_000)
    return curve_fit(sine, t, wave, (start, 1.0, 1.0, 0.0))


found, covariance = fitted()
sine = proofmass.fit_sine(wave, 10_000.0)
assert abs(found[0] - sine.frequency) < 1e-3 * sine.frequency_u
assert abs(np.hypot(found[1], found[2]) - sine.modulus) < 1e-3 * sine.modulus_u
assert abs(np.sqrt(covariance[0, 0]) / sine.frequency_u - 1) < 1e-3
ours = best(lambda: proofmass.fit_sine(wave, 10_000.0))
row("four parameters of a sine in 10⁵ samples", ours, best(fitted), "scipy `curve_fit`")
small = rng.normal(size=64)
ours = best(lambda: [proofmass.fit_sine(small, 100.0, 5.0) for _ in range(1000)]) / 1000
print(f"| a sine in 64 samples, one call | {1e6 * ours:.3g} µs | |")


def numpy_trials():
    draws = np.random.default_rng(1)
    total = sum(draws.uniform(-1, 1, 1_000_000) for _ in range(4))
    return total.mean(), total.std(), np.quantile(total, [0.025, 0.975])


known = dict.fromkeys("wxyz", {"value": 0.0, "half_width": 1.0})
ours = best(
    lambda: proofmass.monte_carlo(
        lambda w, x, y, z: w + x + y + z, known, trials=1_000_000
    ),
    3,
)
row(
    "10⁶ trials of a function of four inputs",
    ours,
    best(numpy_trials, 3),
    "numpy by hand",
)
