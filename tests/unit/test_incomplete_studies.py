"""Studies that find a part of what they look for: they say what is missing, and draw the rest."""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.contact_space.jacobian import joint_rows
from bristle_sim.parameters import Bar, Belt, Hub, Neighbours, Tool, Workpart
from bristle_sim.reference.strike import strike_reference
from bristle_sim.render.inertia_figure import inertia_figure
from bristle_sim.render.tool_films import inertia_film, row_film
from bristle_sim.render.whole_tool_figure import whole_tool_figure
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.bent_bristles import slide_of
from bristle_sim.studies.cue_map import MapGrid, position_map
from bristle_sim.studies.inertia_driven import inertia_driven
from bristle_sim.studies.neighbours import neighbours
from bristle_sim.studies.strike_point import NotCuedError, start_angle, strike_measures
from bristle_sim.studies.tolerances import Sampling, Spreads, sobol_study, tolerances
from bristle_sim.studies.whole_pass import whole_pass
from bristle_sim.theory.force_fit import fit_force_history

OUT_OF_REACH = Tool(workpart=Workpart(penetration=-0.01))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (functools.partial(start_angle, Tool(bar=None)), "bar = None: must be a Bar"),
        (functools.partial(joint_rows, object(), {}), "object: must be a joint"),
        (functools.partial(whole_tool_figure, None), "whole_tool: the bristle completes no turn"),
        (
            functools.partial(strike_reference, Tool(), 0.0, (0.0,), (0.0,), stiffness=0.0, longest=1.0),
            "stiffness = 0: must be",
        ),
        (
            lambda: slide_of(simulate(Tool(), stop_after="strike").contacts[-1]),
            "contact = energetic: must be compliant",
        ),
        (
            lambda: inertia_film(inertia_driven(OUT_OF_REACH, Settings(), with_reference=False).subject),
            "the bristle must strike with the bar",
        ),
        (lambda: fit_force_history(np.linspace(0.0, 1.0, 50), np.zeros(50), start=0.2), "be above 0"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(call, words: str):
    with pytest.raises(ValueError, match=words) as refusal:
        call()
    assert "\n" not in str(refusal.value)


def test_a_row_out_of_reach_is_filmed_to_the_end():
    tool = dataclasses.replace(OUT_OF_REACH, bar=None)
    film = row_film(
        neighbours(tool, Neighbours(search="no", pitch_deg=60.0), Settings()).subject,
        width=160,
        height=120,
        duration=1.0,
    )
    assert film.move(1e-4)[0] == "turning with the hub"


def test_a_thrown_bristle_that_does_not_come_back_leaves_the_bar_cued_one_to_draw():
    creeping = Tool(belt=Belt(damping_ratio=1.5))
    figure = inertia_figure(inertia_driven(creeping, Settings(), with_reference=False).subject)
    assert [line.get_label() for line in figure.axes[0].lines if not line.get_label().startswith("_")] == ["bar-cued"]


@pytest.mark.parametrize(
    "tool",
    [
        OUT_OF_REACH,
        Tool(bar=None),
        Tool(bar=Bar(horizontal=0.058)),
        Tool(workpart=Workpart(friction=0.0, restitution=0.0)),
        Tool(hub=Hub(speed=0.0), belt=Belt(stiffness=0.0)),
    ],
    ids=["no strike", "no bar", "bar not touched", "no friction", "at rest"],
)
def test_a_pass_is_told_by_what_happened_in_it(tool: Tool):
    """No number is made up for what did not happen, and none differs from theory for it."""
    report = whole_pass(tool, Settings(hub_turn=math.pi) if tool.hub.speed else Settings(hub_turn=1.0))
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
        dataclasses.replace(each, duration=strike.time - each.time) if each.obstacle == "bar" else each
        for each in run.contacts
    ]
    with pytest.raises(NotCuedError, match="must have left the bar when it strikes"):
        strike_measures(Tool(), dataclasses.replace(run, contacts=tuple(contacts)))


@pytest.mark.parametrize("absent", ["bar", "workpart"])
def test_tolerances_need_bar_and_workpart(absent: str):
    with pytest.raises(ValueError, match="bar, workpart: must both be parts of the tool"):
        tolerances(dataclasses.replace(Tool(), **{absent: None}), Spreads(), Sampling(), Settings())


def test_a_belt_without_stiffness_throws_nothing_back():
    found = inertia_driven(Tool(belt=Belt(stiffness=0.0), hub=Hub(radius=0.0)), Settings(), with_reference=False)
    assert {row.simulated for row in found.quantities} == {None}


@pytest.mark.parametrize(
    "call",
    [
        lambda: position_map(Tool(), Settings(), MapGrid(points=2.0)),
        lambda: sobol_study(lambda x: {"y": x}, {"x": (0.0, 1.0)}, ("y",), 2),
    ],
)
def test_without_the_extra_a_sweep_says_what_to_install(call, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "bristle_sim.studies.sweep", None)
    with pytest.raises(ValueError, match=r"need the extra sweep: pip install bristle-sim\[sweep\]"):
        call()


def test_without_ffmpeg_a_film_can_be_a_gif(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="needs the extra video")

    def absent() -> str:
        raise RuntimeError("no ffmpeg exe")

    monkeypatch.setattr(ffmpeg, "get_ffmpeg_exe", absent)
    monkeypatch.setattr(ffmpeg, "write_frames", lambda *_, **__: absent())
    with pytest.raises(ValueError, match=r"ffmpeg for this machine: pip install .*, or a \.gif"):
        inertia_film(inertia_driven(Tool(), Settings(), with_reference=False).subject, duration=0.5).write(
            tmp_path / "film.mp4"
        )
    assert not list(tmp_path.iterdir())
