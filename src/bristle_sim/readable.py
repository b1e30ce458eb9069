"""Readable numbers and tables: units with prefixes, percentages, and aligned columns."""

import math
from collections.abc import Container, Sequence
from decimal import Decimal

WIDTH = 100  # largest width of a table, in characters

MILLIMETRES = 1e3
MILLISECONDS = 1e3
MICROSECONDS = 1e6
MICROMETRES = 1e6
"""Millimetres and micrometres in a metre, milliseconds and microseconds in a second."""

PREFIXES = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}

LARGEST_PREFIX = {
    "s": "",
    "m": "",
    "N s": "",
    "Pa": "G",
    **dict.fromkeys(("g", "N", "N m", "J", "W", "Hz"), "k"),
}
"""Largest customary prefix by unit; only these units are shown with a prefix."""

SMALLEST_PREFIX = {"N s": "m", "N": "m"}
"""Smallest customary prefix by unit; all other units have the smallest prefix n."""

CUSTOMARY = {
    "m^2": ("mm²", 1e-6),
    "m^3": ("mm³", 1e-9),
    "m^3/s": ("mm³/s", 1e-9),
    "m^2/s": ("m²/h", 1.0 / 3600.0),
}
"""For each original unit: the unit in which a quantity is shown, and the size of the shown unit in
the original unit."""


def finite(value: float | None) -> float | None:
    """Return a number if it is finite, otherwise None."""
    return float(value) if value is not None and math.isfinite(value) else None


def plain_number(value: float, digits: int) -> str:
    """Return a number as text, rounded to a given number of significant digits.

    The text has no exponent if the number is 0 or its magnitude is from 1e-4 up to 1e7: ``1030``
    instead of ``1.03e+03``.
    """
    text = f"{value:.{digits}g}"
    return f"{Decimal(text):f}" if 1e-4 <= abs(float(text)) < 1e7 else text


def amount(value: float, unit: str, digits: int = 3) -> str:
    """Return a number with its unit and a readable prefix as text, for example ``2.75 mN s``."""
    shown, factor = readable_unit(unit, [value])
    written = {"deg": "°", "1": ""}.get(shown, f" {shown}")
    return f"{plain_number(value / factor, digits)}{written}"


def aligned(
    rows: Sequence[Sequence[str]], left: Container[int], widths: Sequence[int] = ()
) -> list[str]:
    """Return the rows of a table as lines of text with aligned columns.

    Args:
        rows: texts of each row.
        left: indices of the columns that are aligned to the left; the others are aligned to the
            right.
        widths: width of each column, in characters; by default that of its longest text.
    """
    widths = widths or [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = enumerate(zip(row, widths, strict=True))
        padded = [
            text.ljust(width) if place in left else text.rjust(width)
            for place, (text, width) in cells
        ]
        lines.append("  ".join(padded).rstrip())
    return lines


def readable_unit(unit: str, values: Sequence[float | None]) -> tuple[str, float]:
    """Return a unit with a readable prefix for some values, and the size of the new unit in the old
    one.

    The prefix is chosen such that the largest value has one to three digits before the decimal
    point.
    """
    if unit in CUSTOMARY:
        return CUSTOMARY[unit]
    base, own = ("g", 1e-3) if unit == "kg" else (unit, 1.0)
    largest = max(map(abs, filter(None, map(finite, values))), default=0.0)
    shown = unit, 1.0
    if base in LARGEST_PREFIX and largest:
        most, least = PREFIXES[LARGEST_PREFIX[base]], PREFIXES[SMALLEST_PREFIX.get(base, "n")]
        for prefix, size in PREFIXES.items():
            if size == least or (least < size <= most and largest >= size * own * (1.0 - 1e-9)):
                shown = prefix + base, size * own
    return shown


def relative_text(value: float | None, sign: str = "") -> str:
    """Return a relative number as text, such as ``2.5 %``, ``3e-06`` or ``12 times``.

    A magnitude below 1e-4 is shown with a power of ten, a magnitude of at least 10 as a multiple,
    any other in per cent. If ``sign`` is ``+``, positive numbers have a sign.
    """
    if not value or not math.isfinite(value):
        return "0" if value == 0.0 else "-"
    if 1e-4 <= abs(value) < 10.0:
        return f"{100.0 * value:{sign}.3g} %"
    return f"{value:{sign}.0e}" if abs(value) < 1.0 else f"{value:{sign}.2g} times"
