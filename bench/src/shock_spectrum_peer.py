"""The peer of shock_spectrum.rs: ramp-invariant filters of ISO 18431-4 with scipy.

Prints one line per measurement: name, seconds of the best of several, and the sum of the maximax values.
"""
import time

import numpy as np
from scipy.signal import lfilter

SAMPLES, RATE, Q = 1_000_000, 100e3, 10.0


def best(function, clock=time.perf_counter, repeats=2):
    times = []
    for _ in range(repeats):
        start = clock()
        value = function()
        times.append(clock() - start)
    return min(times), value


def main():
    k = np.arange(SAMPLES, dtype=np.int64)
    record = ((7 * k * k + 3 * k) % 101) / 101.0 - 0.5
    record[0] = 0.0
    frequencies = 10.0 * 2.0 ** (np.arange(200) / 20.0)

    def spectrum():
        total = 0.0
        for f in frequencies:
            a = np.pi * f / RATE / Q
            b = 2 * np.pi * f / RATE * np.sqrt(1 - 1 / (4 * Q * Q))
            e = np.exp(-a)
            c, s = e * np.cos(b), e * np.sin(b) / b
            numerator = [1 - s, 2 * (s - c), e * e - s]
            response = lfilter(numerator, [1, -2 * c, e * e], record)
            total += max(response.max(), -response.min())
        return total

    print("lfilter", *best(spectrum))
    print("lfilter_processor", *best(spectrum, time.process_time, 1))


main()
