"""The commands of `proofmass` as functions.

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._command import command
from ._result import Result
from ._types import Data, Names, Place, Watch

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "apply",
    "bias",
    "calibrate",
    "certificate",
    "certificate_check",
    "certificate_read",
    "certificate_release",
    "certificate_template",
    "compare",
    "convert",
    "device_check",
    "device_plan",
    "explain",
    "export",
    "filter",
    "formats",
    "import_",
    "init",
    "inspect",
    "keygen",
    "modes",
    "noise",
    "noise_compare",
    "plan",
    "render",
    "schema",
    "uncertainty",
    "validate",
    "verify",
]


def __dir__() -> Names:
    return __all__


@command("calibrate")
def calibrate(
    campaign: Data,
    *,
    contained: bool = False,
    coverage_factor: float | None = None,
    latitude: float | None = None,
    height: float | None = None,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    between: Sequence[float] | None = None,
    rows: str = "samples",
    temperature: str | int | None = None,
    model: str | None = None,
    attitude_uncertainty: float | None = None,
    a_true_uncertainty: float | None = None,
    free_living: bool = False,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    output: Place | None = None,
    watch: Watch | None = None,
) -> Result | Any:
    """Calibrate a sensor from a campaign folder, or from one recording.

    A campaign is a folder with `campaign.toml` and the recordings it names. Its `kind` says what is calibrated:
    `multi-position`, `single-axis`, `free-living`, `shaker-triaxial`, `shaker-single`, `shaker-primary`,
    `transverse-sensitivity` or `spurious-motion`. A recording alone, with static intervals in many positions, needs
    the place (`latitude=`) or local gravity; `proofmass init` writes a campaign for it. Results go to a folder:
    result.json (everything, covariance included), report.html (one file, opens without network), calibration.json
    (what `proofmass apply` needs) and CSV tables.

    Args:
        campaign: Campaign folder, its campaign.toml, or a recording.
        contained: Refuse a campaign that names files outside of its folder: for campaigns that others made.
        coverage_factor: Shaker campaigns: coverage factor of U, such as 2; its probability is stated [default: that
            of 95 %].
        latitude: Latitude in degrees north.
        height: Height above the sea in metres [default: 300 with a standard uncertainty of 300].
        gravity: Local gravity in m/s².
        gravity_uncertainty: Its standard uncertainty in m/s².
        columns: Columns of x, y and z by name or number (from 1) [default: found by their headings].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, where there is no time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        between: Read the rows from one time on and before another, in seconds.
        rows: What a row is: a sample (static intervals are found), one reading in one position, a sample of a slow
            tumble. One of samples, readings, tumble.
        temperature: Temperature column in °C by name or number.
        model: Model: bias, bias-scale, triangular, symmetric; with given attitudes also full. One of bias,
            bias-scale, triangular, symmetric, full, six-position, ferraris, ellipsoid.
        attitude_uncertainty: Standard uncertainty of the attitudes that a table of readings gives, in degrees.
        a_true_uncertainty: Standard uncertainty of each component of the true accelerations a_true_x … of a table of
            readings, in m/s².
        free_living: Days of a logger on a wrist or a machine: calibrate from its still moments.
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        output: Folder for the results [default: none is written].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("init")
def init(
    recording: Data | None = None,
    *,
    output: Place,
    kind: str | None = None,
    latitude: float | None = None,
    height: float | None = None,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    between: Sequence[float] | None = None,
    rows: str = "samples",
    temperature: str | int | None = None,
    model: str | None = None,
    attitude_uncertainty: float | None = None,
    a_true_uncertainty: float | None = None,
    free_living: bool = False,
    watch: Watch | None = None,
) -> Path:
    """Write a commented campaign.toml for a recording, or an example of any kind.

    Columns, time and unit are filled in as far as the recording states them; the rest stands there as comments. An
    existing campaign is never replaced. With kind=, a folder gets a full example of that kind with its tables.

    Args:
        recording: Recording with static intervals in many positions.
        kind: Write an example of this kind instead, with its tables, into the folder of output=. One of
            multi-position, free-living, single-axis, shaker-triaxial, shaker-single, shaker-primary,
            transverse-sensitivity, spurious-motion.
        output: Folder for the example.
        latitude: Latitude in degrees north.
        height: Height above the sea in metres [default: 300 with a standard uncertainty of 300].
        gravity: Local gravity in m/s².
        gravity_uncertainty: Its standard uncertainty in m/s².
        columns: Columns of x, y and z by name or number (from 1) [default: found by their headings].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, where there is no time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        between: Read the rows from one time on and before another, in seconds.
        rows: What a row is: a sample (static intervals are found), one reading in one position, a sample of a slow
            tumble. One of samples, readings, tumble.
        temperature: Temperature column in °C by name or number.
        model: Model: bias, bias-scale, triangular, symmetric; with given attitudes also full. One of bias,
            bias-scale, triangular, symmetric, full, six-position, ferraris, ellipsoid.
        attitude_uncertainty: Standard uncertainty of the attitudes that a table of readings gives, in degrees.
        a_true_uncertainty: Standard uncertainty of each component of the true accelerations a_true_x … of a table of
            readings, in m/s².
        free_living: Days of a logger on a wrist or a machine: calibrate from its still moments.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("plan")
def plan(
    campaign: Data,
    *,
    best: int | None = None,
    sizes: int | str | Sequence[int] | None = None,
    frequency: float = 160,
    contained: bool = False,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result | Any:
    """Predict the uncertainties of a campaign before it is measured.

    Of a campaign of kind `shaker-triaxial` it reads budget, certificate and plan, and finds the best of fewer
    configurations; nothing needs to have been measured. The candidates are the plan of the campaign, or else the
    configurations of its runs, or else the 44 published ones.

    Of a campaign of kind `multi-position` it evaluates what there is so far, and lists the further positions that
    narrow the intervals most, and to what.

    Args:
        campaign: Campaign folder, or its campaign.toml.
        best: Choose the best N of the candidates (largest determinant).
        sizes: Numbers of configurations to compare [default: 4 to all candidates].
        frequency: Frequency whose uncertainty of the reference counts, Hz.
        contained: Refuse a campaign that names files outside of its folder: for campaigns that others made.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("apply")
