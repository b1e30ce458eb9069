"""Declared parameters: the values that are accepted, those that are refused, how a refusal reads, and documentation."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import bristle_sim as bs
from bristle_sim.cli.scenario import load_scenario, script_paths
from bristle_sim.declared import Choice, Declared, Range, UnusualValueWarning, declarations
from bristle_sim.fields import ANY, choice, count, quantity
from bristle_sim.parameters import Bristle
from bristle_sim.readable import plain_number
from bristle_sim.units import conversion, exact_text

FRICTION = Range("friction", "1", 0.0, 1e9, True, source="a source")


@dataclass(frozen=True)
class Part(Declared):
    """A part."""

    length: float = quantity(0.5, "0 < length <= 2e3 m: how long it is [a source]")
    extra: float | None = quantity(None, "-1 <= extra <= 1 s: another one [none]")
    word: str = choice("word: a word [chosen]", "one", "two")
    links: int = count(1, "1 <= links <= 64: how many [a source]")
    undeclared: int = 3


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        (" 5 ", "1", 5.0),
        ("+.5", "1", 0.5),
        ("1E-3", "1", 1e-3),
        ("1e-320", "1", 1e-320),
        ("2.7e1 mm", "m", 0.027),
        ("710\u00b5m", "m", 7.1e-4),
        ("2500rpm", "rad/s", 2500.0 * math.tau / 60.0),
        ("2500 turn/min", "rad/s", 2500.0 * math.tau / 60.0),
        ("15000 deg/s", "rad/s", math.radians(15000.0)),
        ("44.5\u00b0", "deg", 44.5),
        ("0.5 rad", "deg", math.degrees(0.5)),
        ("0.41 N*mm/deg", "N m/rad", math.degrees(0.00041)),
        ("84mg", "kg", 8.4e-5),
        ("120MPa", "Pa", 1.2e8),
        ("9.81 m s^-2", "m/s^2", 9.81),
        ("31%", "1", 0.31),
    ],
)
def test_a_number_may_carry_a_unit(text: str, unit: str, value: float):
    """The factor is pint's; one rounding for it and one for the product."""
    assert Range("key", unit, 0.0, 1e9, True, source="a source").parse(text) == pytest.approx(
        value, rel=4e-16
    )


@pytest.mark.parametrize(
    ("text", "unit", "why"),
    [
        ("27kg", "m", "in m, to which kg cannot be converted"),
        ("3000rmp", "rad/s", r"in rad/s, to which rmp cannot be converted; did you mean rpm\?"),
        (
            "27milimeter",
            "m",
            r"in m, to which milimeter cannot be converted; did you mean millimetre\?",
        ),
        ("27m^2", "m", r"in m, to which m\^2 cannot be converted"),
        ("250Hz", "rad/s", "in rad/s, to which Hz cannot be converted"),  # 1571 rad/s, not 250
        ("0.4 N m", "N m/rad", "in N m/rad, to which N m cannot be converted"),
        ("20deg", "1", "dimensionless, to which deg cannot be converted"),
        ("2500RPM", "rad/s", r"in rad/s, to which RPM cannot be converted; did you mean rpm\?"),
        (
            "0.41mNm/deg",
            "N m/rad",
            r"in N m/rad, to which mNm/deg cannot be converted; did you mean mN m/deg\?",
        ),
        ("0,027", "m", r"in m; did you mean 0\.027\?"),
        (
            "0,4\u202e",
            "1",
            "dimensionless",
        ),  # characters that change the terminal are not repeated raw
        ("0,4 \x1b[31m", "1", "dimensionless"),
        ("0,4 \n mm", "m", r"in m; did you mean 0\.4 mm\?"),
        ("4 kg\x0b mm", "1", "dimensionless, to which kg mm cannot be converted"),
        ("1,5 mm", "m", r"in m; did you mean 1\.5 mm\?"),
        ("1e9 km", "m", "in m"),
        ("-1 mm", "m", "in m"),
        *(
            (text, "1", "dimensionless")
            for text in ("", " ", "abc", "nan", "-inf", "1e999", "-1e-320", "1000000000.0000002")
        ),
        *(
            (text, "1", "dimensionless")
            for text in ("0x10", "1_000", "1 2", "1\n2", "5\0", "\udcff", "None", "m 5")
        ),
        ("\u22125", "1", "dimensionless"),  # the minus sign that word processors set
        ("\u0663", "1", "dimensionless"),  # three in Arabic-Indic digits, which float() takes
        *((text, "1", "dimensionless") for text in ("5 1/m", "5 (m)", "5 m**99")),
    ],
)
def test_any_other_text_is_refused_in_one_line(text: str, unit: str, why: str):
    with pytest.raises(
        ValueError, match=r"^key = .*: must be a finite number with 0 <= key <= 1e\+09 "
    ) as refusal:
        Range("key", unit, 0.0, 1e9, True, source="a source").parse(text)
    assert re.search(rf"\({why}\)$", str(refusal.value))
    assert str(refusal.value).startswith(f"key = {text!r}: ")
    assert str(refusal.value).isprintable()


