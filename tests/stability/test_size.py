"""Tools of any size behave alike, and the promises notice a program that depends on its units."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases import size
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.size import Scale, cases, dimensionless, scaled
from bristle_sim.parameters import Belt, Bristle, Contact, Tool, Workpart
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.tool import simulate
from bristle_sim.scene.units import Units
from bristle_sim.settings import Settings

UNITY = Scale(1.0, 1.0, 1.0)


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def test_sizes_promised() -> None:
    """The bristles named are those tried."""
    for name, scale in {**size.SCALES, **size.POWERS}.items():
        bristle = scaled(Tool(), scale).bristle
        length, unit, mass = name.replace(",", "").split()[:3]
        metres = float(length) * {"nm": 1e-9, "um": 1e-6, "m": 1.0}[unit]
        # Powers of two are named to two digits.
        tolerance = 0.05 if name in size.POWERS else 1e-12
        assert bristle.length == pytest.approx(metres, rel=tolerance)
        assert bristle.mass == pytest.approx(float(mass), rel=tolerance)


def dimensionless_groups(tool: Tool) -> np.ndarray:
    """Numbers without a unit that determine a pass."""
    bristle, bar, part = tool.bristle, tool.bar, tool.workpart
    assert bar is not None
    assert part is not None
    inertia = bristle.mass * bristle.length**2
    length, rate = bristle.length, tool.hub.speed
    return np.array(
        [
            tool.belt.stiffness / (inertia * rate**2),
            tool.gravity / (length * rate**2),
            tool.hub.radius / length,
            bristle.wire_diameter / length,
            bar.radius / length,
            bar.horizontal / length,
            bar.vertical / length,
            part.penetration / length,
            (tool.contact.duration or 0.0) * rate,
        ]
    )


@pytest.mark.parametrize("scale", [*size.SCALES.values(), *size.POWERS.values()])
def test_similar_tools_have_equal_groups(scale: Scale) -> None:
    tool = Tool(gravity=100.0, contact=Contact("compliant", 1e-6))
    groups = dimensionless_groups(tool)
    # Rounding.
    np.testing.assert_allclose(dimensionless_groups(scaled(tool, scale)), groups, rtol=1e-14)
    assert (groups > 0.0).all()


TOOLS = {
    "bent": Tool(bristle=Bristle(knee_angle_deg=15.0)),
    "damped": Tool(belt=Belt(damping_ratio=0.05)),
    "rubbing": replace(Tool(), bar=replace(size.TOOL.bar, friction=0.3, restitution=0.4)),  # type: ignore[type-var]
    "deep": Tool(workpart=Workpart(penetration=0.01, friction=0.0)),
}


@pytest.mark.parametrize("name", TOOLS)
def test_any_tool_scaled_by_powers_of_two(name: str) -> None:
    """To the last bit, whatever the powers."""
    rng = np.random.default_rng(len(name))
    scale = Scale(*(2.0 ** float(power) for power in rng.integers(-12, 9, size=3)))
    tool = TOOLS[name]
    first, second = (dimensionless(simulate(scaled(tool, each), stop_after="strike"), each) for each in (UNITY, scale))
    assert first == second


@pytest.mark.parametrize("seed", range(4))
def test_any_scale(seed: int) -> None:
    """Flights of any size, at every sample; steps are chosen by the same numbers to rounding."""
    rng = np.random.default_rng(seed)
    scale = Scale(10.0 ** rng.uniform(-5.0, 2.0), 10.0 ** rng.uniform(-10.0, 6.0), 10.0 ** rng.uniform(-2.0, 3.0))
    tool = replace(Tool(), bar=None, workpart=None)
    settings = Settings(accuracy=1e-10)
    runs = [simulate(scaled(tool, each), settings, start_relative_angle=-0.7) for each in (UNITY, scale)]
    ends = [
        np.array([run.relative_angle[-1], run.relative_rate[-1] * each.time / 1e3])
        for run, each in zip(runs, (UNITY, scale), strict=True)
    ]
    # Ten times the accuracy asked for.
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-9)


def test_a_scene_in_si_units_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine's tolerances are absolute: in other units than its own a scene is another one."""
    monkeypatch.setattr(scene_tool, "tool_units", lambda _: Units(1.0, 1.0, 1.0))
    names = ("0.82 um, 1.2e-12 kg: flight, two rods' strike", "1 um, 1e-12 kg: flight")
    found = [case for case in cases(full=False) if case.name in names]
    assert len(found) == len(names)
    assert not any(case.run().ok for case in found)


@pytest.mark.parametrize("forgotten", ["gravity", "penetration", "duration", "radius"])
def test_what_is_not_scaled_is_noticed(forgotten: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A number left 1e-6 off in the scaled tool."""
    similar = scaled

    def off(tool: Tool, scale: Scale) -> Tool:
        found = similar(tool, scale)
        if scale == UNITY:
            return found
        near = 1.0 + 1e-6
        if forgotten == "gravity":
            return replace(found, gravity=found.gravity * near)
        if forgotten == "penetration":
            assert found.workpart is not None
            return replace(found, workpart=replace(found.workpart, penetration=found.workpart.penetration * near))
        if forgotten == "duration":
            return replace(found, contact=replace(found.contact, duration=(found.contact.duration or 0.0) * near))
        return replace(found, hub=replace(found.hub, radius=found.hub.radius * near))

    monkeypatch.setattr(size, "scaled", off)
    (case,) = (case for case in cases(full=False) if case.name == "1 um, 1e-12 kg: strike in time")
    finding = case.measure()
    assert not finding.ok
    assert math.isfinite(float(finding.reached.split()[-1]))
