"""Figures as files, numbers as texts."""

from __future__ import annotations

import math

import pytest
from PIL import Image

from bristle_sim.parameters import Tool
from bristle_sim.render.pass_figure import pass_figure
from bristle_sim.render.style import save_figure, scale_for, signed
from swinging_bristle import END, make_trajectory


def test_signed_has_no_negative_zero_and_a_real_minus():
    assert signed(-0.001, 2) == "0.00"
    assert signed(-12.345, 1, 6) == " \N{MINUS SIGN}12.3"


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_figures_are_written_whole_and_alike(tmp_path, suffix):
    figure = pass_figure(make_trajectory(), Tool(), until=END)
    first, second = (save_figure(figure, tmp_path / f"{name}{suffix}") for name in "ab")
    assert first.read_bytes() == second.read_bytes()
    assert sorted(each.name for each in tmp_path.iterdir()) == [f"a{suffix}", f"b{suffix}"]
    opening = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
    assert first.read_bytes().startswith(opening)
    if suffix == ".png":
        with Image.open(first) as picture:
            assert picture.width == pytest.approx(
                16.0 / 2.54 * 200.0, abs=1.0
            )  # px: 16 cm at 200 dots per inch


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [
        (1.2e-3, 1e3, "mN·s"),
        (0.592, 1e3, "mN·s"),
        (27.0, 1.0, "N·s"),
        (-4e6, 1e-6, "MN·s"),
        (1e-30, 1e15, "fN·s"),
        (0.0, 1.0, "N·s"),
        (math.inf, 1.0, "N·s"),
        (999.9999999, 1e-3, "kN·s"),
        (999.0, 1.0, "N·s"),
    ],
)
def test_scales_are_readable(largest: float, factor: float, unit: str) -> None:
    scale = scale_for(largest, "N·s")
    assert scale.unit == unit
    assert scale.factor == pytest.approx(factor, rel=1e-15)
