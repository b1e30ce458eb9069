"""Impossible work is refused in one line; studies that find a part say which part is missing, and draw the rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import (
    Bar,
    Belt,
    Bristle,
    Contact,
    ContactStiffness,
    Hub,
    Measurement,
    Neighbours,
    Strike,
    Surface,
    Tool,
    Workpart,
)
from bristle_sim.render.cost_figure import cost_figure
from bristle_sim.render.film import slow_motion
from bristle_sim.render.force_figures import whole_tool_figure
from bristle_sim.render.release_figures import inertia_figure
from bristle_sim.render.tool_films import pass_film, row_film
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.bar_search import strikes_of
from bristle_sim.studies.bent_bristles import bent_bristles, slide_measures
from bristle_sim.studies.cue_map import cue_map
from bristle_sim.studies.cue_timing import cue_timing
from bristle_sim.studies.flexible_wire import flexible_wire
from bristle_sim.studies.inertia_driven import inertia_driven
from bristle_sim.studies.neighbours import neighbours
from bristle_sim.studies.pass_invariants import invariant_rows
from bristle_sim.studies.strike_point import NotCuedError, strike_measures
from bristle_sim.studies.tolerances import Sampling, Spreads, tolerances
from bristle_sim.studies.whole_pass import whole_pass
from bristle_sim.studies.whole_tool import Assembly, periodic_turn, whole_tool
from bristle_sim.theory.force_fit import fit_force_history
from bristle_sim.tool_file import write_tool

OUT_OF_REACH = Tool(workpart=Workpart(penetration=-0.01))


AT_REST = Tool(hub=Hub(speed=0.0))
FLEXIBLE = Tool(bristle=Bristle(links=2))
UNBARRED = Tool(bar=None)


def row_of(tool: Tool, **row: float) -> object:
    return neighbours(tool, Neighbours(search="no", **row), Settings())


def struck(strike: Strike = Strike(), hub: Hub = Hub(), wire: Bristle = FLEXIBLE.bristle) -> object:  # noqa: B008
    return flexible_wire(hub, Belt(), wire, strike, Surface(0.0), ContactStiffness(), Settings())


REFUSALS = [
    (partial(slow_motion, 1.0, 1.0, 8.0), "^film of a run from 1 to 1: "),
    (partial(slow_motion, 0.0, 1.0, 0.0), "^duration = 0: must be"),
    (partial(slow_motion, 0.0, 1.0, 8.0, slower=0.5), "^slower = 0.5: must be"),
    (partial(cost_figure, SimpleNamespace(cases=())), "^cases = "),  # type: ignore[arg-type]
    (partial(write_tool, 3, "tool.toml"), "^tool = 3: must be a Tool"),  # type: ignore[arg-type]
    (partial(Sampling, samples=33), "^samples = 33: must be a power of 2"),
    (
        lambda: simulate(Tool(), Settings(hub_turn=0.1)).at(0.0, side="left"),
        "^side = 'left': must be before or after",
    ),
    (partial(whole_tool_figure, None), "^whole_tool: the bristle completes no turn"),
    (
        lambda: slide_measures(simulate(Tool(), stop_after="strike").contacts[-1]),
        "^contact = energetic: must be compliant",
    ),
    (lambda: bent_bristles(Tool(), Settings()), "^contact = energetic"),
    (lambda: bent_bristles(Tool(workpart=None), Settings()), "^contact = energetic"),
    (
        lambda: bent_bristles(
            Tool(contact=Contact("compliant", 1e-4)), Settings(maximum_steps=100)
        ),
        "step budget spent",
    ),
    (lambda: fit_force_history(np.linspace(0.0, 1.0, 50), np.zeros(50)), "no contact found"),
    (partial(cue_timing, UNBARRED, 0.7, Settings()), "bar, workpart"),
    (partial(cue_timing, FLEXIBLE, 0.7, Settings()), "^wire_links = 2: must be 1"),
    (partial(strikes_of, UNBARRED, Settings()), "bar, workpart: must both be parts"),
    (partial(cue_map, FLEXIBLE, Settings()), "^wire_links = 2: must be 1"),
    (lambda: driven(AT_REST), "^hub_speed = 0: must be above 0"),
    (
        lambda: driven(Tool(hub=Hub(speed=1e-12), belt=Belt(stiffness=1e8))),
        "^hub_speed = 1e-12: must be faster, or the",
    ),
    (lambda: driven(FLEXIBLE), "^wire_links = 2: must be 1"),
    (lambda: row_of(AT_REST), "^hub_speed = 0: must be above 0"),
    (lambda: row_of(FLEXIBLE), "^wire_links = 2: must be 1"),
    (
        lambda: row_of(Tool(hub=Hub(radius=1e-4))),
        "^hub_radius = .*: must be above half of wire_diameter",
    ),
    (lambda: row_of(Tool(), pitch_deg=1.0), "^pitch"),
    (lambda: row_of(Tool(), bristles=1), r"^bristles = 1.*: must be a whole number from 2 to 12"),
    (partial(periodic_turn, AT_REST, Settings()), "^hub_speed = 0: must be above 0"),
    (
        partial(whole_tool, Tool(workpart=None), Assembly(), Settings()),
        "^workpart = None: must be a Workpart",
    ),
    (partial(whole_tool, FLEXIBLE, Assembly(), Settings()), "^wire_links = 2: must be 1"),
    (lambda: UNBARRED.bar_reach, "^bar = None: must be a Bar where its reach"),
    (
        lambda: Tool(workpart=None).workpart_depth,
        "^workpart = None: must be a Workpart where its depth",
    ),
    (lambda: Measurement(__file__, force_per_volt=0.0), "^force_per_volt = 0: must be positive"),
    (lambda: Assembly(bristles=1.5), "^bristles = 1.5: must be a whole number"),
    (lambda: struck(Strike(impact_angle_deg=60.0)), "^impact_angle_deg = 60: must be less than 59"),
    (lambda: struck(Strike(impact_angle_deg=1e-12)), "it barely touches"),
    (lambda: struck(hub=Hub(speed=0.0)), "^hub_speed = 0: must be above 0"),
    (
        lambda: struck(wire=Bristle(wire_diameter=0.0, mass=1e-4, links=2)),
        "^wire_diameter = 0: must be above 0",
    ),
    (
        lambda: row_of(Tool(bristle=Bristle(wire_diameter=0.0, mass=1e-4))),
        "^wire_diameter = 0: must be above 0",
    ),
    *(
        (
            partial(
                tolerances, replace(Tool(), **{absent: None}), Spreads(), Sampling(), Settings()
            ),
            "must both be parts",
        )
        for absent in ("bar", "workpart")
    ),
]


@pytest.mark.parametrize(("call", "words"), REFUSALS)
def test_impossible_work_is_refused_in_one_line(call: Callable[[], object], words: str):
    with pytest.raises(ValueError, match=words) as refusal:
        call()
    assert "\n" not in str(refusal.value)


def driven(tool: Tool) -> Any:
    return inertia_driven(tool, Settings(), with_reference=False)


def test_a_row_out_of_reach_is_filmed_to_the_end():
    tool = replace(OUT_OF_REACH, bar=None)
    film = row_film(
        neighbours(tool, Neighbours(search="no", pitch_deg=60.0), Settings()).subject,
        width=160,
        height=120,
        duration=1.0,
    )
    assert film.move(1e-4)[0] == "turning with the hub"


def test_a_thrown_bristle_that_does_not_come_back_leaves_the_bar_cued_one_to_draw():
    creeping = Tool(belt=Belt(damping_ratio=1.5))
    figure = inertia_figure(driven(creeping).subject)
    assert [text.get_text().partition(":")[0] for text in figure.legends[0].texts] == ["bar-cued"]


@pytest.mark.parametrize(
    "tool",
    [
        OUT_OF_REACH,
        Tool(bar=None),
        Tool(bar=Bar(horizontal=0.058)),
        Tool(workpart=Workpart(friction=0.0, restitution=0.0)),
        Tool(hub=Hub(speed=0.0), belt=Belt(stiffness=0.0)),
        Tool(workpart=Workpart(penetration=0.0)),
    ],
    ids=["no strike", "no bar", "bar not touched", "no friction", "at rest", "no cut"],
)
def test_a_pass_is_told_by_what_happened_in_it(tool: Tool):
    """No number is made up for what did not happen, and none differs from theory for it."""
    report = whole_pass(
        tool, Settings(hub_turn=math.pi) if tool.hub.speed else Settings(hub_turn=1.0)
    )
    values = {row.name: row.simulated for row in report.quantities}
    struck = report.outcome != "no contact"
    assert (values["contact_time"] is not None) is struck
    assert (values["release_time"] is not None) is (tool.bar == Bar() and tool.hub.speed > 0.0)
    assert not [row.name for row in report.quantities if row.ok is False]


def test_a_strike_while_the_bar_is_touched_is_not_cued():
    run = simulate(Tool(), stop_after="strike")
    strike = run.first_contact("workpart")
    assert strike is not None
    contacts = [
        replace(each, duration=strike.time - each.time) if each.obstacle == "bar" else each
        for each in run.contacts
    ]
    pressed = replace(run, contacts=tuple(contacts))
    with pytest.raises(NotCuedError, match="must have left the bar when it strikes"):
        strike_measures(Tool(), pressed)
    invariants = {row.name: row.simulated for row in invariant_rows(Tool(), Settings(), pressed)}
    assert invariants["impulse_momentum_error"] is None
    smooth = Tool(workpart=Workpart(friction=0.0))  # cuts no crater
    assert strike_measures(smooth, simulate(smooth, stop_after="strike"))["crater_depth"] is None


def test_a_belt_without_stiffness_throws_nothing_back():
    found = driven(Tool(belt=Belt(stiffness=0.0), hub=Hub(radius=0.0)))
    assert {row.simulated for row in found.quantities} == {None}


def test_without_ffmpeg_a_film_can_be_a_gif(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="needs the extra video")

    def absent() -> str:
        raise RuntimeError("no ffmpeg exe")

    monkeypatch.setattr(ffmpeg, "get_ffmpeg_exe", absent)
    monkeypatch.setattr(ffmpeg, "write_frames", lambda *_, **__: absent())
    with pytest.raises(ValueError, match=r"ffmpeg for this machine: pip install .*, or a \.gif"):
        pass_film(simulate(Tool()), Tool(), duration=0.5).write(tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())