def apply(
    calibration: Data,
    recording: Data,
    *,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    band: str | Sequence[float] | None = None,
    filter: bool = False,
    hold: bool = False,
    coverage_factor: float | None = None,
    temperature: str | int | None = None,
    environment: str | Sequence[str | int | float] | None = None,
    at: str | Sequence[str | int | float] | None = None,
    within_range: bool = False,
    bias: Data | None = None,
    rotate: str | None = None,
    rotate_uncertainty: str | None = None,
    low_pass: float | None = None,
    linear_phase: bool = False,
    decimate: int | None = None,
    attenuation: float | None = None,
    dynamic: bool = False,
    model: str | None = None,
    corner: float | None = None,
    quiet: float | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    watch: Watch | None = None,
) -> dict[str, np.ndarray] | Any:
    """Compensate a recording with a calibration.

    a = K⁻¹ (output − b), row by row: a recording of any size needs no more memory than a small one. All other columns
    are kept as they are. The same function runs in firmware. A calibration over frequency (from a shaker, or the
    table of a laboratory) is used through the constant matrix of a band, or through a filter; both state their error.

    Steps may follow, always in this order: a tracked bias is subtracted, the axes are turned, a low-pass runs,
    samples are left out. Their delay is stated and taken out.

    Args:
        calibration: calibration.json (of three axes or one), a result.json that holds it, the folder of either, or a
            laboratory's table (.csv) over frequency.
        recording: Recording with uncompensated outputs; `-` is standard input.
        output: File for the new recording, replaced if proofmass wrote it; `-` is standard output.
        force: Replace a file that proofmass did not write or that was changed since.
        sign: Sign where the file came from with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        band: Calibration over frequency: the constant real matrix of this band in hertz; one frequency twice is that
            alone.
        filter: Calibration over frequency: an inverse filter (whole range, or band=) Samples at either end of the
            recording, for which the filter needs others before or after, are left out.
        hold: Below and above the calibrated frequencies, take the sensitivity of the nearest one instead of filtering
            them out.
        coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        temperature: Column of the temperature in °C, for a calibration over temperature.
        environment: Column of another quantity that the calibration follows (humidity, pressure, supply voltage),
            with its unit where the heading does not say it; more than once.
        at: Value of a quantity that the calibration follows (humidity, pressure, supply voltage), in its unit there:
            bias and scale are those at this value, with their uncertainty; more than once.
        within_range: Refuse a recording with samples beyond the range in which the calibration was tested, instead of
            reporting them.
        bias: Subtract a bias that was tracked over this recording: the result.json of `proofmass bias`.
        rotate: Turn to the frame of a machine or vehicle: roll, pitch and yaw of the sensor in it, in degrees The
            frame of the machine is turned about its z axis by yaw, about its new y axis by pitch and about its new x
            axis by roll (right-handed; ISO 8855 with x forward, y to the left, z up), and is then that of the sensor.
            Or the result.json of `proofmass test mounting`, with its uncertainty.
        rotate_uncertainty: Standard uncertainties of these angles, in degrees.
        low_pass: Low-pass of all axes with this corner in hertz: a Butterworth of second order, as `proofmass filter`
            writes it.
        linear_phase: Low-pass with one delay at all frequencies, flat up to low_pass=, in place of the Butterworth.
        decimate: Keep one of M samples behind the low-pass.
        attenuation: What decimation folds into the band up to the corner must be weaker by this, in dB [default: 60].
        dynamic: Acceleration behind one channel (columns=) by the inverse of a fitted model, each sample with its
            uncertainty The calibration is then the result.json of a test with a model, or a calibration over
            frequency that model= is fitted to.
        model: Model to fit to a calibration over frequency: 1mode … 4modes, delay, low-pass=ORDER, joined by +
            [default: 1mode].
        corner: Corner of the low-pass in hertz [default: where noise and bias together are least].
        quiet: Seconds at the beginning in which nothing happens [default: up to the pulse].
        columns: Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
            `inspect` take patterns (`acc_*`) too [default: those of the calibration].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        Without an output the compensated recording comes back as arrays by heading.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("export")
def export(
    calibration: Data,
    *,
    rust: bool = False,
    c: bool = False,
    python: bool = False,
    imu_yaml: bool = False,
    memory: bool = False,
    memory_reader: bool = False,
    number: str = "float",
    band: str | Sequence[float] | None = None,
    at: str | Sequence[str | int | float] | None = None,
    rotate: str | None = None,
    rotate_uncertainty: str | None = None,
    low_pass: float | None = None,
    linear_phase: bool = False,
    decimate: int | None = None,
    attenuation: float | None = None,
    rate: float | None = None,
    method: str | None = None,
    outputs: str | None = None,
    name: str | None = None,
    output: Place | None = None,
    watch: Watch | None = None,
) -> str | Any:
    """Write a calibration as source code (C, Rust, Python), imu.yaml, JSON or the image of a memory.

    Of a result of `bias`, `velocity tune` or `velocity map` it writes the filter, the gains or the encoder map.

    Of a calibration over frequency, such as that of a shaker, it writes the constant matrix of a band with its stated
    error (band=).

    K⁻¹ is in it, so that nothing is inverted at start-up, and so are temperature and curvature where the calibration
    has them. Each of Rust, C and Python checks itself: it holds outputs with the accelerations that were computed
    here.

    Args:
        calibration: calibration.json, or result.json of a test of one axis, of `bias`, `velocity tune` or `velocity
            map`, or the folder that holds it.
        rust: Constant for the crate proofmass-core.
        c: C99 header without dependencies.
        python: Python module without dependencies.
        imu_yaml: IMU intrinsics of Kalibr (calibrations of outputs in m/s²).
        memory: Image for the memory of the device, with serial number and checksum; needs output=.
        memory_reader: C99 header that reads such images, of any device.
        number: Numbers of Rust and C. One of float, double, fixed.
        band: Calibration over frequency: the constant real matrix of this band in hertz; one frequency twice is that
            alone.
        at: Value of a quantity that the calibration follows (humidity, pressure, supply voltage), in its unit there:
            bias and scale are those at this value, with their uncertainty; more than once.
        rotate: Turn to the frame of a machine or vehicle: roll, pitch and yaw of the sensor in it, in degrees The
            frame of the machine is turned about its z axis by yaw, about its new y axis by pitch and about its new x
            axis by roll (right-handed; ISO 8855 with x forward, y to the left, z up), and is then that of the sensor.
            Or the result.json of `proofmass test mounting`, with its uncertainty.
        rotate_uncertainty: Standard uncertainties of these angles, in degrees.
        low_pass: Low-pass of all axes with this corner in hertz: a Butterworth of second order, as `proofmass filter`
            writes it.
        linear_phase: Low-pass with one delay at all frequencies, flat up to low_pass=, in place of the Butterworth.
        decimate: Keep one of M samples behind the low-pass.
        attenuation: What decimation folds into the band up to the corner must be weaker by this, in dB [default: 60].
        rate: Sampling rate in hertz, for low_pass=.
        method: Which gains of `velocity tune` [default: kalman]. One of kalman, observer, two-channel.
        outputs: Smallest and largest number out of the converter, for `number="fixed"`.
        name: Name of the constant or function [default: from the device].
        output: File to write, replaced if proofmass wrote it [default: none is written].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("filter")
