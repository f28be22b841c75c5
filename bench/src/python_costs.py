#!/usr/bin/env python3
"""What the Python package costs beside its numbers: import, calls, memory, threads, an end by Ctrl-C, leaks.

    python bench/src/python_costs.py [megabytes]

Needs the package as it is published (optimised: `just wheel`) and a Unix. Memory is measured in processes of their own, each with one array of so many
megabytes (1000 unless another number is given).
"""

import os
import resource
import signal
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import proofmass

MEGABYTES = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
MODELS = Path(__file__).resolve().parents[2] / "examples" / "uncertainty"


def run(code, *arguments, end=None):
    """Prints of a process of its own; `end` seconds after it begins to calculate it is interrupted."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL if end is not None else None,
        text=True,
    )
    if end is not None:
        assert process.stdout.readline() == "begin\n"
        time.sleep(end)
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        process.stdout.read()
        assert process.wait() != 0
        return time.monotonic() - began
    out, _ = process.communicate()
    assert process.returncode == 0
    return float(out)


def row(what, value):
    print(f"| {what} | {value} |", flush=True)


print("| what | here |\n|---|---|")

took = {"numpy": [], "proofmass": []}
for _ in range(15):
    for name, times in took.items():
        code = f"import time; t = time.perf_counter(); import {name}; print(time.perf_counter() - t)"
        times.append(1e3 * run(code))
row(
    "import, numpy's part of it",
    f"{min(took['proofmass']):.0f} ms, {min(took['numpy']):.0f} ms",
)


def microseconds(work, times=2000):
    for _ in range(200):
        work()
    spent = []
    for _ in range(times):
        began = time.perf_counter_ns()
        work()
        spent.append(time.perf_counter_ns() - began)
    return statistics.median(spent) / 1e3


from proofmass import _proofmass  # noqa: E402

small = np.random.default_rng(1).normal(size=64)
whole = microseconds(lambda: proofmass.fit_sine(small, 100.0, 5.0))
compiled = microseconds(lambda: _proofmass.fit_sine(small, 100.0, 5.0, True))
row(
    "a sine in 64 samples: the call, its compiled part",
    f"{whole:.1f} µs, {compiled:.1f} µs",
)
whole = microseconds(lambda: proofmass.allan_deviation(small, 100.0, taus=(0.01, 0.02)))
compiled = microseconds(
    lambda: _proofmass.allan_deviation(small, 100.0, "oadev", "0.01,0.02", 0.95)
)
row(
    "OADEV of 64 samples: the call, its compiled part",
    f"{whole:.1f} µs, {compiled:.1f} µs",
)
a, b = proofmass.ufloat(1, 0.1), proofmass.ufloat(2, 0.1)
row("a product of two uncertain numbers", f"{microseconds(lambda: a * b):.2f} µs")

PEAK = """
import resource, sys, numpy, proofmass
data = numpy.random.default_rng(1).standard_normal(int(sys.argv[1]) * 125_000)
proofmass.noise(data[:100_000], rate=1000.0)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
{work}
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print((after - before) / 1024 if {grown} else after / 1024)
"""
WORK = "proofmass.noise(data, rate=1000.0)"
base = run(PEAK.format(work="pass", grown=False), MEGABYTES)
peak = run(PEAK.format(work=WORK, grown=False), MEGABYTES)
row(
    f"`noise` of {MEGABYTES} MB of float64 in one channel: peak of the process, before the call",
    f"{peak:.0f} MiB, {base:.0f} MiB",
)
PAIRS = PEAK.replace("* 125_000)", "* 125_000).reshape(-1, 2)").replace(
    "data[:100_000]", "data[:50_000]"
)
peak = run(PAIRS.format(work=WORK, grown=False), MEGABYTES)
row("the same in two channels", f"{peak:.0f} MiB")

calibration = proofmass.calibrate.quiet(MODELS.parent / "hand-held").calibration
arrays = [np.random.default_rng(k).normal(33_000, 100, (400_000, 3)) for k in range(8)]


def compensated(k):
    for _ in range(3):
        calibration.apply(arrays[k])


def seconds(threads):
    began = time.perf_counter()
    waiting = list(range(8))

    def work():
        while waiting:
            try:
                k = waiting.pop()
            except IndexError:
                return
            compensated(k)

    all_of_them = [threading.Thread(target=work) for _ in range(threads)]
    for t in all_of_them:
        t.start()
    for t in all_of_them:
        t.join()
    return time.perf_counter() - began


counted, over = 0, threading.Event()


def count():
    global counted
    while not over.is_set():
        counted += 1
        time.sleep(0.001)


thread = threading.Thread(target=count)
thread.start()
began = time.perf_counter()
proofmass.uncertainty(MODELS / "end-gauge.toml", trials=4_000_000)
took_s = time.perf_counter() - began
over.set()
thread.join()
row(
    "a thread that wakes every ms beside a Monte Carlo: wakes per second",
    f"{counted / took_s:.0f}",
)
one, two, eight = (min(seconds(n) for _ in range(3)) for n in (1, 2, 8))
row(
    f"eight compensations of arrays in 1, 2, 8 threads on {os.cpu_count()} processors",
    f"{one:.2f} s, {two:.2f} s, {eight:.2f} s",
)

LONG = "import sys, numpy, proofmass\ndata = numpy.random.default_rng(1).standard_normal(1_000_000)\nprint('begin', flush=True)\n"
for what, work, end in [
    (
        "10⁸ trials of a model file",
        "proofmass.uncertainty(sys.argv[1], trials=100_000_000)",
        1.0,
    ),
    (
        "10⁸ trials of a function",
        "proofmass.monte_carlo(lambda a: a * a, {'a': {'value': 1, 'u': 0.1}}, trials=100_000_000)",
        1.0,
    ),
    (
        '`noise(taus="all")` of 10⁶ samples',
        "proofmass.noise(data, rate=100.0, taus='all')",
        3.0,
    ),
    (
        '`allan_deviation(taus="all")` of 10⁶ samples',
        "proofmass.allan_deviation(data, 100.0, taus='all')",
        1.0,
    ),
    (
        "the same of THEO1",
        "proofmass.allan_deviation(data, 100.0, statistic='theo1')",
        1.0,
    ),
]:
    row(
        f"{what}: from Ctrl-C to the end of the process",
        f"{run(LONG + work, MODELS / 'end-gauge.toml', end=end):.2f} s",
    )


def each():
    proofmass.velocity.drift.quiet(noise_density=1e-3)
    proofmass.allan_deviation(small, 1.0)
    (a * b).budget()


for _ in range(500):
    each()
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for _ in range(10_000 // 3):
    each()
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
row(
    "growth of the process over 10 000 calls of a command, a deviation, a budget",
    f"{grown} KiB",
)
