"""The peer of the example deconvolution_map of proofmass-jobs: the inverse of a second-order model with scipy.

Half-sines and haversines through a resonance of 20 kHz, with noise. The inverse of the bilinear model with a zero-phase Butterworth low-pass at a
fixed corner (a third of the resonance, and the resonance), as done by hand. With PyDynamic, where it is installed, its deconvolution in the frequency
domain with uncertainty, and a low-pass there. Ours: `cargo run -p proofmass-jobs --example deconvolution_map peer`, records of the same kind.

Prints one line per method: name, records, root mean square and largest error of the peak in per cent, share of 95 % intervals that hold (where there are
any), and milliseconds a record.
"""
import time

import numpy as np
from scipy.signal import bilinear, butter, filtfilt, lfilter

PEAK, SENSITIVITY, RESONANCE = 5000.0, 1.4e-3, 20e3
W = 2 * np.pi * RESONANCE


def rate_of(duration):
    return float(np.clip(40 / duration, 2.5 * RESONANCE, 50 * RESONANCE))


def response(f, damping):
    r = f / RESONANCE
    return SENSITIVITY / (1 - r * r + 2j * damping * r)


def record(shape, duration, damping, noise, length, rng):
    rate = rate_of(duration)
    n = int(length * duration * rate)
    t = np.arange(n) / rate - 0.5 * (n / rate - duration)
    pulse = np.where((t > 0) & (t < duration), np.sin(np.pi * t / duration), 0.0)
    truth = PEAK * (pulse if shape == "half-sine" else pulse**2)
    long = 2 * n
    f = np.fft.rfftfreq(long, 1 / rate)
    volts = np.fft.irfft(np.fft.rfft(truth, long) * response(f, damping), long)[:n]
    return volts + SENSITIVITY * PEAK * noise * rng.standard_normal(n), rate, truth


def inverse(corner):
    def method(volts, rate, damping, quiet):
        b, a = bilinear([SENSITIVITY * W * W], [1, 2 * damping * W, W * W], rate)
        smooth = filtfilt(*butter(4, min(corner, 0.45 * rate), fs=rate), volts - volts[:quiet].mean())
        # The zeros of the bilinear transform lie at half the rate, where the inverse has no bound: their gain at rest instead.
        return lfilter(a, [b.sum()], smooth), None

    return method


def pydynamic(corner):
    from PyDynamic.uncertainty.propagate_DFT import DFT_deconv, GUM_DFT, GUM_iDFT

    def method(volts, rate, damping, quiet):
        signal = volts - volts[:quiet].mean()
        n = len(signal)
        spectrum, covariance = GUM_DFT(signal, np.var(signal[:quiet]))
        f = np.fft.rfftfreq(n, 1 / rate)
        h = response(f, damping)
        h = np.concatenate((h.real, h.imag))
        u_h = np.diag((1e-3 * np.abs(np.tile(response(f, damping), 2))) ** 2)
        x, u_x = DFT_deconv(h, spectrum, u_h, covariance)
        low = 1 / (1 + (f / corner) ** 8)
        low = np.concatenate((low, low))
        x, u_x = x * low, u_x * np.outer(low, low)
        value, variance = GUM_iDFT(x, u_x, Nx=n)
        return value, np.sqrt(np.clip(np.diag(variance), 0, None))

    return method


def measure(name, method, places, repeats):
    for noise in (1e-4, 1e-2, 1e-1):
        of_noise(f"{name} {noise}", method, [p for p in places if p[3] == noise], repeats)


def of_noise(name, method, places, repeats):
    errors, held, took = [], [], 0.0
    for index, (shape, duration, damping, noise, length) in enumerate(places):
        for seed in range(repeats):
            rng = np.random.default_rng(1000 * index + seed)
            volts, rate, _ = record(shape, duration, damping, noise, length, rng)
            quiet = int(0.4 * (length - 1) * duration * rate)
            start = time.perf_counter()
            value, u = method(volts, rate, damping, quiet)
            took += time.perf_counter() - start
            top = int(np.argmax(value))
            errors.append(100 * (value[top] / PEAK - 1))
            if u is not None:
                held.append(abs(value[top] - PEAK) <= 1.96 * u[top])
    e = np.array(errors)
    share = f"{100 * np.mean(held):.1f}" if held else "-"
    print(name, len(e), f"{np.sqrt(np.mean(e * e)):.2f} {np.abs(e).max():.1f} {share} {1e3 * took / len(e):.2f}")


def main():
    places = [
        (shape, duration, damping, noise, 10.0)
        for shape in ("half-sine", "haversine")
        for duration in (6e-5, 2e-4, 2e-3)
        for damping in (0.02, 0.7)
        for noise in (1e-4, 1e-2, 1e-1)
    ]
    measure("inverse_third", inverse(RESONANCE / 3), places, 20)
    measure("inverse_once", inverse(RESONANCE), places, 20)
    try:
        method = pydynamic(RESONANCE)
    except ImportError:
        print("pydynamic - not installed")
        return
    measure("pydynamic_once", method, places, 1)


main()
