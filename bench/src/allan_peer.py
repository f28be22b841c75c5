"""The peers of allan.rs: allantools and SciPy on the same samples.

Each line of standard input names a measurement; answered is one line with its seconds, its seconds of processor time,
and the values to compare.
"""
import sys
import time

import allantools
import numpy as np
import scipy.signal

RATE = 100.0

rate = np.fromfile(sys.argv[1])
short = rate[:2000]


def oadev():
    return allantools.oadev(rate, rate=RATE, data_type="freq", taus="octave")[1]


def mtotdev():
    return allantools.mtotdev(short, rate=RATE, data_type="freq", taus="octave")[1]


def welch(segment):
    return scipy.signal.welch(rate, RATE, nperseg=segment)[1][1:9]


measurements = {
    "oadev": oadev,
    "mtotdev": mtotdev,
    "welch_256": lambda: welch(256),
    "welch_4096": lambda: welch(4096),
}

for line in sys.stdin:
    function = measurements[line.strip()]
    start, processor = time.perf_counter(), time.process_time()
    values = function()
    seconds = time.perf_counter() - start
    print(seconds, time.process_time() - processor, *values, flush=True)
