"""Declared parameters: the values that are accepted, those that are refused, how a refusal reads, and documentation."""

from __future__ import annotations

import dataclasses
import math
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bristle_sim as bs
from bristle_sim.units import (
    ANY,
    Declared,
    Range,
    UnusualValueWarning,
    choice,
    count,
    described,
    quantity,
    unusual_value,
)

FROM_ZERO = Range("friction", "1", 0.0, 1e9, True, "a source")
ABOVE_ZERO = Range("bristle_length", "m", 0.0, 1e3, False, "a source")


@described
@dataclass(frozen=True)
class Part(Declared):
    """A part."""

    length: float = quantity(0.5, "0 < length <= 2e3 m", "how long it is", "a source")
    extra: float | None = quantity(None, "-1 <= extra <= 1 s", "another one", "none")
    word: str = choice("one", "word", ("one", "two"), "a word", "chosen")
    links: int = count(1, "1 <= links <= 64", "how many", "a source")
    undeclared: int = 3


@pytest.mark.parametrize(
    ("text", "value"), [(" 5 ", 5.0), ("+.5", 0.5), ("1E-3", 1e-3), ("0", 0.0), ("1e9", 1e9), ("1e-320", 1e-320)]
)
def test_decimal_numbers_are_parsed(text: str, value: float):
    assert FROM_ZERO.parse(text) == value