@example(1.0, "0,0\U000107bb")
@given(st.floats(0.0, 1e9), st.text(max_size=8))
def test_every_number_in_range_survives_typing_and_any_text_gives_one_or_a_printable_refusal(
    number: float, text: str
):
    assert FRICTION.parse(repr(number)) == number
    value = 0.0
    refusal = ""
    try:
        value = FRICTION.parse(text)
    except ValueError as error:
        refusal = str(error)
    assert 0.0 <= value <= 1e9
    assert refusal.isprintable()
    assert len(refusal) < 200


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
def test_a_value_far_from_the_usual(
    value: float, default: float | None, usual: tuple[float, float] | None, far: bool
):
    declared = Range("key", "m", 0.0, 1e9, default=default, usual=usual)
    assert bool(declared.unusual(value, value)) is far


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (
            lambda: Part(length=200.0),
            "length = 200 m is 400 times the default, 0.5 m; if it was meant in mm: length='200 mm'",
        ),
        (lambda: Part(length="200 m"), "length = 200 m is 400 times the default, 0.5 m"),
        (
            lambda: bs.Hub(speed=2500.0),
            "hub_speed = 2500 rad/s is 9.55 times the default, 261.8 rad/s; if it was meant in rpm: hub_speed='2500 rpm'",
        ),
        (
            lambda: bs.Belt(stiffness=0.00041),
            "belt_stiffness = 0.00041 N m/rad is 0.0175 times the default, 0.0234913 N m/rad; if it was meant in N m/deg:"
            " belt_stiffness='0.00041 N m/deg'",
        ),
    ],
)
def test_an_unusual_value_is_warned_of(make: Callable[[], object], line: str):
    with pytest.warns(UnusualValueWarning) as found:
        make()
    assert [str(each.message) for each in found] == [line]
    assert found[0].filename == __file__


def test_bounds_and_real_numbers():
    smallest = math.nextafter(0.0, 1.0)
    for accepted in (0.0, -0.0, smallest, 1e9, 5, np.float32(5), np.int64(5), Fraction(5)):
        checked = FRICTION.check(accepted)
        assert (type(checked), checked, math.copysign(1.0, checked)) == (float, accepted, 1.0)
    outside = (-smallest, math.nextafter(1e9, math.inf), math.inf, math.nan, 10**400, -(10**5000))
    for refused in (*outside, True, np.bool_(True), None, b"5", 5j, [5.0], np.array(5.0), "5"):
        with pytest.raises(ValueError, match=r"^friction = .*: must be a finite number"):
            FRICTION.check(refused)
    above = Range("bristle_length", "m", 0.0, 1e3, False, source="a source")
    assert above.check(smallest) == smallest
    with pytest.raises(ValueError, match="0 < bristle_length <= 1000"):
        above.check(0.0)
    with pytest.raises(
        ValueError, match=r"bristle_length = 1000\.0000000000001:"
    ):  # to its last digit
        above.check(math.nextafter(1e3, math.inf))


def test_a_part_checks_the_fields_it_declares():
    part = Part(length=np.float32(0.25), undeclared=-7)
    assert (type(part.length), part) == (float, Part(length="25 cm", undeclared=-7))
    assert (part.length, part.extra, part.word, part.links, part.undeclared) == (
        0.25,
        None,
        "one",
        1,
        -7,
    )
    for count_given in (8, 8.0, np.int64(8), "8.0"):
        assert (Part(links=count_given).links, type(Part(links=count_given).links)) == (8, int)
    with pytest.raises(ValueError, match="length"):
        dataclasses.replace(part, length=3e3)
    with pytest.raises(ValueError, match="word") as refusal:
        Choice("word", options=("one",)).parse("x" * 100_000)
    assert len(str(refusal.value)) < 150


@pytest.mark.parametrize("name", sorted(script_paths()))
def test_every_displayed_unit_has_the_size_of_its_name(name: str):
    """The table of displayed units against the unit library; a bare number in that unit is the typed one with it."""
    for declared in load_scenario(script_paths()[name]).keys().values():
        default = declared.default
        if isinstance(declared, Range) and declared.unit != "1":
            unit, size = declared.display
            # In this direction the library is asked, not the table.
            assert conversion(declared.unit, unit) == pytest.approx(1.0 / size, rel=1e-15)
            shown = declared.displayed(default)
            if default is not None and not declared.whole:
                assert shown.endswith(f" {unit}")
                assert declared.parse(shown) == pytest.approx(default, rel=5.1e-5)


@given(st.floats(1e-9, 10.0))
def test_a_written_number_with_a_unit_is_read_as_the_same_number(value: float):
    declared = declarations(Bristle)["length"]
    assert isinstance(declared, Range)
    assert declared.parse(exact_text(value, declared.key, declared.unit)) == value


@pytest.mark.parametrize(
    ("value", "key", "unit", "text"),
    [
        (0.027, "bristle_length", "m", "27 mm"),
        (5e-05, "compression_time", "s", "0.05 ms"),
        (0.0045, "penetration", "m", "4.5 mm"),
        (100.0 * math.pi, "hub_speed", "rad/s", "3000 rpm"),
        (261.8, "hub_speed", "rad/s", "261.8 rad/s"),
        (2e11, "wire_modulus", "Pa", "200 GPa"),
        (-0.1, "rate_1", "rad/s", "-0.1 rad/s"),
        (-12.5, "knee_angle_deg", "deg", "-12.5 deg"),
    ],
)
def test_a_number_is_written_as_an_engineer_writes_it(value: float, key: str, unit: str, text: str):
    assert exact_text(value, key, unit) == text


@pytest.mark.parametrize(
    ("number", "digits", "text"),
    [(1034.0, 3, "1030"), (27.94, 3, "27.9"), (0.0, 3, "0"), (1.5e-6, 3, "1.5e-06"), (2.5e9, 5, "2.5e+09"), (-999.6, 3, "-1000")],
)  # fmt: skip
def test_a_rounded_number_has_no_exponent_where_it_is_readable(
    number: float, digits: int, text: str
):
    assert plain_number(number, digits) == text