def filter(
    *,
    rate: float,
    low_pass: float | None = None,
    mean: int | None = None,
    rust: bool = False,
    c: bool = False,
    number: str = "float",
    name: str | None = None,
    output: Place | None = None,
    watch: Watch | None = None,
) -> str | Any:
    """Design a low-pass filter and write it as source code (C, Rust) or JSON.

    A Butterworth low-pass of second order or a moving average, with its group delay.

    Args:
        rate: Sampling rate in hertz.
        low_pass: Butterworth of second order with this corner in hertz (−3.01 dB).
        mean: Mean of this many samples.
        rust: Constant for the crate proofmass-core.
        c: C99 header without dependencies.
        number: Numbers of Rust and C. One of float, double.
        name: Name of the constant or function [default: from the filter].
        output: File to write, replaced if proofmass wrote it [default: none is written].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("import")
def import_(
    coefficients: Data,
    *,
    form: str,
    unit: str,
    corrected_unit: str = "m/s²",
    output: Place = "calibration.json",
    watch: Watch | None = None,
) -> Path | None:
    """Make a calibration.json from the coefficients of another program.

    It can be applied and exported. These files state no uncertainty, so the calibration has none; `proofmass
    calibrate` on the same recording gives one.

    Args:
        coefficients: File with the coefficients.
        form: Form of the file. One of six-parameters, magneto, imu-tk, imucal, kalibr.
        unit: Unit of the outputs the coefficients apply to: count, m/s², g, mg, V, ….
        corrected_unit: Unit of the corrected values of Magneto, that of the norm it was given.
        output: File to write, replaced if it is there.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("validate")
def validate(
    calibration: Data,
    recording: Data,
    *,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    segments: Data | None = None,
    threshold: float = 6,
    nominal_sensitivity: float | None = None,
    nominal_zero: float = 0,
    stream: bool = False,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Check a calibration on a recording it was not made from.

    In each static interval of the recording ‖a‖ must be g: within 0.1 % each, and all together within what the
    covariance of the calibration allows (χ²). A sensor of one axis rests with its axis up or down.

    Args:
        calibration: calibration.json, or a result.json that holds it.
        recording: Recording with static intervals in any positions (up and down of one axis).
        gravity: Local gravity in m/s² where the recording was made [default: that of the calibration].
        gravity_uncertainty: Its standard uncertainty in m/s².
        segments: Table of static intervals (columns start, end) instead of searching for them.
        threshold: Largest windowed variance of a static interval, in multiples of the noise floor.
        nominal_sensitivity: Nominal output per m/s² of an uncompensated sensor, in the unit of its outputs: what
            "before" is held against [default: the mean of the three axes].
        nominal_zero: Its output at no acceleration.
        stream: Read the recording as a stream, in bounded memory [default: above some 20 million rows, or 48 MiB
            through a pipe] Of more than a million rows means stand for them, as long as these take no more than a
            quarter of a second.
        columns: Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
            `inspect` take patterns (`acc_*`) too [default: those of the calibration].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("compare")
def compare(
    calibrations: Sequence[Data] | Data,
    *,
    probability: float = 0.95,
    coverage_factor: float | None = None,
    common: str | Sequence[str | int | float] | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Compare calibrations of one device over frequency (E_n, reference value).

    Of two, E_n at each point and χ² of the whole. Of three or more, the reference value is the weighted mean of all;
    the median and the deviation of each laboratory from both are stated. Each is a calibration.json of kind
    frequency-response, the result.json of a test or calibration that gives one, the folder of either, or the table of
    a laboratory (.csv: frequency_Hz, sensitivity_V/(m/s2) or another unit, phase_deg, u_relative_% or U_relative_%
    with coverage=, u_phase_deg).

    Args:
        calibrations: Two calibrations or more; of two, differences are the first less the second.
        probability: Probability of the expanded uncertainties.
        coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        common: Of two: entries of their budgets that are one error of both, such as reference where one standard with
            one calibration is behind both.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("device check")
def device_check(
    folders: Sequence[Data] | Data,
    *,
    sheet: Data = "device.toml",
    false_alarm_rate: float = 0.01,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Judge devices by their data sheet: pass, fail, undecided or not shown, limit by limit.

    It reads every result.json in the folders and below them: what `proofmass calibrate`, `noise` and `test` wrote.
    Devices are told apart by the serial number that their results state; a result without one belongs to the device
    whose results share its folder. The rule of the decision stands in the sheet: a guard band of U where it says
    nothing.

    Args:
        folders: Folders of results, of one device or of several.
        sheet: Data sheet (TOML), with a [[limit]] for each promise.
        false_alarm_rate: Probability at which two results of one quantity that agree are said to contradict each
            other.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("device plan")
def device_plan(
    *,
    sheet: Data = "device.toml",
    noise_result: Data | None = None,
    rate: float | None = None,
    gravity_uncertainty: float | None = None,
    reference_uncertainty: float | None = None,
    temperature_range: float | str | Sequence[float] | None = None,
    axes: int = 3,
    fixture_angle: float | None = None,
    acceleration: str | int | None = None,
    wander: float = 0,
    ratio: float = 4,
    decided: float = 0.9,
    soak: float = 15,
    longest: float = 168,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Say what to measure and for how long, so that a device with its typical values is decided by its data sheet.

    Of every limit it says which command shows it, which expanded uncertainty decides it by the rule of the sheet, and
    what that takes: the length of a recording of noise, attitudes and rests, temperatures and soak, levels,
    frequencies. What has to be known for that is asked for at once.

    Args:
        sheet: Data sheet (TOML), with a [[limit]] for each promise.
        noise_result: result.json of `proofmass noise` of such a sensor [default: the typical values of N, B and K in
            the sheet].
        rate: Sampling rate of the recordings, Hz.
        gravity_uncertainty: Standard uncertainty of local gravity, m/s².
        reference_uncertainty: Standard uncertainty of the reference accelerations, of a shaker or of levels, %.
        temperature_range: Lowest and highest temperature of the device, °C, where a limit does not say it.
        axes: Axes of the device: 3, or 1 that is turned through known angles.
        fixture_angle: Standard uncertainty of the angles of a fixture for one axis (lean of its axis of turning,
            sensitive axis off the plane), °.
        acceleration: Largest acceleration of the levels for a non-linearity, m/s².
        wander: Standard deviation of what varies from attitude to attitude beside the noise, m/s².
        ratio: Tolerance-to-uncertainty ratio where a limit has no typical value.
        decided: Probability that a device with the typical value is decided.
        soak: Soak at each temperature before it counts, minutes.
        longest: Longest recording of noise, hours.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("certificate")
def certificate(
    result: Data,
    *,
    lab: Data,
    order: Data | None = None,
    language: str = "en",
    persian_digits: bool = False,
    as_found: Data | None = None,
    issued: str | None = None,
    xml: bool = False,
    pdf: bool = False,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Draft, check and release calibration certificates, and read those of others.

    From the result of a calibration and LAB.toml: laboratory, customer, item, standards. A draft has a watermark and
    no number; `release` gives it the next number of the register. The digital certificate (DCC 3.3.0) has the same
    numbers as the paper, to the digit.

    Args:
        result: result.json of a calibration, or the folder that holds it.
        lab: Laboratory, standards, numbering; what it leaves out may stand in the file of the order.
        order: Customer, item, dates of one order; its sections hold before those of LAB.toml.
        language: Language of the certificate. One of en, it, fa.
        persian_digits: Numbers of a certificate in Persian with the digits of Persian.
        as_found: The result before the item was adjusted: result.json, or the folder that holds it.
        issued: Day of issue, YYYY-MM-DD [default: today].
        xml: Print the digital certificate (DCC, XML) instead of the summary.
        pdf: Write certificate.pdf as well, by the program proofmass-certificate.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("certificate read")
def certificate_read(
    file: Data,
    *,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Show what a digital calibration certificate (DCC, XML) says.

    Versions 2.3 to 3.3. Lists of unequal length, wrong units, numbers that are not finite, frequencies that stand
    twice and a k that contradicts its probability are refused with element and line. A signature in it is not
    checked, and never called valid.

    Args:
        file: Digital calibration certificate; `-` is standard input.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("certificate check")
def certificate_check(
    result: Data,
    *,
    lab: Data,
    order: Data | None = None,
    language: str = "en",
    persian_digits: bool = False,
    as_found: Data | None = None,
    issued: str | None = None,
    watch: Watch | None = None,
) -> list[str]:
    """List what is missing to a certificate: exit code 1 where anything is.

    Args:
        result: result.json of a calibration, or the folder that holds it.
        lab: Laboratory, standards, numbering; what it leaves out may stand in the file of the order.
        order: Customer, item, dates of one order; its sections hold before those of LAB.toml.
        language: Language of the certificate. One of en, it, fa.
        persian_digits: Numbers of a certificate in Persian with the digits of Persian.
        as_found: The result before the item was adjusted: result.json, or the folder that holds it.
        issued: Day of issue, YYYY-MM-DD [default: today].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("certificate release")
def certificate_release(
    result: Data,
    *,
    lab: Data,
    output: Place,
    order: Data | None = None,
    language: str = "en",
    persian_digits: bool = False,
    as_found: Data | None = None,
    issued: str | None = None,
    pdf: bool = False,
    first: bool = False,
    replaces: str | None = None,
    reason: str | None = None,
    other_item: bool = False,
    sign: Data | None = None,
    watch: Watch | None = None,
) -> Result:
    """Release a certificate: the next number of the register, and files that are never overwritten.

    Nothing is released while anything is missing; `check` lists it. The number is entered in the register beside
    LAB.toml, which only grows. The same request again writes the same certificate under the same number.

    Args:
        result: result.json of a calibration, or the folder that holds it.
        lab: Laboratory, standards, numbering; what it leaves out may stand in the file of the order.
        output: Folder of the certificate, which must not be there yet.
        order: Customer, item, dates of one order; its sections hold before those of LAB.toml.
        language: Language of the certificate. One of en, it, fa.
        persian_digits: Numbers of a certificate in Persian with the digits of Persian.
        as_found: The result before the item was adjusted: result.json, or the folder that holds it.
        issued: Day of issue, YYYY-MM-DD [default: today].
        pdf: Write certificate.pdf as well, by the program proofmass-certificate.
        first: Begin the register: this is the first certificate of all.
        replaces: Number of the certificate that this one replaces.
        reason: Why it is replaced.
        other_item: The replaced certificate named another item, and that was what was wrong.
        sign: Sign the list of files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("certificate template")
def certificate_template(
    *,
    watch: Watch | None = None,
) -> str:
    """Print a LAB.toml to fill in: `proofmass certificate template > LAB.toml`.

    Args:
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("noise")
def noise(
    recording: Data,
    *,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    scale: float | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    phase: bool = False,
    temperature: str | int | None = None,
    statistic: str | Sequence[str | int | float] = "oadev",
    taus: str | Sequence[float] = "octave",
    detrend: str = "none",
    probability: float = 0.95,
    terms: str | Sequence[str | int | float] = "Q,N,B,K,R",
    gauss_markov: bool = False,
    sinusoids: bool = False,
    temperature_lag: float | None = None,
    no_courses: bool = False,
    robust: bool = False,
    report_terms: str | Sequence[str | int | float] | None = None,
    fix: str | Sequence[str | int | float] | None = None,
    highest_frequency: float | None = None,
    false_alarm_rate: float = 0.002,
    bias: str = "by-noise-type",
    edf: str = "published",
    noise_type: str | None = None,
    segment: int | None = None,
    windows: int = 0,
    separate: bool = False,
    refuse_gaps: bool = False,
    stream: bool = False,
    imu_yaml: Place | None = None,
    rostopic: str = "/imu0",
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Noise of a sensor at rest: Allan deviation, spectrum, N, B, K with intervals.

    Quantisation noise Q, white noise N, bias instability B, random walk K and ramp R are fitted together. Each has an
    interval that allows for all others, or, where that reaches zero, an upper limit. Steps, bursts and spikes are
    reported. With output=, a folder gets result.json (everything), report.html, tables, and imu.yaml where the
    sensors are inertial.

    Args:
        recording: Recording of a sensor at rest: delimited text of any common shape.
        columns: Columns by name or number (from 1) [default: every column that is neither time nor temperature].
        unit: Unit of these columns, where the headings do not say it: m/s², g, mg, rad/s, °/s, °/h, V, count, 1
            (fractional frequency), ….
        scale: Size of one count (or volt) in that unit, for raw outputs.
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the line through the time stamps].
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        phase: The columns hold integrals of the signal: velocities (m/s) of an accelerometer, angles of a gyroscope
            They are differenced. The unit that is stated is that of the rate.
        temperature: Column of the temperature (°C, or K or °F by its heading): its effect is fitted together with the
            noise Gives the sensitivity K_T with its interval; the effect of temperature is then not taken for B, K or
            R. An empty field keeps the last temperature.
        statistic: Statistics, the first is plotted: adev, oadev, mdev, tdev, hdev, totdev, theo1, pdev All: adev,
            oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1, theoh, pdev.
        taus: Averaging times: octave, decade, all, a number of them per decade (10/decade), or a list in seconds
            (0.1,1,10).
        detrend: Trend removed first: none, linear or quadratic.
        probability: Probability of the intervals.
        terms: Terms of the model: Q, N, B, K, R, G (Gauss–Markov), A (sinusoids); terms not named are not fitted.
        gauss_markov: Also seek first-order Gauss–Markov processes.
        sinusoids: Also seek sinusoids, from one and a half cycles in the record on.
        temperature_lag: First-order lag of the output behind the thermometer, in seconds [default: found in the
            record].
        no_courses: Take no warm-up, lasting step or cycle of the day out of the noise.
        robust: Also fit without gross outliers.
        report_terms: Terms to report with a value even where their interval reaches zero.
        fix: Coefficients that are known, in SI: held at their value.
        highest_frequency: Highest frequency of the fit in hertz [default: the highest below which no filter shows].
        false_alarm_rate: Probability that an absent term is called identified.
        bias: Correction of the biases of TOTDEV, MTOTDEV, HTOTDEV and THEO1: by-noise-type, from-record, as-defined.
        edf: Degrees of freedom of MTOTDEV and HTOTDEV: published or stable32.
        noise_type: Dominant noise type at every τ, by its exponent α from -4 to 2 [default: from the record].
        segment: Samples per segment of the Welch density [default: an eighth of the record, at most 4096].
        windows: Dynamic Allan deviation: OADEV of this number of equal windows in succession.
        separate: Noise of each of three channels side by side, without what they have in common; with phase=True, of
            clocks Groslambert covariance, which from one recording is the three-cornered hat.
        refuse_gaps: Refuse a recording with gaps instead of analysing the segments between them.
        stream: Read the recording as a stream, in bounded memory [default: above some 20 million samples, or 48 MiB
            through a pipe] Gives OADEV at octaves of all samples; spectrum, coefficients and disturbances of its
            averages.
        imu_yaml: Write imu.yaml for Kalibr and its like, units and reasons in its comments.
        rostopic: Topic written into imu.yaml.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("noise compare")
def noise_compare(
    results: Sequence[Data] | Data,
    *,
    limits: Data | None = None,
    false_alarm_rate: float = 0.01,
    temperatures: float | str | Sequence[float] | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Compare the noise of units or runs, or a batch with the limits of a data sheet.

    It reads what `proofmass noise RECORDING -o FOLDER` wrote for each of them. Channels of the same name are
    compared. With limits= a unit passes when its whole interval lies within a limit, fails when all of it lies
    beyond, and is undecided in between.

    Args:
        results: Folders (or result.json) of `proofmass noise`: two or more, or one with limits=.
        limits: Limits (TOML): [[limit]] with term = "N", most = 30.0, unit = "µg/√Hz", and where wanted meaning and
            channels.
        false_alarm_rate: Probability at which equal units are called different in any coefficient.
        temperatures: Temperature of each result in °C, in their order, of one sensor: the coefficients over the
            temperature, each with a slope and its interval.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("bias")
def bias(
    recording: Data,
    *,
    noise: Data | None = None,
    white: float | None = None,
    walk: float | None = None,
    markov: str | None = None,
    initial: float = 1,
    up: str | None = None,
    levelling: float = 0,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    latitude: float | None = None,
    height: float | None = None,
    segments: Data | None = None,
    threshold: float = 6,
    mean: float = 0.5,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Track the bias over a recording from its rests (known gravity, zero velocity).

    It is the filter that runs on the chip, with the noise of a `proofmass noise` result, and a smoother over the
    whole recording. The innovations are tested against that noise.

    Args:
        recording: Recording in g or m/s² (compensate it with `proofmass apply` first).
        noise: result.json of `proofmass noise` of the same sensor.
        white: White noise in (m/s²)/√Hz (two-sided, the Allan deviation at 1 s), in place of a noise result.
        walk: Random walk of the bias in (m/s²)·√Hz; 0 for a constant.
        markov: Gauss–Markov bias: standard deviation in m/s² and correlation time in s.
        initial: Standard uncertainty of the bias before the first rest, in m/s².
        up: Direction that points up at rest: +x … -z, X,Y,Z in the frame of the sensor, or `none` for readings free
            of gravity [default: from the table of segments].
        levelling: Standard uncertainty of that direction, in degrees.
        gravity: Local gravity in m/s² [default: standard gravity, 9.80665].
        gravity_uncertainty: Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers
            the ground].
        latitude: Latitude of the place in degrees north: normal gravity there, in the place of gravity=.
        height: Height of the place above the sea in metres [default: 300 with a standard uncertainty of 300].
        segments: Table of rests (columns start, end; up_x, up_y, up_z or direction) instead of searching for them.
        threshold: Largest windowed variance of a rest, in multiples of the noise floor.
        mean: Length of the means that the filter uses, in seconds.
        columns: Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
            `inspect` take patterns (`acc_*`) too [default: those of the calibration].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("modes")
def modes(
    wedge: Data,
    beside: Data | None = None,
    *,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Natural frequencies and mode shapes of a wedge, by finite elements.

    The file gives a wedge by its dimensions or names a Gmsh mesh, and states its support. Results: frequencies with
    their intervals, deformed shapes, the spurious motion (spurious.csv, in the form of a vibrometer's table),
    modes.vtu for ParaView. With [search], the shape whose first relevant mode is highest, or whose gluing point moves
    least. With two files, both in one report.

    Args:
        wedge: Description of the fixture, a TOML file.
        beside: Another fixture, which stands beside it in the report.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("inspect")
def inspect(
    file: Data,
    *,
    damage: bool = False,
    plot: Place | None = None,
    force: bool = False,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Show what is in a recording: columns, units, rate, gaps, ranges, statistics.

    Of the calibration memory of a device, as `export memory=` writes it, it shows the coefficients.

    Args:
        file: Delimited text or a format that `proofmass formats` lists, plain or packed with gzip or zstd; `-` is
            standard input.
        damage: List every damaged place, up to ten thousand, instead of the first.
        plot: Write a page with a picture of the signals, a panel for each unit.
        force: Replace the file of plot=.
        columns: Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
            `inspect` take patterns (`acc_*`) too [default: those of the calibration].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("formats")
def formats(
    *,
    watch: Watch | None = None,
) -> list[dict[str, Any]]:
    """List the formats of recordings that are known by their content: which are read, how far, which `convert` writes,
    and what to do with the others.

    Args:
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("convert")
def convert(
    recordings: Sequence[Data] | Data | None = None,
    *,
    output: Place,
    devices: Data | None = None,
    force: bool = False,
    sign: Data | None = None,
    to: str | None = None,
    wav_form: str | None = None,
    gaps: str | None = None,
    without_units: bool = False,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    watch: Watch | None = None,
) -> Path:
    """Write recordings in another format: CSV, npy, WAV, UFF 58b or Parquet.

    Numbers stay in their units. Every column of numbers is written where columns= names none. Several recordings that
    continue each other become one; with devices=, recordings of many devices become one table with columns of serial
    number and batch. They are read more than once, in blocks: memory is that of a block, for Parquet that of two
    million numbers. What the format has no place for is refused until it is said what becomes of it, and what is lost
    is listed.

    Args:
        recordings: Recordings, in the order of their times.
        output: File for the new recording, replaced if proofmass wrote it; `-` is standard output.
        devices: Table (columns file, serial, batch) of recordings of many devices, its names relative to its folder:
            they become one Parquet table with columns of these.
        force: Replace a file that proofmass did not write or that was changed since.
        sign: Sign where the file came from with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        to: Format to be written [default: by the ending of the output: .csv, .npy, .wav, .uff, .parquet]. One of csv,
            npy, wav, uff, parquet.
        wav_form: How a WAV file stores its samples [default: float64]. One of int16, int24, int32, float32, float64.
        gaps: What becomes of gaps; without it they stay in csv, npy and parquet, whose rows have times, and are
            refused for wav and uff. One of hold, nan, close.
        without_units: Write numbers whose units are known into a format that has no place for units (npy, wav).
        columns: Columns of the outputs (x, y and z of a triaxial sensor) by name or number (from 1); `convert` and
            `inspect` take patterns (`acc_*`) too [default: those of the calibration].
        unit: Unit of these columns, where the headings do not say it: count, m/s², g, mg, V, ….
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("render")
def render(
    result: Data,
    *,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Show a result, or write its report and tables, from result.json alone.

    The recordings are not needed: quantities, plots and findings stand in the result. The same version writes the
    same files, byte by byte.

    Args:
        result: result.json, or the folder that holds it.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("explain")
def explain(
    code: str | None = None,
    *,
    watch: Watch | None = None,
) -> Any:
    """Explain a finding or an error by its code, or a word of the field.

    Without a word, the codes of all findings are listed.

    Args:
        code: Code of a finding, as results show it (`gaps-in-record`), or of an error (`column`), or a word
            (`bias-instability`, VRW, SRS).
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("uncertainty")
def uncertainty(
    model: Data,
    *,
    method: str | None = None,
    probability: float = 0.95,
    coverage_factor: float | None = None,
    digits: int = 2,
    check_digits: int = 1,
    trials: int | None = None,
    seed: int = 1,
    effects: bool = False,
    sweep: str | Sequence[str | int | float] | None = None,
    target: str | Sequence[str | int | float] | None = None,
    draws: Place | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Evaluate the uncertainty of a measurement from its equations (GUM).

    The model file states formulas, inputs and their distributions. The result is computed by the law of propagation
    of uncertainty (with budget and effective degrees of freedom) and by Monte Carlo, which shows whether the first
    may be used. A model file:

        [[input]]
        name = "U"
        unit = "V"
        value = 5.0
        u = 0.01

        [[input]]
        name = "I"
        unit = "A"
        observations = [0.01997, 0.02002, 0.02001]

        [[output]]
        name = "R"
        unit = "Ω"
        expression = "U / I"

    Args:
        model: Model file (TOML).
        method: Method that states the result: auto is the law of propagation where Monte Carlo does not contradict it
            [default: that of the model file, auto where it says none]. One of auto, linear, second-order,
            monte-carlo.
        probability: Coverage probability of the intervals, between 0 and 1.
        coverage_factor: Coverage factor of the result, such as 2 [default: from the probability and the degrees of
            freedom].
        digits: Significant digits of u that are printed.
        check_digits: Significant digits of u to which both methods must agree.
        trials: Monte Carlo trials, rounded up to whole blocks [default: until the digits are stable, 5 000 000 at
            most].
        seed: Seed of the random numbers: the same seed gives the same result.
        effects: Budget by Monte Carlo for every output, not only where the linear result is not validated.
        sweep: State the outputs also for STEPS estimates of an input, such as T=10:30:21; may be given again.
        target: Say which u of each input alone would bring an output to this U, such as y=0.5; may be given again.
        draws: Write the Monte Carlo trials to this file (CSV), a column per output.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("verify")
def verify(
    result: Data,
    *,
    data: Data | None = None,
    key: Sequence[Data] | Data | None = None,
    watch: Watch | None = None,
) -> dict[str, Any]:
    """Check by digests that a result and the files behind it are unchanged.

    From a folder of results, a result.json, a calibration.json or a recording that `proofmass apply` wrote, back to
    the raw recordings as far as they are found. Ends with exit code 1 where a file was changed or is missing, a
    signature does not hold, or, with key=, a list of files is not signed by one of the keys.

    Args:
        result: Folder of results, result.json, calibration.json or compensated recording.
        data: Folder in which inputs are looked for that are not where they were.
        key: Public key that must have signed every list of files (PEM, Ed25519); may be given several times.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("keygen")
def keygen(
    name: Place,
    *,
    watch: Watch | None = None,
) -> str:
    """Make a pair of keys to sign results with.

    NAME.key signs results (`sign=`), NAME.pub verifies them (`proofmass verify --key`). Ed25519 in the PEM form of
    OpenSSL. The private key is not encrypted: keep it where only you can read it. A key is never replaced.

    Args:
        name: Path of both files, without ending.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("schema")
def schema(
    kind: str | None = None,
    *,
    watch: Watch | None = None,
) -> Result:
    """Print the JSON schema (draft 2020-12) of a file or a request, or list them.

    Editors complete and mark the keys of a campaign.toml whose first line names its schema, as `proofmass init`
    writes it: `#:schema ADDRESS`. Without a network put the schema beside it: `proofmass schema multi-position >
    schema.json`, and `#:schema ./schema.json`.

    Args:
        kind: Kind of a campaign, another file, or a job with `-request` behind it; none for the list. One of
            campaign, multi-position, free-living, single-axis, shaker-triaxial, shaker-single, shaker-primary,
            transverse-sensitivity, spurious-motion, budget, modes, model, limits, laboratory, result, calibration,
            manifest, provenance, request, multi-position-request, free-living-request, shaker-triaxial-request,
            shaker-single-request, shaker-primary-request, transverse-sensitivity-request, spurious-motion-request,
            plan-request, validation-request, apply-request, convert-request, inspect-request, noise-request,
            noise-comparison-request, device-check-request, device-plan-request, velocity-estimate-request,
            velocity-compare-request, velocity-tune-request, velocity-map-request, velocity-drift-request,
            velocity-integrator-request, temperature-request, bias-request, static-test-request, simulate-request,
            uncertainty-request, modes-request, shock-request, response-request, transducer-model-request,
            step-request, levels-request, motion-request, comparison-request, certificate-request,
            deconvolution-request.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError
