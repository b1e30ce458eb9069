"""Find the unit in a column's heading, as ``time (ms)``, ``Force [N]``, ``t/us``, ``F in kN``, ``force_N`` or ``second``."""

from __future__ import annotations

import re

__all__ = ["FORCE", "TIME", "VOLTAGE", "unit_of", "without_unit"]

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
VOLTAGE = {"V": 1.0, "mV": 1e-3}
"""Units in SI."""

WORDS = {
    "sec": "s", "second": "s", "sekunde": "s", "sekunden": "s", "msec": "ms", "millisecond": "ms", "usec": "us", "microsecond": "us",
    "newton": "N", "millinewton": "mN", "kilonewton": "kN", "volt": "V", "millivolt": "mV",
}  # fmt: skip
"""Spelled out, in the singular and lower case."""

BRACKETED = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]\s*$")
LAST = re.compile(r"(?:^|[\s_/,])([^\s_/,\[\]()]+)\s*$")


def unit_of(heading: str) -> str:
    """The unit as in the tables above; as written where it is in brackets and unknown, and empty where there is none."""
    bracketed = BRACKETED.search(heading)
    if bracketed is not None:
        return _known(bracketed[1]) or bracketed[1]
    last = LAST.search(heading)
    return "" if last is None else _known(last[1])


def without_unit(heading: str) -> str:
    """The heading before its unit."""
    bracketed = BRACKETED.search(heading)
    if bracketed is not None:
        return heading[: bracketed.start()].strip()
    last = LAST.search(heading)
    if last is None or not _known(last[1]):
        return heading.strip()
    return re.sub(r"[\s_/,]+(in)?$", "", heading[: last.start()]).strip()


def _known(word: str) -> str:
    # The micro sign and the Greek letter are two characters.
    plain = word.replace("µ", "u").replace("μ", "u")
    if plain in TIME or plain in FORCE or plain in VOLTAGE:
        return plain
    word = plain.lower()
    return WORDS.get(word) or WORDS.get(word.removesuffix("s"), "")
