"""The links that a bristle is cut into: their masses, that they make the whole bristle again, and pairs that may touch."""

import itertools
import math

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import Units, build_tool, tool_units, wire_hinge, wire_links, wire_pairs
from bristle_sim.settings import Settings

SIZE = Units(0.027, 8.387e-5, 1.0)
"""The units that the links are in."""


@pytest.mark.parametrize("links", [1, 2, 3, 8, 64])
@pytest.mark.parametrize(
    ("position", "angle"), [(0.75, 0.0), (0.75, 30.0), (0.5, -90.0), (0.017, 45.0)]
)
def test_links_make_the_whole_bristle(links: int, position: float, angle: float) -> None:
    """Mass, centre of mass, inertia and tip are the bristle's when all links have one angle; lengths are equal.

    Rounding of the sums over 64 links, each of places of order 1 that were cut out of the path.
    """
    bristle = Bristle(links=links, knee_position=position, knee_angle_deg=angle)
    cut = wire_links(bristle)
    poses = Mechanism(cut).poses(State(0.0, (0.0,) * links, (0.0,) * links))
    mass = np.array([link.mass for link in cut])
    centre = np.array([pose.joint + pose.to_centre for pose in poses])
    inertia = sum(link.inertia for link in cut) + float(mass @ abs(centre) ** 2)
    assert mass == pytest.approx(np.full(links, 1.0 / links), rel=1e-11)
    assert mass @ centre == pytest.approx(complex(*bristle.centre) / SIZE.length, abs=1e-12)
    assert inertia * SIZE.mass * SIZE.length**2 == pytest.approx(
        bristle.inertia_about_root, rel=1e-12
    )
    tip = complex(*bristle.path[-1]) / SIZE.length
    assert poses[-1].corners[-1] == pytest.approx(tip, abs=1e-12)
    for link in cut:
        length = sum(abs(b - a) for a, b in itertools.pairwise(link.corners))
        assert length == pytest.approx(1.0 / links, rel=1e-10)
    # A knee is inside a link, unless it is at a joint.
    at_joint = math.isclose(position * links, round(position * links))
    assert sum(len(link.corners) - 2 for link in cut) == (0 if angle == 0.0 or at_joint else 1)


def test_hinges() -> None:
    """k = E I_a n/L = 2e11 pi 7.1e-4^4/64 8/0.027 = 0.739 N m/rad, c = 2 zeta k/omega_1 with the beam's 3062.1 Hz."""
    assert build_tool(Tool())[0].effects.hinge == (0.0, 0.0)
    hinge = wire_hinge(Bristle(links=8, bending_damping_ratio=0.1), math.degrees(0.00041), SIZE)
    stiffness = 2e11 * math.pi * 7.1e-4**4 / 64.0 * 8.0 / 0.027
    damping = 0.2 * stiffness / (math.tau * 3062.10)
    assert hinge == pytest.approx(
        (stiffness / SIZE.energy, damping / SIZE.angular_damping), rel=5e-6
    )


def test_pairs_are_of_different_wires() -> None:
    bent = Link(0.5, 0.01, -0.2j, (0j, -0.3j, 0.1 - 0.5j))
    row = Mechanism((Link.rod(0.5, 0.5), bent) * 2, wires=2, pitch=0.3, hub_radius=1.0)
    pairs = list(wire_pairs(row, 0.01, 0.1, 0.2))
    # Root, joint, knee and tip of either wire with the three pieces of the other wire.
    assert len(pairs) == 24
    assert len({(each.link, each.corner) for each in pairs}) == 8
    assert {(each.link // 2, each.partner // 2) for each in pairs} == {(0, 1), (1, 0)}


def test_a_contact_that_passes_the_end_of_a_wire_keeps_its_accuracy() -> None:
    """The bar's contact leaves the flank for the round tip: the force has a kink there, which no step may span.

    Two accuracies agree within the coarser one. With steps across the kink they would differ by 1e-5.
    """
    tool = Tool().replace(wire_links=3, bar_friction=0.1)
    coarse, fine = (
        simulate(tool, Settings(accuracy=accuracy), stop_after="strike")
        for accuracy in (1e-7, 1e-8)
    )
    difference = abs(coarse.rates[-1] - fine.rates[-1]).max() * tool_units(tool).time
    assert difference < 1e-7
    # The second touch, 1e4 times as slow as the first, stays: the contact's force undoes what a later instant changes.
    # Two fast impacts follow it, each of which makes an error of 1e-8 some twenty times as large.
    assert fine.cost.error_estimate is not None
    assert difference < fine.cost.error_estimate < 1e-5


def test_a_link_behind_a_joint_in_contact_is_no_contact_of_its_own() -> None:
    """The bar meets two links at the joint that they share. Both ends are there; only one of them has an impulse."""
    tool = Tool().replace(
        wire_links=4,
        bar_friction=0.2,
        bar_radius=7.535824544713403e-3,
        bar_horizontal=0.040035714388847114,
        bar_vertical=0.012160009303146826,
    )
    run = simulate(tool, Settings(accuracy=1e-4), stop_after="strike")
    assert len(run.contacts) > 10
    assert all(contact.impulse[0] > 0.0 for contact in run.contacts)
