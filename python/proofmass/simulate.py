"""Recordings whose truth is known.

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ._command import command
from ._types import Data, Names, Place, Watch

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "axis",
    "multi_position",
    "noise",
    "primary",
    "shaker",
    "spurious_motion",
    "transducer",
]


def __dir__() -> Names:
    return __all__


@command("simulate multi-position")
def multi_position(
    *,
    output: Place,
    seed: int = 1,
    standstills: int = 24,
    noise: float = 4,
    wander: float = 0.001,
    watch: Watch | None = None,
) -> Path:
    """A triaxial accelerometer turned by hand from rest to rest: campaign.toml, recording.csv, truth.json.

    Args:
        output: Folder for the files.
        seed: The same seed makes the same recording on every machine.
        standstills: Number of standstills.
        noise: Noise of one sample, counts.
        wander: Wander between standstills, m/s².
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate shaker")
def shaker(
    *,
    output: Place,
    seed: int = 1,
    frequencies: float | str | Sequence[float] = "5,10,20,40,80,160,315,630,1000",
    configurations: int = 44,
    duration: float = 2,
    sampling_rate: float = 51200,
    phasors: bool = False,
    ideal_table: bool = False,
    sensor: str | None = None,
    drive: str = "sine",
    sessions: int = 1,
    repeats: int = 10,
    fault: str | Sequence[str | int | float] | None = None,
    wedge_motion: Data | None = None,
    watch: Watch | None = None,
) -> Path:
    """A triaxial accelerometer on wedges on a shaker: campaign.toml, runs.csv, one recording per run, reference.csv,
    spurious.csv, truth.json.

    Args:
        output: Folder for the files.
        seed: The same seed makes the same campaign on every machine.
        frequencies: Drive frequencies, Hz.
        configurations: Number of configurations: the best ones of the published 44.
        duration: Duration of a recording, s.
        sampling_rate: Sampling rate, Hz.
        phasors: Write phasors into runs.csv instead of recordings.
        ideal_table: A table and wedges that move along the excitation alone.
        sensor: The device as a digital sensor with files of its own, by whose clock it samples: own, shared.
        drive: How a recording is driven: sine (one frequency each), multi-sine or stepped (all frequencies in one).
        sessions: Sessions that the mountings are measured in, in turn; each has gains of its own, by 0.1 % and 1
            mrad.
        repeats: Repeats of every vibrometer reading.
        fault: Something that goes wrong, for practice: swapped-cables, inverted-channel, clipped, wrong-frequency,
            wrong-mounting, missing-run, double-run; in the run in the middle, or in run 17 with `swapped-cables:17`.
        wedge_motion: Bending of the wedges named in it, in place of the standard one: spurious.csv of `proofmass
            modes`.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate spurious-motion")
def spurious_motion(
    *,
    output: Place,
    seed: int = 1,
    frequencies: float | str | Sequence[float] = "5,10,20,40,80,160,315,630,1000",
    repeats: int = 10,
    no_common_clock: bool = False,
    wedge_motion: Data | None = None,
    watch: Watch | None = None,
) -> Path:
    """A vibrometer along the three axes of the table, wedge by wedge: campaign.toml, runs.csv with the phasors of every
    repeat, truth.json.

    Args:
        output: Folder for the files.
        seed: The same seed makes the same campaign on every machine.
        frequencies: Drive frequencies, Hz.
        repeats: Repeats of every reading.
        no_common_clock: The samples of the vibrometer do not share the clock of the reference.
        wedge_motion: Bending of the wedges named in it, in place of the standard one: spurious.csv of `proofmass
            modes`.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate primary")
def primary(
    *,
    output: Place,
    seed: int = 1,
    frequencies: float | str | Sequence[float] = "10,20,40,80,160,315,630,1000,2000,5000,10000",
    repeats: int = 3,
    rate: float = 200000,
    duration: float = 0.25,
    velocity: float = 0.012,
    noise: float = 0.005,
    output_noise: float = 0.00005,
    hum: float = 0.0001,
    vibration: float = 0.0000003,
    drift: float = 0.000001,
    u_wavelength: float = 0.0000015,
    u_voltage: float = 0.0001,
    watch: Watch | None = None,
) -> Path:
    """An accelerometer before a laser interferometer with quadrature outputs: campaign.toml, runs.csv, one recording of
    cosine, sine and output per run, truth.json.

    Args:
        output: Folder for the files.
        seed: The same seed makes the same campaign on every machine.
        frequencies: Drive frequencies, Hz.
        repeats: Runs at every frequency.
        rate: Sampling rate, Hz.
        duration: Shortest duration of a recording, s; it has twenty periods at least.
        velocity: Velocity amplitude of the table, m/s; above 800 Hz the amplitude is the next one at a zero of J₁.
        noise: Noise of the quadrature signals, relative to their amplitude.
        output_noise: Noise of the output, V rms.
        hum: Hum in the output at 50 Hz, V.
        vibration: Vibration of the interferometer at 23 Hz, m.
        drift: Drift of the interferometer, m/s.
        u_wavelength: Relative standard uncertainty of the wavelength, from which its error is drawn.
        u_voltage: Relative standard uncertainty of the voltage calibration, from which its error is drawn.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate axis")
def axis(
    *,
    output: Place,
    motion: str = "oscillation",
    frequency: float | None = None,
    duration: float = 5,
    rate: float = 1000,
    lines: int = 500,
    radius: float = 0.3,
    every: int = 1,
    missing: float = 0,
    eccentricity: float = 0,
    counter_bits: int | None = None,
    noise: float = 0.02,
    offset: float = 0.0005,
    gain_error: float = 0,
    orientation: float = 0,
    roll_off: float = 0,
    latency: float = 0,
    bits: int = 16,
    seed: int = 1,
    watch: Watch | None = None,
) -> Path:
    """A driven axis with encoder and accelerometer: recording.csv, truth.csv, truth.json.

    The defaults are those of the reference experiment: 500 lines decoded fourfold at 0.3 m, 16 bits fitted to the
    signal, 1 kHz. The same seed makes the same recording on every machine.

    Args:
        output: Folder for the files.
        motion: What the axis does. One of oscillation, motor, impact, ramp, standstill.
        frequency: Frequency of the oscillation or of the motor's reference, Hz [default: 4 or 5].
        duration: Duration, s.
        rate: Sampling rate, Hz.
        lines: Lines of the encoder, decoded fourfold.
        radius: Radius at which the accelerometer sits, m.
        every: A reading of the encoder at every n-th sample.
        missing: Probability that a reading of the encoder is missing.
        eccentricity: Once-per-turn error of an eccentric disc, rad.
        counter_bits: Bits of the counter, which rolls over [default: it never does].
        noise: Noise of one sample of the accelerometer, m/s².
        offset: Offset of the accelerometer as a share of the largest acceleration.
        gain_error: Relative gain error of the accelerometer.
        orientation: Inclination of the sensitive axis out of the horizontal, °.
        roll_off: Low corner of a piezoelectric accelerometer, Hz; 0 measures down to rest.
        latency: Time by which the accelerometer is late, s.
        bits: Bits of the converter, 0 for none.
        seed: Seed of the noise.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate transducer")
