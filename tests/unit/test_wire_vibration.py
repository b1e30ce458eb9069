"""The benchmark of a wire's free vibration: every method's error is that of its frequency."""

import math
import sys

import pytest

from benchmarks import wire_vibration
from benchmarks.wire_vibration import AMPLITUDE, FREQUENCY, in_elastica, in_mujoco, through_scene
from bristle_sim.parameters import Belt, Bristle
from bristle_sim.theory.wire import chain_frequencies


def error_of_the_chain(links: int) -> float:
    """sin(2 pi f_chain/f_beam), after a period of the beam."""
    wire = Bristle()
    shape = (wire.mass, wire.length, wire.wire_diameter, wire.modulus, Belt().stiffness)
    return (
        math.sin(math.tau * chain_frequencies(*shape, links)[1] / FREQUENCY)
        * FREQUENCY
        / (chain_frequencies(*shape, links)[1])
    )


@pytest.mark.parametrize("links", [2, 4])
def test_scene(links: int) -> None:
    """To the accuracy requested of the scene, 1e-6 of the fastest rates, over an amplitude of 1e-3: 1e-3."""
    assert through_scene(links, 1e-6)() / AMPLITUDE == pytest.approx(error_of_the_chain(links), abs=1e-3)


def test_mujoco() -> None:
    pytest.importorskip("mujoco")
    # 40 n^2 steps of fourth order: some 1e-7.
    assert in_mujoco(4, 40)() / AMPLITUDE == pytest.approx(error_of_the_chain(4), abs=1e-4)


def test_pyelastica() -> None:
    """Second order in the elements: a quarter of the error with twice as many, shear and turning sections apart, 1e-2."""
    pytest.importorskip("elastica")
    coarse, fine = (in_elastica(elements, 0.1)() / AMPLITUDE for elements in (8, 16))
    assert fine == pytest.approx(coarse / 4.0, abs=1e-2)


def test_the_table_has_a_line_for_each_method_that_is_there(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.setitem(sys.modules, "elastica", None)
    short = tuple(wire_vibration.vibrations(most=2))
    monkeypatch.setattr(wire_vibration, "vibrations", lambda: short)
    wire_vibration.main()
    head, scene, coarse, fine, *machine = capsys.readouterr().out.splitlines()
    assert head.split() == ["method", "pieces", "setting", "error", "CPU", "ms"]
    assert scene.startswith("pymunk scene, accuracy")
    # Fourth order: ten times the steps leave 1e-4 of the difference from the chain's own error.
    errors = [float(line.split()[-2]) for line in (coarse, fine)]
    assert errors[1] == pytest.approx(abs(error_of_the_chain(2)), rel=1e-2)
    assert any(line.startswith("versions: ") for line in machine)
