"""Notes for the logger of the package."""

from __future__ import annotations


def note(text: str, *values: object) -> None:
    """Tells the logger `proofmass`, which is not asked for before there is something to tell."""
    import logging

    logging.getLogger("proofmass").info(text, *values)
