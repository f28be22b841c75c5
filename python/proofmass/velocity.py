"""Velocity of an axis from encoder and accelerometer.

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

from collections.abc import Sequence

from ._command import command
from ._result import Result
from ._types import Data, Names, Place, Watch

__all__ = [
    "compare",
    "drift",
    "estimate",
    "integrator",
    "map",
    "tune",
]


def __dir__() -> Names:
    return __all__


@command("velocity estimate")
def estimate(
    recording: Data,
    *,
    position: str | Sequence[str | int | float] | None = None,
    speed: str | Sequence[str | int | float] | None = None,
    quadrature: str | Sequence[str | int | float] | None = None,
    resolver: str | Sequence[str | int | float] | None = None,
    excitation: str | None = None,
    carrier: float | None = None,
    teeth: str | None = None,
    unit: str | None = None,
    scale: float | None = None,
    counts_per_turn: float | None = None,
    counts_per_metre: float | None = None,
    radius: float | None = None,
    lead: float | None = None,
    bits: int | None = None,
    gray: bool = False,
    decoding: str = "4",
    index: str | None = None,
    reverse: bool = False,
    edges: bool = False,
    angular: bool = False,
    wraps: bool = False,
    yaw_rate: str | None = None,
    yaw_rate_unit: str | None = None,
    track: float | None = None,
    acceleration: str | Sequence[str | int | float] | None = None,
    acceleration_unit: str | None = None,
    acceleration_file: Data | None = None,
    acceleration_source: str | None = None,
    acceleration_time: str | None = None,
    acceleration_rate: float | None = None,
    calibration: Data | None = None,
    calibration_band: str | None = None,
    axis: str | None = None,
    gain_uncertainty: float | None = None,
    low_corner: float | None = None,
    low_corner_uncertainty: float | None = None,
    low_corner_order: int | None = None,
    latency: float = 0,
    still: str | Sequence[float] | None = None,
    between: Sequence[float] | None = None,
    encoder_map: Data | None = None,
    at_rest: bool = False,
    initial_velocity: float | None = None,
    initial_velocity_uncertainty: float | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    columns: Sequence[str] | None = None,
    method: str | None = None,
    circumference: float | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Velocity with its uncertainty; slip, collisions and encoder ripple are reported.

    Without method= it is the Kalman filter. Its noise is found by maximum likelihood, its gains by comparison with
    the smoother, which uses the readings before and after. With output=, a folder gets result.json, report.html and
    velocity.csv.

    Args:
        recording: Recording with the encoder or the wheel speed, and with the accelerometer unless that has its own
            file.
        position: Column of the position (count, length or angle); of several columns the mean, as of two wheels.
        speed: Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean.
        quadrature: Columns of the logic levels A,B or A,B,Z of an incremental encoder.
        resolver: Columns of the voltages of a resolver, sine and cosine: demodulated, or with their carrier.
        excitation: Column of the excitation of a resolver whose voltages still have their carrier.
        carrier: Frequency of that carrier in hertz, where the excitation is not recorded: the angle is then ambiguous
            by half a turn.
        teeth: Column of the level of a toothed wheel's pick-up: every tooth is a count; the direction is not
            available.
        unit: Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h,
            rad/s, ….
        scale: Factor from the column to that unit: speed per volt of a tachogenerator, half a wavelength per hertz of
            Doppler.
        counts_per_turn: Counts per turn of the encoder (four times its lines with fourfold decoding).
        counts_per_metre: Counts per metre of a linear encoder.
        radius: Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits.
        lead: Lead of a screw, its travel per turn, m: in place of radius= for an encoder or a resolver on its shaft.
        bits: Bits of the counter or of the absolute encoder, which rolls over.
        gray: The words are Gray code.
        decoding: Edges counted per line of the logic levels: 1, 2 or 4.
        index: Column of the index pulse beside counts of a turn: zero of the position, and lost counts put back at
            every turn.
        reverse: Positions or speeds are positive against the acceleration: reverse them.
        edges: Each row is an edge of the encoder with its time stamp, not a sample.
        angular: Velocity in rad/s: angles stay angles, and radius= is that of the accelerometer.
        wraps: Angles restart after each turn, as those of an absolute encoder in degrees.
        yaw_rate: Column of a gyroscope's yaw rate, positive to the left: finds where one of two wheels (left,right)
            slips.
        yaw_rate_unit: Unit of the yaw rate, where the heading does not say it: rad/s, °/s, ….
        track: Distance of the two wheels, m.
        acceleration: Column of the acceleration or of a calibrated output; x,y,z with a calibration of three axes;
            none for an encoder alone.
        acceleration_unit: Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, ….
        acceleration_file: File of the accelerometer, when it has its own; its clock must be that of the recording.
        acceleration_source: Stream of that file, where it holds several; it may be the same file as the recording.
        acceleration_time: Time column of the accelerometer's file, where no heading names it.
        acceleration_rate: Sampling rate of the accelerometer's file in hertz, when that has no time column.
        calibration: Calibration of the accelerometer (calibration.json, or result.json of a test of one axis):
            compensates the acceleration first, and its uncertainty of the gain is the prior of the gain.
        calibration_band: Calibration over frequency, as of a shaker: the band in hertz whose constant is used; one
            frequency twice is that alone.
        axis: Axis of the compensated accelerometer that lies along the motion, where the calibration has three. One
            of x, y, z.
        gain_uncertainty: Standard uncertainty of the accelerometer's gain, per cent, from a calibration or data sheet
            (limits of ± 5 % are 2.9); the gain is then estimated, with this as its prior.
        low_corner: Frequency below which the accelerometer shows less (3 dB), as of a piezoelectric one or an AC
            coupling, Hz; slow accelerations are given back. Without it a corner is looked for beside positions.
        low_corner_uncertainty: Its standard uncertainty, Hz.
        low_corner_order: Stages of first order with that corner: 1, where nothing is said, or 2.
        latency: Time by which the accelerometer is later than the encoder, s; it is shifted back by it.
        still: Interval at rest, in seconds: its mean acceleration is the offset that is removed.
        between: Use the rows from one time on and before another, in seconds.
        encoder_map: Map of the encoder that is subtracted from the positions: result.json of `proofmass velocity
            map`.
        at_rest: The axis stands still at the first sample.
        initial_velocity: Velocity at the first sample that is used, m/s (rad/s of an angle) [default: that of the
            first readings].
        initial_velocity_uncertainty: Its standard uncertainty, m/s (rad/s of an angle) [default: 0, exact].
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        columns: Columns of position and acceleration in one: position= and acceleration=.
        method: Method with its settings, such as observer:5,25 or savitzky-golay:9,2 [default: Kalman, tuned].
        circumference: Circumference of the wheel, m: errors that repeat every turn are then reported by themselves.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("velocity compare")
def compare(
    recording: Data,
    *,
    position: str | Sequence[str | int | float] | None = None,
    speed: str | Sequence[str | int | float] | None = None,
    quadrature: str | Sequence[str | int | float] | None = None,
    resolver: str | Sequence[str | int | float] | None = None,
    excitation: str | None = None,
    carrier: float | None = None,
    teeth: str | None = None,
    unit: str | None = None,
    scale: float | None = None,
    counts_per_turn: float | None = None,
    counts_per_metre: float | None = None,
    radius: float | None = None,
    lead: float | None = None,
    bits: int | None = None,
    gray: bool = False,
    decoding: str = "4",
    index: str | None = None,
    reverse: bool = False,
    edges: bool = False,
    angular: bool = False,
    wraps: bool = False,
    yaw_rate: str | None = None,
    yaw_rate_unit: str | None = None,
    track: float | None = None,
    acceleration: str | Sequence[str | int | float] | None = None,
    acceleration_unit: str | None = None,
    acceleration_file: Data | None = None,
    acceleration_source: str | None = None,
    acceleration_time: str | None = None,
    acceleration_rate: float | None = None,
    calibration: Data | None = None,
    calibration_band: str | None = None,
    axis: str | None = None,
    gain_uncertainty: float | None = None,
    low_corner: float | None = None,
    low_corner_uncertainty: float | None = None,
    low_corner_order: int | None = None,
    latency: float = 0,
    still: str | Sequence[float] | None = None,
    between: Sequence[float] | None = None,
    encoder_map: Data | None = None,
    at_rest: bool = False,
    initial_velocity: float | None = None,
    initial_velocity_uncertainty: float | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    columns: Sequence[str] | None = None,
    reference: str | int | None = None,
    reference_unit: str | None = None,
    reference_file: Data | None = None,
    reference_time: str | int | None = None,
    reference_rate: float | None = None,
    reference_latency: float = 0,
    rates: float | str | Sequence[float] | None = None,
    method: str | Sequence[str | int | float] | None = None,
    skip: float | None = None,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Errors of many methods, against a reference velocity or the smoother.

    At any list of sampling rates. Without method=: differences, a fit and the integral of single sensors, two
    channels and observers with the gains of the literature, and every fused method with gains found at that rate.
    With output=, a folder gets result.json, report.html, errors.csv and velocities.csv.

    Args:
        recording: Recording with the encoder or the wheel speed, and with the accelerometer unless that has its own
            file.
        position: Column of the position (count, length or angle); of several columns the mean, as of two wheels.
        speed: Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean.
        quadrature: Columns of the logic levels A,B or A,B,Z of an incremental encoder.
        resolver: Columns of the voltages of a resolver, sine and cosine: demodulated, or with their carrier.
        excitation: Column of the excitation of a resolver whose voltages still have their carrier.
        carrier: Frequency of that carrier in hertz, where the excitation is not recorded: the angle is then ambiguous
            by half a turn.
        teeth: Column of the level of a toothed wheel's pick-up: every tooth is a count; the direction is not
            available.
        unit: Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h,
            rad/s, ….
        scale: Factor from the column to that unit: speed per volt of a tachogenerator, half a wavelength per hertz of
            Doppler.
        counts_per_turn: Counts per turn of the encoder (four times its lines with fourfold decoding).
        counts_per_metre: Counts per metre of a linear encoder.
        radius: Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits.
        lead: Lead of a screw, its travel per turn, m: in place of radius= for an encoder or a resolver on its shaft.
        bits: Bits of the counter or of the absolute encoder, which rolls over.
        gray: The words are Gray code.
        decoding: Edges counted per line of the logic levels: 1, 2 or 4.
        index: Column of the index pulse beside counts of a turn: zero of the position, and lost counts put back at
            every turn.
        reverse: Positions or speeds are positive against the acceleration: reverse them.
        edges: Each row is an edge of the encoder with its time stamp, not a sample.
        angular: Velocity in rad/s: angles stay angles, and radius= is that of the accelerometer.
        wraps: Angles restart after each turn, as those of an absolute encoder in degrees.
        yaw_rate: Column of a gyroscope's yaw rate, positive to the left: finds where one of two wheels (left,right)
            slips.
        yaw_rate_unit: Unit of the yaw rate, where the heading does not say it: rad/s, °/s, ….
        track: Distance of the two wheels, m.
        acceleration: Column of the acceleration or of a calibrated output; x,y,z with a calibration of three axes;
            none for an encoder alone.
        acceleration_unit: Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, ….
        acceleration_file: File of the accelerometer, when it has its own; its clock must be that of the recording.
        acceleration_source: Stream of that file, where it holds several; it may be the same file as the recording.
        acceleration_time: Time column of the accelerometer's file, where no heading names it.
        acceleration_rate: Sampling rate of the accelerometer's file in hertz, when that has no time column.
        calibration: Calibration of the accelerometer (calibration.json, or result.json of a test of one axis):
            compensates the acceleration first, and its uncertainty of the gain is the prior of the gain.
        calibration_band: Calibration over frequency, as of a shaker: the band in hertz whose constant is used; one
            frequency twice is that alone.
        axis: Axis of the compensated accelerometer that lies along the motion, where the calibration has three. One
            of x, y, z.
        gain_uncertainty: Standard uncertainty of the accelerometer's gain, per cent, from a calibration or data sheet
            (limits of ± 5 % are 2.9); the gain is then estimated, with this as its prior.
        low_corner: Frequency below which the accelerometer shows less (3 dB), as of a piezoelectric one or an AC
            coupling, Hz; slow accelerations are given back. Without it a corner is looked for beside positions.
        low_corner_uncertainty: Its standard uncertainty, Hz.
        low_corner_order: Stages of first order with that corner: 1, where nothing is said, or 2.
        latency: Time by which the accelerometer is later than the encoder, s; it is shifted back by it.
        still: Interval at rest, in seconds: its mean acceleration is the offset that is removed.
        between: Use the rows from one time on and before another, in seconds.
        encoder_map: Map of the encoder that is subtracted from the positions: result.json of `proofmass velocity
            map`.
        at_rest: The axis stands still at the first sample.
        initial_velocity: Velocity at the first sample that is used, m/s (rad/s of an angle) [default: that of the
            first readings].
        initial_velocity_uncertainty: Its standard uncertainty, m/s (rad/s of an angle) [default: 0, exact].
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        columns: Columns of position and acceleration in one: position= and acceleration=.
        reference: Column of a reference velocity, from a better instrument or a simulation.
        reference_unit: Unit of the reference, where the heading does not say it: m/s, km/h, mm/s, ….
        reference_file: File of the reference, when it has its own; its clock must be that of the recording.
        reference_time: Time column of that file, where no heading names it.
        reference_rate: Sampling rate of that file in hertz, when it has no time column.
        reference_latency: Time by which the reference is late, s; it is shifted back by it.
        rates: Sampling rates in hertz, to which the recording is thinned [default: its own].
        method: Method with its settings, such as observer:5,25; may be given several times [default: all].
        skip: Seconds at the start that are not compared: filters settle there [default: 1, at most a tenth].
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("velocity tune")
def tune(
    recording: Data,
    *,
    position: str | Sequence[str | int | float] | None = None,
    speed: str | Sequence[str | int | float] | None = None,
    quadrature: str | Sequence[str | int | float] | None = None,
    resolver: str | Sequence[str | int | float] | None = None,
    excitation: str | None = None,
    carrier: float | None = None,
    teeth: str | None = None,
    unit: str | None = None,
    scale: float | None = None,
    counts_per_turn: float | None = None,
    counts_per_metre: float | None = None,
    radius: float | None = None,
    lead: float | None = None,
    bits: int | None = None,
    gray: bool = False,
    decoding: str = "4",
    index: str | None = None,
    reverse: bool = False,
    edges: bool = False,
    angular: bool = False,
    wraps: bool = False,
    yaw_rate: str | None = None,
    yaw_rate_unit: str | None = None,
    track: float | None = None,
    acceleration: str | Sequence[str | int | float] | None = None,
    acceleration_unit: str | None = None,
    acceleration_file: Data | None = None,
    acceleration_source: str | None = None,
    acceleration_time: str | None = None,
    acceleration_rate: float | None = None,
    calibration: Data | None = None,
    calibration_band: str | None = None,
    axis: str | None = None,
    gain_uncertainty: float | None = None,
    low_corner: float | None = None,
    low_corner_uncertainty: float | None = None,
    low_corner_order: int | None = None,
    latency: float = 0,
    still: str | Sequence[float] | None = None,
    between: Sequence[float] | None = None,
    encoder_map: Data | None = None,
    at_rest: bool = False,
    initial_velocity: float | None = None,
    initial_velocity_uncertainty: float | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    columns: Sequence[str] | None = None,
    offset: str = "automatic",
    known_increment: bool = False,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Noise of both sensors and gains of every filter, from the recording alone.

    The noise is found by maximum likelihood. The gains are those whose velocity comes closest to the smoother's. With
    output=, a folder gets result.json, report.html and likelihood.csv.

    Args:
        recording: Recording with the encoder or the wheel speed, and with the accelerometer unless that has its own
            file.
        position: Column of the position (count, length or angle); of several columns the mean, as of two wheels.
        speed: Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean.
        quadrature: Columns of the logic levels A,B or A,B,Z of an incremental encoder.
        resolver: Columns of the voltages of a resolver, sine and cosine: demodulated, or with their carrier.
        excitation: Column of the excitation of a resolver whose voltages still have their carrier.
        carrier: Frequency of that carrier in hertz, where the excitation is not recorded: the angle is then ambiguous
            by half a turn.
        teeth: Column of the level of a toothed wheel's pick-up: every tooth is a count; the direction is not
            available.
        unit: Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h,
            rad/s, ….
        scale: Factor from the column to that unit: speed per volt of a tachogenerator, half a wavelength per hertz of
            Doppler.
        counts_per_turn: Counts per turn of the encoder (four times its lines with fourfold decoding).
        counts_per_metre: Counts per metre of a linear encoder.
        radius: Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits.
        lead: Lead of a screw, its travel per turn, m: in place of radius= for an encoder or a resolver on its shaft.
        bits: Bits of the counter or of the absolute encoder, which rolls over.
        gray: The words are Gray code.
        decoding: Edges counted per line of the logic levels: 1, 2 or 4.
        index: Column of the index pulse beside counts of a turn: zero of the position, and lost counts put back at
            every turn.
        reverse: Positions or speeds are positive against the acceleration: reverse them.
        edges: Each row is an edge of the encoder with its time stamp, not a sample.
        angular: Velocity in rad/s: angles stay angles, and radius= is that of the accelerometer.
        wraps: Angles restart after each turn, as those of an absolute encoder in degrees.
        yaw_rate: Column of a gyroscope's yaw rate, positive to the left: finds where one of two wheels (left,right)
            slips.
        yaw_rate_unit: Unit of the yaw rate, where the heading does not say it: rad/s, °/s, ….
        track: Distance of the two wheels, m.
        acceleration: Column of the acceleration or of a calibrated output; x,y,z with a calibration of three axes;
            none for an encoder alone.
        acceleration_unit: Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, ….
        acceleration_file: File of the accelerometer, when it has its own; its clock must be that of the recording.
        acceleration_source: Stream of that file, where it holds several; it may be the same file as the recording.
        acceleration_time: Time column of the accelerometer's file, where no heading names it.
        acceleration_rate: Sampling rate of the accelerometer's file in hertz, when that has no time column.
        calibration: Calibration of the accelerometer (calibration.json, or result.json of a test of one axis):
            compensates the acceleration first, and its uncertainty of the gain is the prior of the gain.
        calibration_band: Calibration over frequency, as of a shaker: the band in hertz whose constant is used; one
            frequency twice is that alone.
        axis: Axis of the compensated accelerometer that lies along the motion, where the calibration has three. One
            of x, y, z.
        gain_uncertainty: Standard uncertainty of the accelerometer's gain, per cent, from a calibration or data sheet
            (limits of ± 5 % are 2.9); the gain is then estimated, with this as its prior.
        low_corner: Frequency below which the accelerometer shows less (3 dB), as of a piezoelectric one or an AC
            coupling, Hz; slow accelerations are given back. Without it a corner is looked for beside positions.
        low_corner_uncertainty: Its standard uncertainty, Hz.
        low_corner_order: Stages of first order with that corner: 1, where nothing is said, or 2.
        latency: Time by which the accelerometer is later than the encoder, s; it is shifted back by it.
        still: Interval at rest, in seconds: its mean acceleration is the offset that is removed.
        between: Use the rows from one time on and before another, in seconds.
        encoder_map: Map of the encoder that is subtracted from the positions: result.json of `proofmass velocity
            map`.
        at_rest: The axis stands still at the first sample.
        initial_velocity: Velocity at the first sample that is used, m/s (rad/s of an angle) [default: that of the
            first readings].
        initial_velocity_uncertainty: Its standard uncertainty, m/s (rad/s of an angle) [default: 0, exact].
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        columns: Columns of position and acceleration in one: position= and acceleration=.
        offset: Whether the accelerometer's offset is a state of the filter. One of none, constant, random-walk,
            automatic.
        known_increment: Take the noise of a count as known, increment/√12, instead of finding it.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("velocity map")
def map(
    recording: Data,
    *,
    position: str | Sequence[str | int | float] | None = None,
    speed: str | Sequence[str | int | float] | None = None,
    quadrature: str | Sequence[str | int | float] | None = None,
    resolver: str | Sequence[str | int | float] | None = None,
    excitation: str | None = None,
    carrier: float | None = None,
    teeth: str | None = None,
    unit: str | None = None,
    scale: float | None = None,
    counts_per_turn: float | None = None,
    counts_per_metre: float | None = None,
    radius: float | None = None,
    lead: float | None = None,
    bits: int | None = None,
    gray: bool = False,
    decoding: str = "4",
    index: str | None = None,
    reverse: bool = False,
    edges: bool = False,
    angular: bool = False,
    wraps: bool = False,
    yaw_rate: str | None = None,
    yaw_rate_unit: str | None = None,
    track: float | None = None,
    acceleration: str | Sequence[str | int | float] | None = None,
    acceleration_unit: str | None = None,
    acceleration_file: Data | None = None,
    acceleration_source: str | None = None,
    acceleration_time: str | None = None,
    acceleration_rate: float | None = None,
    calibration: Data | None = None,
    calibration_band: str | None = None,
    axis: str | None = None,
    gain_uncertainty: float | None = None,
    low_corner: float | None = None,
    low_corner_uncertainty: float | None = None,
    low_corner_order: int | None = None,
    latency: float = 0,
    still: str | Sequence[float] | None = None,
    between: Sequence[float] | None = None,
    encoder_map: Data | None = None,
    at_rest: bool = False,
    initial_velocity: float | None = None,
    initial_velocity_uncertainty: float | None = None,
    time: str | int | None = None,
    time_unit: str | None = None,
    rate: float | None = None,
    source: str | None = None,
    raw: bool = False,
    separator: str | None = None,
    decimal: str | None = None,
    columns: Sequence[str] | None = None,
    turn: float | None = None,
    orders: float | str | Sequence[float] = "1,2,3,4",
    quarters: bool = False,
    false_alarm_rate: float = 0.001,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Errors of the encoder that repeat every turn, such as those of an eccentric disc.

    They are found with the help of the accelerometer. A few turns in either direction, or there and back, suffice.
    Where the wheel slips, the segments without slip are used. Lines that differ significantly from zero are
    subtracted by `encoder_map=RESULT` of the other commands. The map belongs to the zero of the readings: an
    incremental encoder is set to zero at its index. With output=, a folder gets result.json, report.html and
    lines.csv.

    Args:
        recording: Recording with the encoder or the wheel speed, and with the accelerometer unless that has its own
            file.
        position: Column of the position (count, length or angle); of several columns the mean, as of two wheels.
        speed: Column of a speed instead of a position (wheel, tachogenerator); of several columns the mean.
        quadrature: Columns of the logic levels A,B or A,B,Z of an incremental encoder.
        resolver: Columns of the voltages of a resolver, sine and cosine: demodulated, or with their carrier.
        excitation: Column of the excitation of a resolver whose voltages still have their carrier.
        carrier: Frequency of that carrier in hertz, where the excitation is not recorded: the angle is then ambiguous
            by half a turn.
        teeth: Column of the level of a toothed wheel's pick-up: every tooth is a count; the direction is not
            available.
        unit: Unit of position or speed, where the heading does not say it: count, m, mm, rad, °, turn, m/s, km/h,
            rad/s, ….
        scale: Factor from the column to that unit: speed per volt of a tachogenerator, half a wavelength per hertz of
            Doppler.
        counts_per_turn: Counts per turn of the encoder (four times its lines with fourfold decoding).
        counts_per_metre: Counts per metre of a linear encoder.
        radius: Radius that turns an angle into a length, m: of the wheel, or where the accelerometer sits.
        lead: Lead of a screw, its travel per turn, m: in place of radius= for an encoder or a resolver on its shaft.
        bits: Bits of the counter or of the absolute encoder, which rolls over.
        gray: The words are Gray code.
        decoding: Edges counted per line of the logic levels: 1, 2 or 4.
        index: Column of the index pulse beside counts of a turn: zero of the position, and lost counts put back at
            every turn.
        reverse: Positions or speeds are positive against the acceleration: reverse them.
        edges: Each row is an edge of the encoder with its time stamp, not a sample.
        angular: Velocity in rad/s: angles stay angles, and radius= is that of the accelerometer.
        wraps: Angles restart after each turn, as those of an absolute encoder in degrees.
        yaw_rate: Column of a gyroscope's yaw rate, positive to the left: finds where one of two wheels (left,right)
            slips.
        yaw_rate_unit: Unit of the yaw rate, where the heading does not say it: rad/s, °/s, ….
        track: Distance of the two wheels, m.
        acceleration: Column of the acceleration or of a calibrated output; x,y,z with a calibration of three axes;
            none for an encoder alone.
        acceleration_unit: Unit of the acceleration, where the heading does not say it: m/s², mm/s², g, mg, ….
        acceleration_file: File of the accelerometer, when it has its own; its clock must be that of the recording.
        acceleration_source: Stream of that file, where it holds several; it may be the same file as the recording.
        acceleration_time: Time column of the accelerometer's file, where no heading names it.
        acceleration_rate: Sampling rate of the accelerometer's file in hertz, when that has no time column.
        calibration: Calibration of the accelerometer (calibration.json, or result.json of a test of one axis):
            compensates the acceleration first, and its uncertainty of the gain is the prior of the gain.
        calibration_band: Calibration over frequency, as of a shaker: the band in hertz whose constant is used; one
            frequency twice is that alone.
        axis: Axis of the compensated accelerometer that lies along the motion, where the calibration has three. One
            of x, y, z.
        gain_uncertainty: Standard uncertainty of the accelerometer's gain, per cent, from a calibration or data sheet
            (limits of ± 5 % are 2.9); the gain is then estimated, with this as its prior.
        low_corner: Frequency below which the accelerometer shows less (3 dB), as of a piezoelectric one or an AC
            coupling, Hz; slow accelerations are given back. Without it a corner is looked for beside positions.
        low_corner_uncertainty: Its standard uncertainty, Hz.
        low_corner_order: Stages of first order with that corner: 1, where nothing is said, or 2.
        latency: Time by which the accelerometer is later than the encoder, s; it is shifted back by it.
        still: Interval at rest, in seconds: its mean acceleration is the offset that is removed.
        between: Use the rows from one time on and before another, in seconds.
        encoder_map: Map of the encoder that is subtracted from the positions: result.json of `proofmass velocity
            map`.
        at_rest: The axis stands still at the first sample.
        initial_velocity: Velocity at the first sample that is used, m/s (rad/s of an angle) [default: that of the
            first readings].
        initial_velocity_uncertainty: Its standard uncertainty, m/s (rad/s of an angle) [default: 0, exact].
        time: Time column by name or number.
        time_unit: Unit of the time column, where the heading does not say it: s, ms, us, ns, min, h, d, index (with
            rate=).
        rate: Sampling rate in hertz, for recordings without a time column.
        source: Stream of a file that holds several, by its name as `proofmass inspect` lists it.
        raw: Take the numbers as stored, without the scaling that a file declares (TDMS).
        separator: Separator of the columns of a text, where its look does not tell: comma, semicolon, tab, pipe,
            whitespace.
        decimal: Decimal mark of a text, where its look does not tell: point, comma.
        columns: Columns of position and acceleration in one: position= and acceleration=.
        turn: Distance or angle of one turn, in m or rad [default: by angular=True or radius=].
        orders: Cycles per turn of each line: 1 for an eccentric disc, 2 for an ellipse, the ratio of a gear.
        quarters: Also look for unequal quarters of the encoder's lines: an error that repeats every four counts.
        false_alarm_rate: Probability that any line is subtracted from an ideal encoder.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("velocity drift")
def drift(
    *,
    offset: float = 0,
    offset_uncertainty: float = 0,
    offset_walk: float = 0,
    tilt: float = 0,
    tilt_uncertainty: float = 0,
    gain_error: float = 0,
    gain_uncertainty: float = 0,
    speed: float = 0,
    noise: float | None = None,
    rate: float | None = None,
    noise_density: float | None = None,
    noise_result: Data | None = None,
    noise_channel: str | None = None,
    calibration: Data | None = None,
    axis: str | None = None,
    rest: float = 0,
    encoder_increment: float | None = None,
    encoder_rate: float | None = None,
    encoder_scale_uncertainty: float = 0,
    encoder_walk: float = 0,
    times: float | str | Sequence[float] = "1,10,60,600",
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Drift of a velocity from an accelerometer alone; needs no recording.

    It is computed from the stated errors of the sensor, or from results: its noise and what its calibration leaves
    open. Known errors add up, uncertainties and noise widen the interval; each stands by itself in the table. With
    output=, a folder gets result.json, report.html and drift.csv.

    Args:
        offset: Offset, m/s².
        offset_uncertainty: Its standard uncertainty, m/s².
        offset_walk: Random walk of the offset, (m/s²)/√s, as `proofmass noise` states it (coefficient K).
        tilt: Inclination of the axis, degrees: the component of gravity along it is taken for motion.
        tilt_uncertainty: Its standard uncertainty, degrees.
        gain_error: Error of the gain, per cent; acts on speed=.
        gain_uncertainty: Its standard uncertainty, per cent; acts on speed=.
        speed: Change of the velocity since the integration began, m/s.
        noise: Standard deviation of a sample, m/s²; needs rate=.
        rate: Sampling rate of that noise, Hz.
        noise_density: Density of the noise in place of its samples, (m/s²)/√Hz, one-sided as in data sheets.
        noise_result: result.json of `proofmass noise`: N, B, K and Gauss–Markov processes with their intervals, in
            place of typed noise.
        noise_channel: Channel of the noise result, by its name [default: its only one, or that of axis=].
        calibration: Calibration at rest (calibration.json or result.json): what it leaves open of offset and gain,
            with their covariance.
        axis: Axis of both along the motion, where they have three. One of x, y, z.
        rest: Rest just before the start, in seconds: the drift is stated also with its mean taken off.
        encoder_increment: Length of a count of an encoder beside the accelerometer, m: the drift is stated also with
            its aiding.
        encoder_rate: Readings of the encoder per second [default: rate=].
        encoder_scale_uncertainty: Standard uncertainty of the length of a count (the radius of a wheel), per cent;
            acts on speed=.
        encoder_walk: What errors of single counts and slip add up to after a metre, standard deviation, m/√m; acts on
            speed=.
        times: Times after the start, s.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("velocity integrator")
def integrator(
    *,
    band: str | Sequence[float],
    rate: float,
    bias: float,
    noise: float,
    speed: float,
    duration: float = 60,
    error: float | None = None,
    on_line: bool = False,
    output: Place | None = None,
    force: bool = False,
    sign: Data | None = None,
    details: bool = False,
    watch: Watch | None = None,
) -> Result:
    """Which integration rule and which high-pass: ranked for a band, a bias and a noise; needs no recording.

    Every rule of Newton and Cotes, closed and open, Tick's and Adams and Moulton's, each with the order and the
    corner of a Butterworth high-pass that err least in all. With output=, a folder gets result.json, report.html,
    integrators.csv and rules.csv.

    Args:
        band: Lowest and highest frequency of the motion, Hz.
        rate: Sampling rate, Hz.
        bias: Bias of the accelerometer that was not taken off: its size or standard uncertainty, m/s².
        noise: Standard deviation of a sample, m/s².
        speed: Amplitude of the velocity in the band, m/s: what errors of gain and phase act on.
        duration: Length of the record, s.
        error: Error of the velocity that is allowed, m/s: whether the best choice holds is stated.
        on_line: Only what runs while the record comes in, and no high-pass that is run forward and backward.
        output: Folder for result.json, report.html and tables [default: none is written].
        force: Write into a folder that holds other files: those of the same name are replaced, others kept.
        sign: Sign the list of written files with a private key (PEM, Ed25519), as `proofmass keygen` makes it.
        details: Print every table of the summary, not the opening alone.
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError
