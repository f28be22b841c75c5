"""The peer of transfer.rs: densities and cross-densities with scipy.

Prints one line per measurement: name, seconds of the best of several, and the imaginary part of one line of H1.
"""
import time

import numpy as np
from scipy.signal import csd, welch

SAMPLES = 10_000_000


def best(function, clock=time.perf_counter, repeats=2):
    times = []
    for _ in range(repeats):
        start = clock()
        value = function()
        times.append(clock() - start)
    return min(times), value


def main():
    k = np.arange(SAMPLES, dtype=np.int64)
    x = ((7 * k * k + 3 * k) % 10007) / 10007.0 - 0.5
    outputs = [np.concatenate([np.zeros(d), x[:-d]]) for d in (1, 2, 3)]

    def responses():
        gxx = welch(x, nperseg=4096)[1]
        for y in outputs:
            gyy = welch(y, nperseg=4096)[1]
            gxy = csd(x, y, nperseg=4096)[1]
            h = gxy / gxx
            coherence = np.abs(gxy) ** 2 / (gxx * gyy)
        assert coherence.shape == h.shape
        return h[100].imag

    print("csd", *best(responses))
    print("csd_processor", *best(responses, time.process_time, 1))


main()
