"""Numbers with units as users type and read them, conversion factors between units, and advice on
misspelt words."""

import difflib
import functools
import math
import re
import reprlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bristle_sim.readable import plain_number

_UNIT = r"[A-Za-z%\u00b0\u00b5\u03bc]+(?:(?:\^|\*\*)-?\d|[\u00b2\u00b3])?"

TYPED = re.compile(
    rf"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>{_UNIT}(?:\s*[*/\u00b7 ]\s*{_UNIT})*)?",
    re.ASCII,
)
"""Pattern of a typed decimal number with or without a unit. The unit may be a product of powers.

Unlike Python's float(), the pattern accepts neither underscores between digits nor digits of other
scripts, which nobody types on purpose."""

GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(?![\d,])")
"""Pattern of a number whose thousands are grouped by commas, as in 3,000 rpm."""

TYPICAL_UNITS = (
    *("m", "mm", "um", "cm", "inch", "metre", "millimetre", "micrometre", "kg", "g", "mg", "gram", "s", "ms", "us", "second"),
    *("rad/s", "rpm", "deg/s", "rad", "deg", "degree", "N m/rad", "N m/deg", "mN m/rad", "mN m/deg", "N mm/rad", "N mm/deg", "N", "mN", "kN", "Hz", "kHz", "m/s", "m/s^2"),
    *("Pa", "kPa", "MPa", "GPa", "N/mm^2", "N/m", "N/V", "N/mV", "percent"),
)  # fmt: skip
"""Common units, which are suggested in place of a mistyped unit."""

DISPLAY = {
    "m": ("mm", 1e-3),
    "kg": ("mg", 1e-6),
    "s": ("ms", 1e-3),
    "rad/s": ("rpm", math.pi / 30.0),
    "rad": ("deg", math.pi / 180.0),
    "Pa": ("MPa", 1e6),
    "1/s": ("Hz", 1.0),
}
"""For each unit in which parameters are declared: the customary unit, and the size of the customary
unit in the declared unit."""

DISPLAY_OF_KEY = {
    "wire_modulus": ("GPa", 1e9),
    "rod_mass": ("g", 1e-3),
    "rate": ("rad/s", 1.0),
    "rate_1": ("rad/s", 1.0),
    "rate_2": ("rad/s", 1.0),
}
"""Customary unit and its size in the declared unit, as in ``DISPLAY``, for the keys of parameters
whose customary unit is not the unit in ``DISPLAY``."""


def display_unit(key: str, unit: str) -> tuple[str, float]:
    """Return the customary unit of a parameter, and the unit's size in the declared unit.

    >>> display_unit("bristle_length", "m")
    ('mm', 0.001)
    """
    return DISPLAY_OF_KEY.get(key) or DISPLAY.get(unit, ("" if unit == "1" else unit, 1.0))


def scaled(number: float, size: float) -> float:
    """Convert a typed number to the declared unit: return the number times the size of its unit.

    If the declared unit is a whole multiple of the typed unit, as 1 m = 1000 mm, the result is
    correctly rounded: it is the floating-point number closest to the exact value.
    """
    parts = round(1.0 / size) if size < 1.0 else 0
    return (
        number / parts
        if parts and math.isclose(parts * size, 1.0, rel_tol=1e-12)
        else number * size
    )


def exact_text(value: float, key: str, unit: str) -> str:
    """Return a short text with a unit that is read back as exactly this value.

    Examples are ``27 mm`` and ``261.8 rad/s``. The text is in the customary unit. The declared unit
    is used if the text is then shorter, or if no text in the customary unit is exact.

    Args:
        value: value in the declared unit.
        key: key of the parameter.
        unit: declared unit of the parameter.
    """
    own = f"{repr(value).removesuffix('.0')} {'' if unit == '1' else unit}".rstrip()
    shown, size = display_unit(key, unit)
    for digits in range(1, 18):
        number = f"{value / size:.{digits}g}"
        if scaled(float(number), size) == value:
            return min(f"{plain_number(float(number), digits)} {shown}".rstrip(), own, key=len)
    return own


def conversion(unit: str, to: str) -> float | None:
    """Return the factor that converts a number from one unit to another.

    The result is None if the dimensions differ. An angle has a dimension of its own: 250 Hz is not
    converted to rad/s, nor N m to N m/rad.
    """
    customary, size = DISPLAY.get(to, ("", 1.0))
    if unit == customary:
        return size  # without pint, whose import takes half a second
    try:
        factor = float(_registry().Quantity(1.0, unit).to(to.replace(" ", "*")).magnitude)
    # pint raises the errors of its parser: TokenError, ZeroDivisionError, AssertionError, ...
    except Exception:
        return None
    return factor if math.isfinite(factor) and factor > 0.0 else None


def likely_unit(unit: str, to: str) -> str:
    """Return a hint that suggests a unit in place of a mistyped one.

    Of the common units that can be converted to the unit ``to``, the hint suggests the one with the
    most similar name. The hint is empty if no name is similar.
    """
    fitting = {_unspaced(name): name for name in TYPICAL_UNITS if conversion(name, to) is not None}
    closeness = (
        0.6 if conversion(unit, unit) is None else 1.0
    )  # an existing unit must have the same letters
    likely = difflib.get_close_matches(_unspaced(unit), fitting, n=1, cutoff=closeness)
    return f"; did you mean {fitting[likely[0]]}?" if likely else ""


def meant_unit(text: str, unit: str, typical: float) -> str:
    """Return a unit that may have been meant for a number typed without a unit.

    In the returned unit the number is within a factor of ten of ``typical``, which is a usual value
    in the declared unit ``unit``. The result is empty if no common unit fits, or if the text has a
    unit.
    """
    try:
        number = float(text)
    except ValueError:
        return ""
    for likely in TYPICAL_UNITS:
        size = conversion(likely, unit) or 1.0
        if size != 1.0 and 0.1 <= abs(number * size / typical) <= 10.0:
            return likely
    return ""


def _unspaced(unit: str) -> str:
    """Return the name of a unit in lower case, without blanks and multiplication signs."""
    return re.sub(r"[\s*\u00b7]", "", unit).lower()


@functools.cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(filename=None)
    registry.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    registry.define("radian = [plane_angle] = rad")
    return registry


LONGEST_SHOWN = 100  # largest number of characters of a value in a message


def shown(value: Any) -> str:
    """Return any Python value as one short line of text, for messages."""
    try:
        text = reprlib.repr(value)
    except ValueError:  # Python does not convert an integer of thousands of digits to text
        text = f"<{type(value).__name__}>"
    line = " ".join(each.strip() for each in text.splitlines())
    return line if len(line) <= LONGEST_SHOWN else f"{line[:LONGEST_SHOWN]}..."


def likely_key(key: str, keys: Iterable[str], otherwise: str | None = None) -> str:
    """Return advice on a misspelt key, for messages.

    Args:
        key: the misspelt key.
        keys: all known keys.
        otherwise: advice if no known key is similar; by default the list of all known keys.
    """
    known = sorted(keys)
    likely = difflib.get_close_matches(key.strip().lower().replace("-", "_"), known, n=1)
    likely = likely or [each for each in known if each.endswith(f"_{key}")]
    if likely:
        return f"did you mean {likely[0]}?"
    return f"must be one of {', '.join(known)}" if otherwise is None else otherwise
