"""Devices, standards and results over time.

Written by tools/functions.py from the options of the commands: change those, not this.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._command import command
from ._types import Data, Names, Place, Watch

__all__ = [
    "add_campaign",
    "add_certificate",
    "add_check",
    "add_device",
    "add_event",
    "add_in_use",
    "add_result",
    "add_rule",
    "add_standard",
    "backup",
    "check",
    "due",
    "export",
    "forget",
    "history",
    "import_",
    "list",
    "recall",
    "show",
    "supersede",
    "upgrade",
]


def __dir__() -> Names:
    return __all__


@command("records add result")
def add_result(
    results: Sequence[Data] | Data,
    *,
    device: str | None = None,
    new_device: bool = False,
    standard: str | Sequence[str | int | float] | None = None,
    number: str | None = None,
    date: str | None = None,
    campaign: int | None = None,
    supersedes: int | None = None,
    reason: str | None = None,
    largest: float = 100,
    data: Data | None = None,
    by: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add results from their folders.

    Files of the folder and the inputs behind it are kept by their digests, so that `records check recompute=` needs
    nothing else. The same result twice is one.

    Args:
        results: Folders of results, or result.json.
        device: Device that it is of [default: the one that the result names].
        new_device: The serial number is that of a new device, though another has it in another spelling.
        standard: Standard behind it; may be repeated [default: those whose certificate or result is among its
            inputs].
        number: Number of its certificate.
        date: Day of the measurement [default: that of the evaluation].
        campaign: Campaign that it belongs to, by its number here.
        supersedes: Result that it takes the place of; needs reason=.
        reason: Why the other result no longer counts.
        largest: Inputs larger than this are kept by their digest alone, in megabytes.
        data: Folder in which inputs are looked for that are not where they were.
        by: Who files it: the name stands apart and can be removed.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add device")
def add_device(
    *,
    manufacturer: str | None = None,
    model: str | None = None,
    serial: str | None = None,
    owner_number: str | None = None,
    axes: str | None = None,
    description: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add a device.

    Args:
        manufacturer: Maker.
        model: Type.
        serial: Serial number.
        owner_number: Number that the owner has given it.
        axes: Its axes, such as x,y,z.
        description: Anything else worth filing.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add standard")
def add_standard(
    *,
    manufacturer: str | None = None,
    model: str | None = None,
    serial: str | None = None,
    owner_number: str | None = None,
    axes: str | None = None,
    description: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add a reference standard.

    Args:
        manufacturer: Maker.
        model: Type.
        serial: Serial number.
        owner_number: Number that the owner has given it.
        axes: Its axes, such as x,y,z.
        description: Anything else worth filing.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add certificate")
def add_certificate(
    standard: str,
    *,
    number: str | None = None,
    valid_from: str | None = None,
    valid_until: str | None = None,
    laboratory: str | None = None,
    expanded_relative: float | None = None,
    file: Data | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add the certificate of a standard.

    With file= the table or digital calibration certificate (DCC, .xml) that campaigns name as their reference: a
    result that read it is then known to rest on this standard.

    Args:
        standard: The standard: serial number, owner's number, or number here (#12).
        number: Number of the certificate [default: that of the DCC].
        valid_from: First day on which it is valid [default: the day of calibration in the DCC].
        valid_until: Last day on which it is valid.
        laboratory: Laboratory that issued it.
        expanded_relative: Relative expanded uncertainty of the sensitivity (k = 2), in percent.
        file: Its table or page.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add check")
def add_check(
    device: str,
    *,
    value: float,
    u: float,
    reference: str | int,
    u_reference: float,
    unit: str,
    quantity: str = "S.modulus",
    date: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add a check measurement of a device or standard; it is judged by E_n.

    Args:
        device: The device: serial number, owner's number, or number here (#12).
        value: Measured value.
        u: Its standard uncertainty.
        reference: Known value.
        u_reference: Its standard uncertainty.
        unit: Unit of all numbers.
        quantity: What was measured.
        date: Day [default: today].
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add event")
def add_event(
    device: str,
    event: str,
    *,
    text: str = "",
    date: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add what happened to a device: repair, adjustment, drop, withdrawal.

    Args:
        device: The device: serial number, owner's number, or number here (#12).
        event: What happened. One of repair, adjustment, drop, withdrawal, return, other.
        text: In words.
        date: Day [default: today].
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add rule")
def add_rule(
    device: str | None = None,
    *,
    rule: str | None = None,
    months: float | None = None,
    longest: float | None = None,
    without: str | Sequence[str | int | float] | None = None,
    change: str | Sequence[str | int | float] | None = None,
    limits: str | Sequence[str | int | float] | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add the rule by which a device, or all, are due; and what is tolerated.

    What is not said stays as it was: the interval where neither rule= nor months= is given, and every tolerance that
    is not named.

    `fixed`: always after months=. `drift`: until the drift with its uncertainty may have used up a tolerance, at most
    months=. `staircase`: after ILAC-G24, months= at first, a quarter longer after each change within 80 % of the
    tolerance, half after one beyond it, at most longest=.

    Args:
        device: The device: serial number, owner's number, or number here (#12) [default: all without a rule of their
            own].
        rule: How the time to the next calibration is found [default: as before, or fixed]. One of fixed, drift,
            staircase.
        months: Months [default: as before, or 12].
        longest: Longest interval of the staircase, in months [default: as before, or 36].
        without: Quantity that is not tolerated by this rule any more; may be repeated.
        change: Largest tolerated change of a quantity in its unit, such as bias.x=0.01; may be repeated.
        limits: Limits of a quantity in its unit, such as bias.x=-0.1,0.1; may be repeated.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add campaign")
def add_campaign(
    title: str,
    *,
    description: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add a campaign, which results may name.

    Args:
        title: Its title.
        description: Anything else worth filing.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records add in-use")
def add_in_use(
    device: str,
    result: int,
    *,
    date: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """State which calibration a device is used with from a day on.

    Args:
        device: The device: serial number, owner's number, or number here (#12).
        result: Number of the result.
        date: Day [default: today].
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records list")
def list(
    *,
    standards: bool = False,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """List devices and standards, with what is overdue.

    Args:
        standards: Standards alone.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records show")
def show(
    what: str,
    *,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Show a device or standard with all it rests on, or a result by its number.

    Args:
        what: Serial number, owner's number or number here (#12) of a device, or `result:17`.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records history")
def history(
    device: str,
    *,
    quantity: str | None = None,
    html: Data | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Show every quantity of a device over time: drift, jumps, control charts.

    The drift is a weighted regression since the last repair or adjustment. Calibrations against the same certificate
    share its error, which cancels in the drift.

    Args:
        device: Serial number, owner's number or number here (#12).
        quantity: Quantities whose name begins so, such as S.modulus.
        html: Write the page with the control charts.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records due")
def due(
    *,
    within: int = 30,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """List what is due, by the rule of each device.

    Ends with exit code 3 under strict=True where a device is overdue.

    Args:
        within: Days to look ahead.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records check")
def check(
    *,
    recompute: int | str | Sequence[int] | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Check that the records are what was filed: chain, index, files, signatures.

    With recompute= a result is computed again from its campaign and recordings: the same version must give the same
    bytes, of another version each quantity is judged by its U. Ends with exit code 1 where something is damaged.

    Args:
        recompute: Result to compute again, by its number; may be repeated.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records recall")
def recall(
    standard: str,
    *,
    error: float | None = None,
    since: str | None = None,
    until: str | None = None,
    html: Data | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """List every result that used a standard while it may have been wrong, with the effect on each.

    Where a check failed, that is from the last good check of the same quantity before it to the first good one after
    it; else since the last good check of a sensitivity, or the certificate.

    The effect follows from the part of the standard in the budget that each result keeps. Results that used others as
    their reference are followed too.

    Args:
        standard: Serial number, owner's number or number here (#12) of the standard.
        error: Relative error of its sensitivity in percent, measured over certificate: 1.5 where it is 1.5 % larger
            than its certificate says.
        since: First day [default: the last good check before the failed one, else the certificate].
        until: Day as of which it is asked, and the last one where since= is given [default: today].
        html: Write the page.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records supersede")
def supersede(
    result: int,
    *,
    reason: str,
    by_result: int | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """State that a result no longer counts, and why.

    A check, an event, a certificate, a rule or an earlier supersession is taken back in the same way.

    Args:
        result: Number of the result, or of another entry, as it was printed when it was added.
        reason: Why.
        by_result: Result in its place, by its number.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records import")
def import_(
    places: Sequence[Data] | Data,
    *,
    device: str | None = None,
    new_device: bool = False,
    standard: str | Sequence[str | int | float] | None = None,
    number: str | None = None,
    date: str | None = None,
    campaign: int | None = None,
    supersedes: int | None = None,
    reason: str | None = None,
    largest: float = 100,
    data: Data | None = None,
    by: str | None = None,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Add whole trees of result folders, a spreadsheet of old calibrations, or an exported folder.

    A folder is searched for result.json; what is here already is left. A table (.csv) has columns serial, date and
    either quantity, value, unit, u (or U and k), or sensitivity_mV/(m/s2) with frequency_Hz and U_relative_%; values
    without U are marked. A digital calibration certificate (.xml) is a result of its item. A folder of `records
    export folder=` becomes new records.

    Args:
        places: Folders of results, tables, digital calibration certificates, or an exported folder.
        device: Device that it is of [default: the one that the result names].
        new_device: The serial number is that of a new device, though another has it in another spelling.
        standard: Standard behind it; may be repeated [default: those whose certificate or result is among its
            inputs].
        number: Number of its certificate.
        date: Day of the measurement [default: that of the evaluation].
        campaign: Campaign that it belongs to, by its number here.
        supersedes: Result that it takes the place of; needs reason=.
        reason: Why the other result no longer counts.
        largest: Inputs larger than this are kept by their digest alone, in megabytes.
        data: Folder in which inputs are looked for that are not where they were.
        by: Who files it: the name stands apart and can be removed.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records export")
def export(
    *,
    output: Place,
    html: bool = False,
    csv: bool = False,
    parquet: bool = False,
    folder: bool = False,
    force: bool = False,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Write the records as pages, tables, JSON, or a folder from which they are made again.

    Args:
        output: Folder, or file with json=True.
        html: Pages: list, due, one for each device and standard.
        csv: Tables: devices, certificates, results, quantities, checks, events.
        parquet: The same tables as Parquet.
        folder: Everything with every kept file: `records import` makes the same records from it.
        force: Write into a folder that holds other files.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records backup")
def backup(
    file: Data,
    *,
    damaged: bool = False,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Copy the records into a new file while they are in use.

    Args:
        file: New file; larger files go into the folder FILE.files.
        damaged: Copy records that are damaged, as they are.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records upgrade")
def upgrade(
    *,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Bring records of an older version of proofmass to this one, after a copy was kept.

    Args:
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError


@command("records forget")
def forget(
    name: str,
    *,
    records: str | None = None,
    watch: Watch | None = None,
) -> Any:
    """Remove the name of a person; entries and chain stay.

    Args:
        name: The name.
        records: File of the records, or URL of a database [default: PROOFMASS_RECORDS, or lab.records here].
        watch: Told the stage, the steps behind and the steps in all; what it raises stops the command.
    """
    raise NotImplementedError
