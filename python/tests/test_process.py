"""The interpreter goes on, is heard and is not harmed."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import proofmass

LONG = """
import signal, sys, threading, time, os
import numpy, proofmass
data = numpy.random.default_rng(1).standard_normal(1_000_000)
threading.Timer(0.6, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
began = time.monotonic()
try:
    {work}
except KeyboardInterrupt:
    took = time.monotonic() - began
    time.sleep(1)
    before = time.process_time()
    time.sleep(0.5)
    print(took, time.process_time() - before)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize(
    "work",
    [
        "proofmass.uncertainty(sys.argv[1], trials=100_000_000)",
        "proofmass.monte_carlo(lambda a: a * a, {'a': {'value': 1, 'u': 0.1}}, trials=100_000_000)",
        "proofmass.noise(data, rate=100.0, taus='all')",
        "proofmass.allan_deviation(data, 100.0, taus='all')",
        "proofmass.allan_deviation(data, 100.0, taus='all', statistic='mdev')",
        "proofmass.allan_deviation(data, 100.0, statistic='theo1')",
        "proofmass.allan_deviation(data, 100.0, statistic='mtotdev')",
    ],
)
def test_ctrl_c_ends_a_long_calculation(examples, work):
    """It comes out within a second, and nothing goes on behind it."""
    model = examples / "uncertainty" / "end-gauge.toml"
    command = [sys.executable, "-c", LONG.format(work=work), model]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    took, spent = map(float, done.stdout.split())
    assert took < 1.6, done.stdout
    assert spent < 0.25, done.stdout


PEAK = """
import resource, numpy, proofmass
data = numpy.random.default_rng(1).standard_normal(16_000_000)
proofmass.noise(data[:2_000_000], rate=1000.0, stream=True)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
proofmass.noise(data, rate=1000.0, stream=True)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def test_an_array_is_not_copied():
    """The process grows by less than half of the 128 MB that it lends; `bench/src/python_costs.py` does it with a gigabyte."""
    pytest.importorskip("resource")
    command = [sys.executable, "-W", "ignore", "-c", PEAK]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    assert int(done.stdout) < 64 * 1024, done.stdout


def test_a_watch_is_told_and_may_stop(examples):
    seen = []

    class Enough(Exception):
        pass

    def watch(stage, done, of):
        seen.append((stage, done, of))
        raise Enough

    with pytest.raises(Enough):
        proofmass.uncertainty(examples / "uncertainty" / "end-gauge.toml", trials=50_000_000, watch=watch)
    assert seen


def test_other_threads_go_on(examples):
    counted = 0
    over = threading.Event()

    def count():
        nonlocal counted
        while not over.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.monotonic()
    proofmass.uncertainty(examples / "uncertainty" / "end-gauge.toml", trials=2_000_000)
    took = time.monotonic() - began
    over.set()
    thread.join()
    assert counted > 100 * took


def test_threads_do_not_meet(examples):
    results = {}

    def work(k):
        array = np.random.default_rng(k).normal(0, 1, 5000)
        results[k] = proofmass.allan_deviation(array, 1.0).deviation[0], array

    threads = [threading.Thread(target=work, args=(k,)) for k in range(8)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for value, array in results.values():
        assert value == proofmass.allan_deviation(array, 1.0).deviation[0]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_forked_process_calculates(examples):
    model = str(examples / "uncertainty" / "mass.toml")
    proofmass.uncertainty(model, trials=10_000)
    code = (
        "import os, sys, proofmass\n"
        "proofmass.uncertainty(sys.argv[1], trials=10_000)\n"
        "child = os.fork()\n"
        "if child == 0:\n"
        "    proofmass.uncertainty(sys.argv[1], trials=10_000)\n"
        "    os._exit(0)\n"
        "sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    subprocess.run([sys.executable, "-W", "ignore", "-c", code, model], check=True, timeout=60)


def test_nothing_leaks(examples):
    resource = pytest.importorskip("resource")
    array = np.random.default_rng(1).normal(0, 1, 200)

    def calls(count):
        for _ in range(count):
            proofmass.allan_deviation(array, 1.0)
            proofmass.ufloat(1, 0.1) * proofmass.ufloat(2, 0.1)

    calls(2000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls(8000)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 4096


def test_import_says_nothing():
    code = "import proofmass"
    done = subprocess.run(
        [sys.executable, "-X", "dev", "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == done.stderr == ""


def test_a_build_without_the_lock_is_told():
    code = "import sys; sys.version = '3.13.0 experimental free-threading build'; import proofmass"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "not tested on free-threaded builds" in done.stderr


def test_the_signal_handler_is_kept():
    # In a process of its own: Spark sets a handler where it was used.
    code = (
        "import signal, proofmass; proofmass.fit_sine([0.0, 1.0, 0.0, -1.0] * 8, rate=4.0, frequency=1.0);"
        "assert signal.getsignal(signal.SIGINT) is signal.default_int_handler"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