@pytest.mark.parametrize(
    "text",
    [
        *("", " ", "abc", "nan", "-inf", "infinity", "1e999", "-1e-320", "1000000000.0000002", "0x10", "1_000", "1 2"),
        "\u22125",  # the minus sign that word processors set
        "\u0663",  # three in Arabic-Indic digits, which float() takes
        *("1\n2", "5\0", "\udcff", "None", "True", "5 1/m", "5 (m)", "5 m**99", "m 5"),
    ],
)
def test_anything_else_is_refused_in_one_line(text: str):
    with pytest.raises(ValueError, match=r"^friction = ") as refusal:
        FROM_ZERO.parse(text)
    message = str(refusal.value)
    assert message == f"friction = {text!r}: must be a finite number with 0 <= friction <= 1e+09 (dimensionless)"
    assert message.isprintable()


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("27mm", "m", 0.027),
        ("2.7e1 mm", "m", 0.027),
        ("710 um", "m", 7.1e-4),
        ("710\u00b5m", "m", 7.1e-4),
        ("2500rpm", "rad/s", 2500.0 * math.tau / 60.0),
        ("2500 turn/min", "rad/s", 2500.0 * math.tau / 60.0),
        ("15000 deg/s", "rad/s", math.radians(15000.0)),
        ("44.5deg", "deg", 44.5),
        ("44.5\u00b0", "deg", 44.5),
        ("0.5 rad", "deg", math.degrees(0.5)),
        ("0.00041 N m/deg", "N m/rad", math.degrees(0.00041)),
        ("0.41 N*mm/deg", "N m/rad", math.degrees(0.00041)),
        ("84mg", "kg", 8.4e-5),
        ("120MPa", "Pa", 1.2e8),
        ("9.81 m/s^2", "m/s^2", 9.81),
        ("9.81 m s^-2", "m/s^2", 9.81),
        ("50us", "s", 5e-5),
        ("31%", "1", 0.31),
    ],
)
def test_a_number_may_carry_a_unit(text: str, unit: str, value: float):
    """The factor is pint's; one rounding for it and one for the product."""
    assert Range("key", unit, 0.0, 1e9, True, "a source").parse(text) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize(
    ("text", "unit", "why"),
    [
        ("27kg", "m", "in m, to which kg cannot be converted"),
        ("27 xyz", "m", r"in m, to which xyz cannot be converted"),
        ("3000rmp", "rad/s", r"in rad/s, to which rmp cannot be converted; did you mean rpm\?"),
        ("27milimeter", "m", r"in m, to which milimeter cannot be converted; did you mean millimetre\?"),
        ("200GPA", "Pa", r"in Pa, to which GPA cannot be converted; did you mean GPa\?"),
        ("27m^2", "m", r"in m, to which m\^2 cannot be converted"),
        ("250Hz", "rad/s", "in rad/s, to which Hz cannot be converted"),
        ("0.4 N m", "N m/rad", "in N m/rad, to which N m cannot be converted"),
        ("20deg", "1", "dimensionless, to which deg cannot be converted"),
        ("20degC", "1", "dimensionless, to which degC cannot be converted"),
        ("2500RPM", "rad/s", r"in rad/s, to which RPM cannot be converted; did you mean rpm\?"),
        ("0.41mNm/deg", "N m/rad", r"in N m/rad, to which mNm/deg cannot be converted; did you mean mN m/deg\?"),
        ("0,027", "m", r"in m; did you mean 0\.027\?"),
        ("1,5 mm", "m", r"in m; did you mean 1\.5 mm\?"),
        ("1j", "1", "dimensionless, to which j cannot be converted"),
        ("1e9 km", "m", "in m"),
        ("-1 mm", "m", "in m"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused(text: str, unit: str, why: str):
    """An angle is no pure number here: 250 Hz are 1571 rad/s, not 250."""
    with pytest.raises(ValueError, match=rf"^key = '{re.escape(text)}': must be a finite number .* \({why}\)$"):
        Range("key", unit, 0.0, 1e9, True, "a source").parse(text)


def test_pint_is_imported_only_for_a_unit():
    code = (
        "import sys; from bristle_sim.units import Range; r = Range('k', 'm', 0, 1, True, 's');"
        " r.parse('1e-3'); print('pint' in sys.modules); r.parse('1mm'); print('pint' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["False", "True"]


@pytest.mark.parametrize(
    ("value", "default", "usual", "far"),
    [
        (27.0, 0.027, None, True),  # mm typed as m
        (2.7, 0.027, None, True),  # a factor of 100 is far
        (2.6, 0.027, None, False),
        (0.00027, 0.027, None, True),
        (-2.7, 0.027, None, True),
        (0.0, 0.027, None, False),  # an effect left out
        (1e9, 0.0, None, False),  # nothing to compare with
        (1e9, None, None, False),
        (2500.0, 261.8, (1.0, 1500.0), True),
        (1200.0, 261.8, (1.0, 1500.0), False),
        (1e-11, 1e-6, ANY, False),
    ],
)
def test_a_value_far_from_what_is_usual(
    value: float, default: float | None, usual: tuple[float, float] | None, far: bool
):
    declared = Range("key", "m", 0.0, 1e9, True, "a source", usual=usual)
    assert bool(unusual_value(declared, default, value, value)) is far


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (
            lambda: Part(length=200.0),
            "length = 200 m is 400 times the default, 0.5 m; if it was meant in mm: length='200 mm'",
        ),
        (lambda: Part(length="200 m"), "length = 200 m is 400 times the default, 0.5 m"),
        (
            lambda: bs.Belt(stiffness=0.00041),
            "belt_stiffness = 0.00041 N m/rad is the number in print, which is per degree:"
            " belt_stiffness='0.00041 N m/deg'",
        ),
    ],
)
def test_an_unusual_value_is_warned_of(make: Callable[[], object], line: str):
    with pytest.warns(UnusualValueWarning) as found:
        make()
    assert [str(each.message) for each in found] == [line]
    assert found[0].filename == __file__


def test_bounds():
    smallest = math.nextafter(0.0, 1.0)
    for accepted in (0.0, smallest, 1e9):
        assert FROM_ZERO.check(accepted) == accepted
    for refused in (-smallest, math.nextafter(1e9, math.inf), math.inf, -math.inf, math.nan):
        with pytest.raises(ValueError, match=r"friction = -?[\dein]"):
            FROM_ZERO.check(refused)
    assert ABOVE_ZERO.check(smallest) == smallest
    with pytest.raises(ValueError, match="0 < bristle_length <= 1000"):
        ABOVE_ZERO.check(0.0)


@given(st.floats(0.0, 1e9))
def test_every_number_in_range_survives_typing(value: float):
    assert FROM_ZERO.parse(repr(value)) == value


@given(st.text(max_size=8))
def test_text_gives_a_number_in_range_or_a_printable_refusal(text: str):
    value, refusal = 0.0, ""
    try:
        value = FROM_ZERO.parse(text)
    except ValueError as error:
        refusal = str(error)
    assert 0.0 <= value <= 1e9
    assert refusal.isprintable()


@pytest.mark.parametrize("value", [5, np.float32(5), np.float64(5), np.int64(5), Fraction(5)])
def test_real_numbers_become_plain_floats(value: object):
    checked = FROM_ZERO.check(value)
    assert type(checked) is float
    assert checked == 5.0


@pytest.mark.parametrize("value", [True, np.bool_(True), None, b"5", 5j, [5.0], np.array([5.0]), np.array(5.0), "5"])
def test_a_value_that_is_no_real_number_is_refused(value: object):
    with pytest.raises(ValueError, match=r"^friction = ") as refusal:
        FROM_ZERO.check(value)
    assert str(refusal.value).startswith(f"friction = {value!r}: ")


def test_a_part_checks_the_fields_it_declares():
    part = Part(length=np.float32(0.25), undeclared=-7)
    assert type(part.length) is float
    assert (part.length, part.extra, part.word, part.links, part.undeclared) == (0.25, None, "one", 1, -7)
    assert Part(extra=-1, length="25 cm") == Part(extra=-1.0, length=0.25)
    for wrong in (
        {"length": 0.0},
        {"length": None},
        {"extra": 1.5},
        {"extra": "none"},
        {"word": None},
        {"word": "six"},
    ):
        with pytest.raises(ValueError, match=f"^{next(iter(wrong))} = "):
            Part(**wrong)
    with pytest.raises(ValueError, match="length"):
        dataclasses.replace(part, length=3e3)


def test_the_documentation_is_the_declaration():
    assert (
        Part.__doc__
        == """A part.

Attributes:
    length: how long it is, m. Must be 0 < length <= 2000. Default 0.5 (a source).
    extra: another one, s. Must be -1 <= extra <= 1. Default None (none).
    word: a word. Must be one | two. Default one (chosen).
    links: how many. Must be whole number from 1 to 64. Default 1 (a source)."""
    )


@pytest.mark.parametrize("value", [8, 8.0, np.int64(8), np.float32(8), "8.0"])
def test_a_count_is_kept_as_an_int(value: object) -> None:
    assert Part(links=value).links == 8
    assert type(Part(links=value).links) is int


@pytest.mark.parametrize("value", [0, 65, 2.5, math.nan, math.inf, True, None, "2.5", "eight", ""])
def test_a_value_that_is_no_count_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match=r"^links = .*: must be a whole number from 1 to 64 \(dimensionless\)$"):
        Part(links=value)