def transducer(
    *,
    output: Place,
    principle: str = "piezoelectric",
    motion: str = "shock",
    level: float | None = None,
    pulse: float | None = None,
    natural_frequency: float | None = None,
    damping: float | None = None,
    rate: float | None = None,
    duration: float | None = None,
    temperature: str | int = 0,
    noise: float = 0.00001,
    reference_noise: float = 0,
    bits: int = 24,
    seed: int = 1,
    construction: Data | None = None,
    watch: Watch | None = None,
) -> Path:
    """A transducer on a bench: recording.csv (time, reference, output), truth.csv, truth.json.

    The same seed makes the same recording on every machine.

    Args:
        output: Folder for the files.
        principle: Principle of the device, which is that of an example in all else. One of capacitive,
            piezoresistive, strain-gauge, piezoelectric, inductive, hall, thermal, resonant, tunnelling, shutter,
            interferometer.
        motion: What happens to it. One of shock, random, sweep, step.
        level: Greatest acceleration of the motion (RMS of noise), m/s² [default: a fifth of what the device measures,
            at its resonance where that is swept].
        pulse: Duration of the pulse, s [default: twenty periods of the mass].
        natural_frequency: Natural frequency of the mass, Hz [default: that of the example].
        damping: Damping ratio of the mass [default: that of the example].
        rate: Sampling rate, Hz [default: fifty times the natural frequency].
        duration: Duration, s [default: 65 536 samples].
        temperature: Departure from the reference temperature, K.
        noise: Noise of one sample as a share of full scale.
        reference_noise: Noise of one sample of the reference, m/s².
        bits: Bits of the converter, 0 for none.
        seed: Seed of the noise.
        construction: The device by its construction (sizes, materials, circuit), a TOML file, in place of a
            principle.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("simulate noise")
def noise(
    *,
    output: Place,
    sensor: str = "accelerometer",
    axes: int = 1,
    duration: float = 1000,
    rate: float = 100,
    white: float = 0.0025,
    flicker: float = 0,
    random_walk: float = 0.0005,
    quantisation: float = 0,
    ramp: float = 0,
    gauss_markov: str | Sequence[str | int | float] | None = None,
    sinusoid: str | Sequence[str | int | float] | None = None,
    corner: float | None = None,
    order: int = 2,
    step: float | None = None,
    gap: str | Sequence[str | int | float] | None = None,
    jitter: float = 0,
    outliers: float = 0,
    outlier_size: float = 10,
    seed: int = 1,
    watch: Watch | None = None,
) -> Path:
    """A sensor at rest with known noise: recording.csv, truth.json.

    The terms are those of `proofmass noise`, in SI: for an accelerometer N in (m/s²)/√Hz as the Allan deviation at 1
    s (data sheets give √2 N). The defaults are near a micromechanical accelerometer of the better kind over seventeen
    minutes.

    Args:
        output: Folder for the files.
        sensor: What is at rest. One of accelerometer, gyroscope.
        axes: Number of axes, independent of each other.
        duration: Duration, s.
        rate: Sampling rate, Hz.
        white: N, white noise.
        flicker: B, bias instability: the coefficient, the floor of the curve is 0.664 B.
        random_walk: K, random walk.
        quantisation: Q, quantisation noise.
        ramp: R, ramp.
        gauss_markov: A first-order Gauss–Markov process: standard deviation and correlation time in s; may be given
            several times.
        sinusoid: A sinusoid: amplitude and frequency in Hz; may be given several times.
        corner: Corner of a low-pass filter in front of the converter, Hz [default: no filter].
        order: Order of that filter.
        step: Smallest step of the converter [default: a millionth of the noise of a sample].
        gap: An interval that is missing, s; may be given several times.
        jitter: Jitter of the time stamps, in intervals of a sample (standard deviation).
        outliers: Share of the samples that are outliers.
        outlier_size: Size of the outliers in standard deviations of white noise.
        seed: Seed of the noise.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError
