"""Tests of accelerometers: static, thermal, dynamic.

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

from collections.abc import Sequence

from ._command import command
from ._result import Result
from ._types import Data, Names, Place, Watch

__all__ = [
    "centrifuge",
    "deconvolve",
    "impact",
    "levels",
    "linearity",
    "model",
    "motion",
    "mounting",
    "orthogonality",
    "random",
    "sensitivity",
    "shock",
    "stability",
    "step",
    "steps",
    "sweep",
    "temperature",
    "tilt",
    "zero_g",
]


def __dir__() -> Names:
    return __all__


@command("test temperature")
def temperature(
    recording: Data,
    *,
    temperature: str | int,
    environment: str | Sequence[str | int | float] | None = None,
    calibration: Data | None = None,
    reference: str | int | None = None,
    order: int = 3,
    warm_up: float | None = None,
    tilt: float | None = None,
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
    """Temperature coefficients of a resting accelerometer.

    From plateaus or a continuous sweep: slopes and polynomials per axis with one joint covariance, and hysteresis
    where the sensor was heated and cooled. A change of position during the sweep is reported, and refused where it
    leaves nothing to conclude from. With calibration=, the result holds that calibration with the coefficients in it.

    Args:
        recording: Recording with outputs and temperature.
        temperature: Column of the temperature in °C, by name or number (from 1).
        environment: Column of another quantity of the surroundings (humidity, pressure, supply voltage), with its
            unit where the heading does not say it, and the value at which its coefficients change nothing [default:
            the middle]; more than once.
        calibration: Calibration at one temperature that is to get the coefficients.
        reference: Reference temperature in °C [default: that of the calibration, else the middle of the range].
        order: Largest power of the temperature.
        warm_up: The sensor was switched on when the recording began: fit its self-heating, with a time constant up to
            this many seconds.
        tilt: Where the recording was interrupted while the temperature changed: standard uncertainty, in degrees, of
            how the sensor was kept in its attitude [default: any tilt that the outputs leave possible].
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


@command("test tilt")
def tilt(
    table: Data,
    *,
    output_column: str | int,
    angle: str,
    output_unit: str | None = None,
    temperature: str | int | None = None,
    uncertainty_column: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    zero_uncertainty: float = 0,
    full_scale: float | None = None,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    latitude: float | None = None,
    height: float | None = None,
    watch: Watch | None = None,
) -> Result:
    """Bias, sensitivity, misalignment of one axis turned through known angles.

    Args:
        table: Table of readings, one line each.
        output_column: Column of the outputs, by name or number (from 1).
        angle: Column of the angle between the axis and the vertical, in degrees unless its heading says rad.
        output_unit: Unit of the outputs, where the heading does not say it.
        temperature: Column of temperatures in °C.
        uncertainty_column: Column of standard uncertainties of the outputs, which weigh the readings; only their
            ratios count.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        zero_uncertainty: Standard uncertainty of the zero of the angles, in degrees.
        full_scale: Full scale of the output in its unit [default: twice its largest deviation from the bias].
        gravity: Local gravity in m/s² [default: standard gravity, 9.80665].
        gravity_uncertainty: Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers
            the ground].
        latitude: Latitude of the place in degrees north: normal gravity there, in the place of gravity=.
        height: Height of the place above the sea in metres [default: 300 with a standard uncertainty of 300].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test sensitivity")
def sensitivity(
    table: Data,
    *,
    output_column: str | int,
    position: str,
    output_unit: str | None = None,
    temperature: str | int | None = None,
    uncertainty_column: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    levelling: float = 0,
    reading_uncertainty: float | None = None,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    latitude: float | None = None,
    height: float | None = None,
    watch: Watch | None = None,
) -> Result:
    """Sensitivity and bias of one axis up and down.

    S = (V₊ − V₋)/2g and b = (V₊ + V₋)/2.

    Args:
        table: Table of readings, one line each.
        output_column: Column of the outputs, by name or number (from 1).
        position: Column of the position: 1 up, -1 down.
        output_unit: Unit of the outputs, where the heading does not say it.
        temperature: Column of temperatures in °C.
        uncertainty_column: Column of standard uncertainties of the outputs, which weigh the readings; only their
            ratios count.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        levelling: Standard uncertainty of the levelling, in degrees.
        reading_uncertainty: Standard uncertainty of one reading in its unit, where each position is read once.
        gravity: Local gravity in m/s² [default: standard gravity, 9.80665].
        gravity_uncertainty: Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers
            the ground].
        latitude: Latitude of the place in degrees north: normal gravity there, in the place of gravity=.
        height: Height of the place above the sea in metres [default: 300 with a standard uncertainty of 300].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test zero-g")
def zero_g(
    recording: Data,
    *,
    up: str = "z",
    levelling: float = 0,
    gravity: float | None = None,
    gravity_uncertainty: float | None = None,
    latitude: float | None = None,
    height: float | None = None,
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
    """Bias of a triaxial sensor at rest on a level surface.

    Args:
        recording: Recording of three axes at rest.
        up: Axis that points up. One of x, y, z.
        levelling: Standard uncertainty of the levelling, in degrees.
        gravity: Local gravity in m/s² [default: standard gravity, 9.80665].
        gravity_uncertainty: Its standard uncertainty in m/s² [default: 0.03 without a stated gravity, which covers
            the ground].
        latitude: Latitude of the place in degrees north: normal gravity there, in the place of gravity=.
        height: Height of the place above the sea in metres [default: 300 with a standard uncertainty of 300].
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


@command("test orthogonality")
def orthogonality(
    calibration: Data,
    *,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Angles between the sensitive axes of a calibration.

    Args:
        calibration: calibration.json written by `proofmass calibrate`.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test linearity")
def linearity(
    table: Data,
    *,
    output_column: str | int,
    acceleration: str | int,
    output_unit: str | None = None,
    temperature: str | int | None = None,
    uncertainty_column: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    scale_uncertainty: float = 0,
    full_scale: float | None = None,
    order: int = 3,
    watch: Watch | None = None,
) -> Result:
    """Bias, sensitivity and curvature of one axis at known accelerations.

    Also the temperature coefficient, where the table has temperatures. The order is chosen by the data.

    Args:
        table: Table of readings, one line each.
        output_column: Column of the outputs, by name or number (from 1).
        acceleration: Column of the accelerations, in m/s² unless its heading says g.
        output_unit: Unit of the outputs, where the heading does not say it.
        temperature: Column of temperatures in °C.
        uncertainty_column: Column of standard uncertainties of the outputs, which weigh the readings; only their
            ratios count.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        scale_uncertainty: Relative standard uncertainty of all accelerations together, in per cent.
        full_scale: Full scale in m/s² [default: the largest acceleration].
        order: Largest order.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test centrifuge")
def centrifuge(
    table: Data,
    *,
    output_column: str | int,
    speed: str,
    radius: float,
    output_unit: str | None = None,
    temperature: str | int | None = None,
    uncertainty_column: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    radius_uncertainty: float = 0,
    speed_uncertainty: float = 0,
    stretch: float = 0,
    stretch_uncertainty: float = 0,
    misalignment: float = 0,
    inclination: float = 0,
    full_scale: float | None = None,
    watch: Watch | None = None,
) -> Result:
    """Sensitivity and curvature of one axis on a rotating arm, at many g.

    Radius, speed, elongation of the arm and alignment are in the budget.

    Args:
        table: Table of readings, one line each.
        output_column: Column of the outputs, by name or number (from 1).
        speed: Column of the speeds, in r/min unless its heading says rad/s.
        radius: Radius of the proof mass at rest, in m.
        output_unit: Unit of the outputs, where the heading does not say it.
        temperature: Column of temperatures in °C.
        uncertainty_column: Column of standard uncertainties of the outputs, which weigh the readings; only their
            ratios count.
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        radius_uncertainty: Its standard uncertainty, in m.
        speed_uncertainty: Relative standard uncertainty of all speeds together, in per cent.
        stretch: Relative elongation of the arm per squared speed, in s².
        stretch_uncertainty: Its standard uncertainty, in s².
        misalignment: Standard uncertainty of the angle between axis and radius, in degrees.
        inclination: Standard uncertainty of the inclination of the axis against the horizontal, in degrees.
        full_scale: Full scale in m/s² [default: the largest acceleration].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test stability")
def stability(
    results: Sequence[Data] | Data,
    *,
    tolerance: str | Sequence[str | int | float] | None = None,
    longest_interval: float = 12,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Drift of calibration results over months, and when the next one is due.

    Args:
        results: result.json of three or more calibrations of one device.
        tolerance: Largest tolerated change of a quantity in its unit, such as bias.x=0.01; may be repeated.
        longest_interval: Longest time between calibrations, in months.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test mounting")
def mounting(
    recording: Data,
    *,
    rest: str,
    forward: str | Sequence[str | int | float] | None = None,
    braking: str | Sequence[str | int | float] | None = None,
    levelling: float = 0,
    bias_uncertainty: float = 0,
    straightness: float = 0,
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
    """Roll, pitch and yaw of a sensor on a vehicle or machine, by a rest and straight accelerations.

    Gravity at rest tells the vertical, accelerations on a straight line the direction of travel. `apply` and `export`
    take the result: `rotate=FOLDER/result.json`.

    Args:
        recording: Recording of three axes, compensated.
        rest: Rest on level ground, in seconds.
        forward: Acceleration forward on a straight line, in seconds; may be given several times.
        braking: Braking, or acceleration backward, on a straight line, in seconds; may be given several times.
        levelling: Standard uncertainty of the level of the ground at rest, in degrees.
        bias_uncertainty: Standard uncertainty of the bias of each axis, m/s².
        straightness: Standard uncertainty of the direction of travel in the frame of the machine, in degrees.
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


@command("test random")
def random(
    recording: Data,
    *,
    segment: int | None = None,
    estimator: str | None = None,
    noise_ratio: float | None = None,
    required: str | None = None,
    resolution: float | None = None,
    input: str | int | None = None,
    input_unit: str | None = None,
    input_uncertainty: float = 0,
    output_column: str | int | None = None,
    output_unit: str | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    band: str | Sequence[float] | None = None,
    reference_frequency: float | None = None,
    model: str | None = None,
    standard: Data | None = None,
    standard_coverage_factor: float | None = None,
    standard_axis: str | None = None,
    standard_model: str | None = None,
    accept_unchecked_signature: str | None = None,
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
    """Frequency response (FRF) from random excitation: H1, H2 or Hv.

    With coherence, 95 % intervals, resonances, bandwidths and a fitted model.

    Args:
        recording: Recording of input and output.
        segment: Samples per segment [default: by the record].
        estimator: Where the noise is: on the output (h1), on the input (h2), on both (hv) [default: h1, with U for
            noise on either]. One of h1, h2, hv.
        noise_ratio: Ratio of the densities of output noise to input noise, for hv, in the square of the unit of the
            response.
        required: Spectrum that is required of the input: a table (.csv, .toml) or the word of a published one, as of
            `test motion`.
        resolution: Distance of the lines of that spectrum in hertz [default: 5, or half of its lowest frequency].
        input: Column of the input (reference acceleration, force; volts with standard=), by name or number (from 1)
            [default: the first of two beside the time].
        input_unit: Unit of the input, where the heading does not say it: m/s², g, N, ….
        input_uncertainty: Relative standard uncertainty of the input, in per cent, common to all frequencies.
        output_column: Column of the device [default: the other one].
        output_unit: Unit of the output, where the heading does not say it.
        columns: Columns of input and output in one: input= and output_column=.
        unit: Unit of both columns, or one of each as UNIT,UNIT, where the headings do not say it.
        band: Lowest and highest frequency in hertz.
        reference_frequency: Frequency in hertz to whose modulus bandwidths refer [default: the lowest].
        model: Model to fit: elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +.
        standard: Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a
            table .csv, a digital certificate .xml).
        standard_coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        standard_axis: Axis of a calibration of several.
        standard_model: Model that is fitted to the calibration and stands for its points, such as 1mode+delay.
        accept_unchecked_signature: Number of a digital certificate that is taken although nobody checked the
            signature in it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
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


@command("test impact")
def impact(
    recordings: Sequence[Data] | Data,
    *,
    segment: int | None = None,
    force_window: int | None = None,
    estimator: str | None = None,
    noise_ratio: float | None = None,
    input: str | int | None = None,
    input_unit: str | None = None,
    input_uncertainty: float = 0,
    output_column: str | int | None = None,
    output_unit: str | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    band: str | Sequence[float] | None = None,
    reference_frequency: float | None = None,
    model: str | None = None,
    standard: Data | None = None,
    standard_coverage_factor: float | None = None,
    standard_axis: str | None = None,
    standard_model: str | None = None,
    accept_unchecked_signature: str | None = None,
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
    """Frequency response (FRF) from impacts of a hammer.

    One or several impacts to a recording; double and incomplete ones are left out.

    Args:
        recordings: Recordings of force and response.
        segment: Samples of each impact [default: up to the next one].
        force_window: Samples to either side of the greatest force that are kept of the force [default: all].
        estimator: Where the noise is: on the output (h1), on the input (h2), on both (hv) [default: h1, with U for
            noise on either]. One of h1, h2, hv.
        noise_ratio: Ratio of the densities of output noise to input noise, for hv.
        input: Column of the input (reference acceleration, force; volts with standard=), by name or number (from 1)
            [default: the first of two beside the time].
        input_unit: Unit of the input, where the heading does not say it: m/s², g, N, ….
        input_uncertainty: Relative standard uncertainty of the input, in per cent, common to all frequencies.
        output_column: Column of the device [default: the other one].
        output_unit: Unit of the output, where the heading does not say it.
        columns: Columns of input and output in one: input= and output_column=.
        unit: Unit of both columns, or one of each as UNIT,UNIT, where the headings do not say it.
        band: Lowest and highest frequency in hertz.
        reference_frequency: Frequency in hertz to whose modulus bandwidths refer [default: the lowest].
        model: Model to fit: elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +.
        standard: Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a
            table .csv, a digital certificate .xml).
        standard_coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        standard_axis: Axis of a calibration of several.
        standard_model: Model that is fitted to the calibration and stands for its points, such as 1mode+delay.
        accept_unchecked_signature: Number of a digital certificate that is taken although nobody checked the
            signature in it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
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


@command("test sweep")
def sweep(
    recording: Data,
    *,
    smoothing: int | None = None,
    input: str | int | None = None,
    input_unit: str | None = None,
    input_uncertainty: float = 0,
    output_column: str | int | None = None,
    output_unit: str | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    band: str | Sequence[float] | None = None,
    reference_frequency: float | None = None,
    model: str | None = None,
    standard: Data | None = None,
    standard_coverage_factor: float | None = None,
    standard_axis: str | None = None,
    standard_model: str | None = None,
    accept_unchecked_signature: str | None = None,
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
    """Frequency response (FRF) from a swept sine, linear or logarithmic.

    By local polynomials over the whole record.

    Args:
        recording: Recording of input and output.
        smoothing: Lines of the record joined to one of the result.
        input: Column of the input (reference acceleration, force; volts with standard=), by name or number (from 1)
            [default: the first of two beside the time].
        input_unit: Unit of the input, where the heading does not say it: m/s², g, N, ….
        input_uncertainty: Relative standard uncertainty of the input, in per cent, common to all frequencies.
        output_column: Column of the device [default: the other one].
        output_unit: Unit of the output, where the heading does not say it.
        columns: Columns of input and output in one: input= and output_column=.
        unit: Unit of both columns, or one of each as UNIT,UNIT, where the headings do not say it.
        band: Lowest and highest frequency in hertz.
        reference_frequency: Frequency in hertz to whose modulus bandwidths refer [default: the lowest].
        model: Model to fit: elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +.
        standard: Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a
            table .csv, a digital certificate .xml).
        standard_coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        standard_axis: Axis of a calibration of several.
        standard_model: Model that is fitted to the calibration and stands for its points, such as 1mode+delay.
        accept_unchecked_signature: Number of a digital certificate that is taken although nobody checked the
            signature in it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
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


@command("test steps")
def steps(
    recordings: Sequence[Data] | Data,
    *,
    input: str | int | None = None,
    input_unit: str | None = None,
    input_uncertainty: float = 0,
    output_column: str | int | None = None,
    output_unit: str | None = None,
    columns: str | Sequence[str | int | float] | None = None,
    unit: str | None = None,
    band: str | Sequence[float] | None = None,
    reference_frequency: float | None = None,
    model: str | None = None,
    standard: Data | None = None,
    standard_coverage_factor: float | None = None,
    standard_axis: str | None = None,
    standard_model: str | None = None,
    accept_unchecked_signature: str | None = None,
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
    """Frequency response (FRF) from a stepped sine.

    The steps are found, and a sine is fitted to both channels in each. One recording with all steps, or one for each
    frequency. A step holds at least twelve periods; its first three tenths are left out while the device settles.

    Args:
        recordings: Recordings of input and output.
        input: Column of the input (reference acceleration, force; volts with standard=), by name or number (from 1)
            [default: the first of two beside the time].
        input_unit: Unit of the input, where the heading does not say it: m/s², g, N, ….
        input_uncertainty: Relative standard uncertainty of the input, in per cent, common to all frequencies.
        output_column: Column of the device [default: the other one].
        output_unit: Unit of the output, where the heading does not say it.
        columns: Columns of input and output in one: input= and output_column=.
        unit: Unit of both columns, or one of each as UNIT,UNIT, where the headings do not say it.
        band: Lowest and highest frequency in hertz.
        reference_frequency: Frequency in hertz to whose modulus bandwidths refer [default: the lowest].
        model: Model to fit: elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +.
        standard: Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a
            table .csv, a digital certificate .xml).
        standard_coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        standard_axis: Axis of a calibration of several.
        standard_model: Model that is fitted to the calibration and stands for its points, such as 1mode+delay.
        accept_unchecked_signature: Number of a digital certificate that is taken although nobody checked the
            signature in it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
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


@command("test shock")
def shock(
    recording: Data,
    *,
    column: str | int | None = None,
    unit: str | None = None,
    sensitivity: str | None = None,
    sensitivity_uncertainty: float | None = None,
    reference: str | int | None = None,
    reference_unit: str | None = None,
    reference_uncertainty: float = 0,
    frequencies: str | Sequence[float] | None = None,
    per_octave: int = 12,
    quality: float = 10,
    peaks: str = "at-samples",
    nominal: str | None = None,
    nominal_peak: float | None = None,
    nominal_duration: float | None = None,
    band: str | Sequence[float] = "20",
    velocity_band: float = 15,
    required_spectrum: Data | None = None,
    spectrum_band: str = "-1.5,3",
    spectrum_rest: str = "-3,6",
    return_band: float | None = None,
    standard: Data | None = None,
    standard_coverage_factor: float | None = None,
    standard_axis: str | None = None,
    standard_model: str | None = None,
    accept_unchecked_signature: str | None = None,
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
    """Peak, duration, velocity change and response spectrum (SRS) of a shock.

    With reference=, the sensitivity of the output by peak, by integral and by spectrum (ISO 16063-13, -22), each with
    its interval. Pulses that are cut off, doubled, saturated, shifted or ringing are reported. With output=, a folder
    gets result.json, report.html and tables.

    Args:
        recording: Recording with the shock.
        column: Column of the device, by name or number (from 1) [default: the only one that is left].
        unit: Unit of the column, where the heading does not say it: V, mV, count, m/s², g, ….
        sensitivity: What makes m/s² of volts or counts: "0.5 mV/(m/s²)", "16384 LSB/g", ….
        sensitivity_uncertainty: Relative standard uncertainty of the sensitivity, in per cent.
        reference: Column of the reference acceleration, or of its volts with standard=.
        reference_unit: Unit of the reference, where the heading does not say it: m/s², g, ….
        reference_uncertainty: Relative standard uncertainty of the reference, or of the one channel where there is
            none, in per cent.
        frequencies: Natural frequencies of the spectrum in hertz: LOW,HIGH [default: by duration and rate].
        per_octave: Natural frequencies to the octave.
        quality: Quality factor of the oscillators, 1/(2ζ).
        peaks: Extremes at the samples (ISO 18431-4) or also between them. One of at-samples, between-samples.
        nominal: Nominal pulse for the tolerance band. One of half-sine, haversine, terminal-peak-sawtooth, trapezoid.
        nominal_peak: Its peak in m/s².
        nominal_duration: Its duration in seconds.
        band: Half-width of the band in per cent of the nominal peak.
        velocity_band: Largest deviation of the velocity change in per cent.
        required_spectrum: Shock response spectrum that is required, a table of frequency_Hz and acceleration_m/s2 (or
            _g) [default: that of the nominal pulse].
        spectrum_band: Band about it in decibels, at nine tenths of the frequencies (MIL-STD-810, method 516).
        spectrum_rest: Band for the others.
        return_band: Half-width of the band about the baseline before the pulse into which the device returns, in m/s²
            or the unit of its output [default: what the noise before the pulse gives].
        standard: Calibration over frequency of the reference transducer, whose channel is then in volts (.json, a
            table .csv, a digital certificate .xml).
        standard_coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a laboratory.
        standard_axis: Axis of a calibration of several.
        standard_model: Model that is fitted to the calibration and stands for its points, such as 1mode+delay.
        accept_unchecked_signature: Number of a digital certificate that is taken although nobody checked the
            signature in it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
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


@command("test step")
def step(
    recording: Data,
    *,
    column: str | int | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    sensitivity: str | None = None,
    sensitivity_uncertainty: float | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Step response: natural frequency, damping, rise time, overshoot, settling.

    Args:
        recording: Recording of the step, from before it until the device has settled.
        column: Column of the sensor, by name or number (from 1) [default: the only one beside the time].
        unit: Unit of the column, where the heading does not say it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        sensitivity: What makes m/s² of volts or counts: "0.5 mV/(m/s²)", "16384 LSB/g", ….
        sensitivity_uncertainty: Relative standard uncertainty of the sensitivity, in per cent.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test motion")
def motion(
    recording: Data,
    *,
    column: str | int | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    sensitivity: str | None = None,
    sensitivity_uncertainty: float | None = None,
    uncertainty: float = 0,
    baseline: str = "none",
    gravity: float = 9.80665,
    damping: float = 5,
    periods: float | str | Sequence[float] | None = None,
    required: str | None = None,
    resolution: float | None = None,
    full_scale: float | None = None,
    vibration_band: str = "10,1000",
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Velocity, displacement, response spectrum, machine vibration of a record.

    Args:
        recording: Recording with the acceleration.
        column: Column of the sensor, by name or number (from 1) [default: the only one beside the time].
        unit: Unit of the column, where the heading does not say it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        sensitivity: What makes m/s² of volts or counts: "0.5 mV/(m/s²)", "16384 LSB/g", ….
        sensitivity_uncertainty: Relative standard uncertainty of the sensitivity, in per cent.
        uncertainty: Relative standard uncertainty of the acceleration, in per cent, from the sensor's calibration.
        baseline: What is removed before integration: none, mean, before=SECONDS, velocity=DEGREE.
        gravity: Gravity of intensity and bracketed duration in m/s².
        damping: Damping ratio of the response spectrum, in per cent.
        periods: Periods of the response spectrum in seconds [default: a hundred].
        required: Spectrum that is required: a table (.csv, .toml) or navmat-p-9492, gevs-qualification,
            gevs-acceptance, mil-std-810-minimum-integrity.
        resolution: Distance of the lines of that spectrum in hertz [default: 5, or half of its lowest frequency].
        full_scale: Full scale of the sensor to either side in m/s², or in g as 2g: samples there are cut off.
        vibration_band: Band of the vibration velocity in hertz.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("test model")
def model(
    table: Data,
    *,
    model: str = "1mode",
    frequency: str | None = None,
    modulus: str | None = None,
    modulus_u: str | None = None,
    phase: str | None = None,
    phase_u: str | None = None,
    phase_unit: str | None = None,
    unit: str | None = None,
    reference_uncertainty: float = 0,
    band: str | Sequence[float] | None = None,
    reference_frequency: float | None = None,
    coverage_factor: float | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Fit a model (modes, delay, filters) to a frequency response.

    The response is a calibration.json or a table of points. A model that does not fit is reported. A table needs its
    five columns named; without them the file is read as a calibration of kind frequency-response, or as the table of
    a certificate (.csv: frequency, sensitivity, phase, uncertainties).

    Args:
        table: Table with a line for each point, or calibration.json of kind frequency-response.
        model: Elements of 1mode … 4modes, high-pass, delay, low-pass=ORDER, joined by +.
        frequency: Column of the frequency in hertz.
        modulus: Column of the modulus.
        modulus_u: Column of its standard uncertainty.
        phase: Column of the phase.
        phase_u: Column of its standard uncertainty.
        phase_unit: Unit of phase and its uncertainty, where the headings do not say it [default: rad]. One of rad,
            deg.
        unit: Unit of the modulus, where the heading does not say it: V/(m/s2), mV/g, count/g, …; 1 for a pure number.
        reference_uncertainty: Relative standard uncertainty of the reference, in per cent, common to all points.
        band: Lowest and highest frequency in hertz.
        reference_frequency: Frequency in hertz to whose modulus bandwidths refer [default: the lowest].
        coverage_factor: Coverage factor of the expanded uncertainties (U_…) in the table of a certificate.
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


@command("test levels")
def levels(
    table: Data,
    *,
    level: str,
    output_column: str | int,
    output_u: str,
    level_unit: str | None = None,
    output_unit: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Linearity over the amplitude at one frequency.

    Sensitivity, amplitude coefficient, largest deviation from a straight line.

    Args:
        table: Table with a line for each level.
        level: Column of the level (amplitude of the acceleration), by name or number (from 1).
        output_column: Column of the amplitude of the output.
        output_u: Column of its standard uncertainty.
        level_unit: Its unit, where the heading does not say it.
        output_unit: Its unit and that of its uncertainty, where the headings do not say it.
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


@command("test deconvolve")
def deconvolve(
    result: Data,
    recording: Data,
    *,
    column: str | int | None = None,
    unit: str | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    between: Sequence[float] | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    model: str | None = None,
    corner: float | None = None,
    quiet: float | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Acceleration behind an output, each sample with its uncertainty.

    The model is that of `proofmass test random|impact|sweep --model …` or `proofmass test model`, with its
    covariance; `proofmass apply --dynamic` writes the same values as a recording.

    Args:
        result: result.json with a fitted model, or its folder; or a calibration over frequency (calibration.json,
            table of a laboratory).
        recording: Recording of the device.
        column: Column of the sensor, by name or number (from 1) [default: the only one beside the time].
        unit: Unit of the column, where the heading does not say it.
        time: Time column by name or number [default: the one that is named as a time].
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz [default: that of the time stamps].
        between: Read the rows from one time on and before another, in seconds.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        model: Model to fit to a calibration over frequency: 1mode … 4modes, delay, low-pass=ORDER, joined by +
            [default: 1mode].
        corner: Corner of the low-pass in hertz [default: where noise and bias together are least].
        quiet: Seconds at the beginning in which nothing happens [default: up to the pulse].
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError
