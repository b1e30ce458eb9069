"""Pictures: what the artists hold is what the run says, and files are complete or absent."""

from __future__ import annotations

import ast
import dataclasses
import io
import itertools
import math
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.text import Text
from PIL import Image

from bristle_sim.parameters import Bar, Bristle, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.render import motion as motion_module
from bristle_sim.render import video
from bristle_sim.render.motion import Motion
from bristle_sim.render.pass_figure import LABEL_SLANT, pass_figure, spread
from bristle_sim.render.pass_video import PassScene, pass_video
from bristle_sim.render.readout import Readout
from bristle_sim.render.story import key_events, phase_at, phases, story_end
from bristle_sim.render.style import blank_figure, save_figure, signed
from bristle_sim.render.time_warp import slow_motion
from bristle_sim.render.tool_drawing import close_up, wire_outline
from bristle_sim.render.video import Stage, write_video
from bristle_sim.scene.tool import simulate
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory

FREQUENCY, AMPLITUDE = 1100.0, 0.7
STRIKE, END = 1.4e-3, 2.5e-3
HUB_START = -0.75


def swing(time):
    """Angle and rate relative to the hub: a harmonic from a lag of 0.7 rad, reflected at the strike."""
    later = 2.0 * STRIKE - time
    before = -AMPLITUDE * np.cos(FREQUENCY * time), AMPLITUDE * FREQUENCY * np.sin(FREQUENCY * time)
    after = -AMPLITUDE * np.cos(FREQUENCY * later), -AMPLITUDE * FREQUENCY * np.sin(FREQUENCY * later)
    return before, after


def straight_wire(tool, hub, angle, rate):
    """Root and tip, and their velocities, by (sin, -cos) and its derivative (cos, sin)."""
    arm, root = tool.bristle.length, tool.hub.radius
    places = [root * np.array([np.sin(hub), -np.cos(hub)])]
    places.append(places[0] + arm * np.array([np.sin(angle), -np.cos(angle)]))
    velocities = [root * tool.hub.speed * np.array([np.cos(hub), np.sin(hub)])]
    velocities.append(velocities[0] + arm * rate * np.array([np.cos(angle), np.sin(angle)]))
    return np.moveaxis(places, -1, 0), np.moveaxis(velocities, -1, 0)


def make_trajectory(samples: int = 60, events: tuple[Event, ...] | None = None) -> Trajectory:
    """A run in closed form, with two samples at the strike's instant."""
    tool = Tool()
    first, second = np.linspace(0.0, STRIKE, samples), np.linspace(STRIKE, END, samples)
    time = np.concatenate([first, second])
    alpha = np.concatenate([swing(first)[0][0], swing(second)[1][0]])
    rate = np.concatenate([swing(first)[0][1], swing(second)[1][1]])
    hub = HUB_START + tool.hub.speed * time
    angle, absolute = hub + alpha, rate + tool.hub.speed
    lines, velocities = straight_wire(tool, hub, angle, absolute)
    named = (Event("bar release", 0.2e-3), Event("strike", STRIKE), Event("largest retraction", 2.3e-3))
    return Trajectory(
        time=time,
        hub_angle=hub,
        angles=angle[:, None],
        rates=absolute[:, None],
        centre_line=lines,
        centre_line_velocity=velocities,
        kinetic_energy=0.5 * tool.bristle.inertia_about_root * absolute**2,
        potential_energy=0.5 * tool.belt.stiffness * alpha**2,
        normal_force=np.zeros_like(time),
        hub_speed=tool.hub.speed,
        events=named if events is None else events,
        contacts=(make_contact(angle[samples], absolute[samples - 1], absolute[samples]),),
        stop_reason=StopReason.END,
        cost=Cost(0.0, 0.0, 1),
    )


def make_contact(angle, before, after, outcome="rebound"):
    return ContactRecord(
        obstacle="workpart",
        law="energetic",
        outcome=outcome,
        time=STRIKE,
        duration=0.0,
        impulse=(2e-3, -1e-3),
        compressive_impulse=None,
        compressive_work=None,
        restitutive_work=None,
        velocity_before=(-10.0, 20.0),
        velocity_after=(4.0, -8.0),
        angles=(float(angle),),
        rates_before=(float(before),),
        rates_after=(float(after),),
    )


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return make_trajectory()


@pytest.fixture(scope="module")
def figure(run):
    return pass_figure(run, Tool(), until=END)


def artist(owner, gid):
    (found,) = owner.findobj(lambda each: each.get_gid() == gid)
    return found


# Motion between samples


def test_motion_between_samples_is_the_cubic_that_theory_bounds(run):
    time = np.linspace(0.0, STRIKE, 1001)[1:-1]
    step = STRIKE / 59.0
    # Hermite's cubic is off by at most h^4/384 max|f''''|, here A w^4; twice that leaves room for rounding.
    bound = 2.0 * step**4 / 384.0 * AMPLITUDE * FREQUENCY**4
    assert np.abs(Motion(run).retraction(time) + swing(time)[0][0]).max() < bound
    assert np.abs(Motion(run).hub_angle(time) - (HUB_START + 261.8 * time)).max() < 1e-12  # linear: rounding alone


def test_motion_has_both_speeds_of_an_impact(run):
    motion = Motion(run)
    before, after = (float(np.hypot(*run.tip_velocity[at])) for at in (59, 60))
    assert before > after
    assert motion.tip_speed(math.nextafter(STRIKE, 0.0)) == pytest.approx(before, rel=1e-9)  # samples are met: rounding
    assert motion.tip_speed(STRIKE) == pytest.approx(after, rel=1e-9)


def test_motion_stays_at_its_ends_outside_the_run(run):
    motion = Motion(run)
    assert motion.retraction(-1.0) == run.retraction[0]
    assert motion.retraction([5.0, 6.0]) == pytest.approx(run.retraction[-1], rel=1e-12)
    assert motion.centre_line(5.0) == pytest.approx(run.centre_line[-1], rel=1e-12)


def test_motion_needs_two_instants(run):
    arrays = {name: getattr(run, name)[:1] for name in run.__slots__ if isinstance(getattr(run, name), np.ndarray)}
    single = Trajectory(**arrays, hub_speed=1.0, events=(), contacts=(), stop_reason=StopReason.END, cost=run.cost)
    with pytest.raises(ValueError, match="two instants are needed"):
        Motion(single)


def test_course_keeps_every_sample_and_both_sides_of_the_impact(run):
    motion = Motion(run)
    course = motion.course(points=500)
    assert np.isin(run.time, course.time).all()
    assert np.count_nonzero(course.time == STRIKE) == 2
    assert (np.diff(course.time) >= 0.0).all()
    energy = motion.along(course.time, run.total_energy)
    # Both go through the samples; between them only their spacing differs.
    assert energy[np.searchsorted(course.time, run.time[:59])] == pytest.approx(run.total_energy[:59], rel=1e-12)


def test_course_ends_where_asked_and_refuses_an_end_before_the_start(run):
    assert Motion(run).course(until=1e-3).time[-1] <= 1e-3
    for until in (0.0, math.nan):
        with pytest.raises(ValueError, match="until = "):
            Motion(run).course(until=until)


def test_energies_between_samples_are_as_smooth_as_the_motion():
    """Belt energy (k A^2/4)(1 + cos 2wt): a cubic spline is off by 5/384 h^4 (2w)^4 of its half size (de Boor 2001)."""
    run = make_trajectory(samples=24)
    motion = Motion(run)
    time = motion.course().time
    before = time < STRIKE
    size = 0.5 * Tool().belt.stiffness * AMPLITUDE**2
    expected = size * np.cos(FREQUENCY * time[before]) ** 2
    step = STRIKE / 23.0
    # At its ends the not-a-knot condition leaves some ten times that.
    bound = 10.0 * 5.0 / 384.0 * (2.0 * FREQUENCY * step) ** 4 * 0.5 * size
    assert np.abs(motion.along(time, run.potential_energy)[before] - expected).max() < bound


def test_energies_have_their_kinks_where_contacts_begin_and_end():
    """A ramp that sets in with a sustained contact is met exactly by splines that end there."""
    run = make_trajectory()
    begin = float(run.time[20])
    held = dataclasses.replace(run.contacts[0], time=begin, duration=float(run.time[40]) - begin, law="hold")
    motion = Motion(dataclasses.replace(run, contacts=(held,)))
    time = motion.course().time
    ramp = np.clip(run.time - begin, 0.0, held.duration)
    expected = np.clip(time - begin, 0.0, held.duration)
    assert np.abs(motion.along(time, ramp) - expected).max() < 1e-15  # s; rounding of 1e-3


# What a picture shows is the recorded centre line


def kinked(run: Trajectory, corners: int = 5) -> Trajectory:
    """The same run with a centre line that no tool has: four links at odd angles, and with its own velocities."""
    spread_out = np.linspace(0.0, 1.0, corners)[:, None] ** [1.0, 1.7]
    root, tip = run.centre_line[:, :1], run.centre_line[:, 1:]
    lines = root + (0.8 * tip - root) * spread_out
    velocities = (
        run.centre_line_velocity[:, :1] * (1.0 - spread_out) + 0.8 * run.centre_line_velocity[:, 1:] * spread_out
    )
    return dataclasses.replace(run, centre_line=lines, centre_line_velocity=velocities)


def middle(outline: np.ndarray) -> np.ndarray:
    """The corners of the centre line that an outline runs about, mm: the mean of its left and its right side."""
    half = len(outline) // 2
    left, right = outline[:half], outline[half : 2 * half][::-1]
    return 0.5 * (left + right)


def test_pictures_show_the_recorded_centre_line_and_nothing_of_their_own(run):
    """Of whatever shape: were any length, knee or angle of the tool used, wire and record would part."""
    odd = kinked(run)
    figure = pass_figure(odd, Tool(), until=END)
    for number, event in enumerate(key_events(odd), start=1):
        for wire in figure.findobj(lambda each, number=number: each.get_gid() == f"wire {number}"):
            shown = middle(wire.get_xy()[:-1])
            # A wire that ends an interval is a sample; the others lie between two: Hermite's cubic, as above.
            assert shown == pytest.approx(1e3 * Motion(odd).centre_line(event.time), abs=1e-9)
    path = np.concatenate([artist(figure, name).get_xydata() for name in ("tip path", "tip path after the strike")])
    for sample in 1e3 * odd.tip:
        assert np.hypot(*(path - sample).T).min() < 1e-9  # mm: every recorded tip is on the path
    scene = PassScene(odd, Tool(), width=320, height=240, duration=1.0, until=END)
    for number in (10, 30, 60, 100):
        scene.show(float(scene.warp.film_time(odd.time[number])))
        shown = middle(scene.wire.wire.get_xy()[:-1])
        # The warp's inverse is linear between 4001 nodes: an instant off by rounding, times 40 m/s.
        assert shown == pytest.approx(1e3 * odd.centre_line[number], abs=1e-6)
        assert scene.trail.get_xydata()[-1] == pytest.approx(1e3 * odd.tip[number], abs=1e-6)


WIRE_DRAWINGS = (
    "motion",
    "tool_drawing",
    "pass_figure",
    "pass_video",
    "cue_figure",
    "chain_drawing",
    "contact_closeup",
)


@pytest.mark.parametrize("module", WIRE_DRAWINGS)
def test_what_draws_wires_knows_no_lengths_knees_or_link_angles(module):
    """Kinematics need them; a picture is given points."""
    tree = ast.parse((Path(motion_module.__file__).parent / f"{module}.py").read_text(encoding="utf-8"))
    read = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    assert not read & {"length", "lengths", "path", "knee_angle_deg", "knee_position", "links", "angles"}


@pytest.fixture(scope="module", params=[-30.0, 0.0, 30.0, 45.0])
def bent(request) -> tuple[Tool, Trajectory]:
    """A pass of a bent bristle up to its strike, in the scene."""
    tool = Tool(bristle=Bristle(knee_angle_deg=request.param))
    return tool, simulate(tool, stop_after="strike")


def test_a_bent_wire_touches_the_bar_and_strikes_the_workpart_in_the_picture(bent):
    tool, run = bent
    figure = pass_figure(run, tool)
    numbers = {event.name: number for number, event in enumerate(key_events(run), start=1)}
    struck = middle(artist(figure, f"wire {numbers['strike']}").get_xy()[:-1])
    assert struck[-1] == pytest.approx(1e3 * run.tip[-1], abs=1e-9)
    assert struck[-1, 1] == pytest.approx(-1e3 * tool.workpart_depth, abs=1e-6)  # mm; where the touch is located
    touching = middle(artist(figure, f"wire {numbers['bar touch']}").get_xy()[:-1])
    distance = min(_distance(1e3 * np.array(tool.bar.centre), *piece) for piece in itertools.pairwise(touching))
    assert distance == pytest.approx(1e3 * tool.bar_reach, abs=1e-6)
    speed = math.hypot(*run.first_contact("workpart").velocity_before)
    written = "\n".join(each.get_text() for each in figure.findobj(Text))
    assert f"tip arrives at {speed:.2f} m/s" in written
    assert Motion(run).tip_speed(math.nextafter(run.time[-1], 0.0)) == pytest.approx(speed, rel=1e-9)


def _distance(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    """Of a point from a straight piece of wire."""
    along = end - start
    share = min(max(float((point - start) @ along / (along @ along)), 0.0), 1.0)
    return float(np.hypot(*(point - start - share * along)))


def test_the_bent_wire_is_as_long_as_it_is_and_moves_as_it_is_drawn(bent):
    tool, run = bent
    pieces = np.diff(run.centre_line, axis=1)
    lengths = np.hypot(pieces[..., 0], pieces[..., 1])
    assert lengths.sum(axis=1) == pytest.approx(np.full(run.time.size, tool.bristle.length), rel=1e-12)
    motion, step = Motion(run), 1e-8
    time = 0.5 * (run.time[5] + run.time[6])
    ends = [motion.centre_line(time + shift)[-1] for shift in (-step, step)]
    # The central difference of a cubic is off by h^2 and rounding, 1e-17 m / 1e-8 s of 20 m/s.
    assert motion.tip_speed(time) == pytest.approx(np.hypot(*(ends[1] - ends[0])) / (2.0 * step), rel=1e-7)


def test_scene_and_reference_agree_on_the_centre_line():
    """Written by each from its own kinematics; compared at the strike, where both have a sample."""
    tool = Tool(bristle=Bristle(knee_angle_deg=-30.0))
    run, other = simulate(tool, stop_after="strike"), simulate_reference(tool, accuracy=1e-9, stop_after="strike")
    assert run.centre_line.shape[1:] == other.centre_line.shape[1:] == (3, 2)
    before = [np.flatnonzero(each.time == each.first_contact("workpart").time)[0] for each in (run, other)]
    places = [each.centre_line[at] for each, at in zip((run, other), before, strict=True)]
    velocities = [each.centre_line_velocity[at] for each, at in zip((run, other), before, strict=True)]
    # Accuracy 1e-6, magnified tenfold as elsewhere: of 55 mm and 40 m/s.
    assert places[0] == pytest.approx(places[1], abs=1e-5 * 0.055)
    assert velocities[0] == pytest.approx(velocities[1], abs=1e-5 * 40.0)


# The figure


def test_lines_hold_the_samples(figure, run):
    lag, rate = artist(figure, "retraction"), artist(figure, "relative speed")
    at = [int(np.flatnonzero(np.isclose(lag.get_xdata(), 1e3 * time, atol=1e-12))[0]) for time in run.time[:60]]
    assert lag.get_ydata()[at] == pytest.approx(-np.degrees(run.relative_angle[:60]), abs=1e-9)
    assert rate.get_ydata()[at[:-1]] == pytest.approx(run.relative_rate[:59], abs=1e-6)  # rad/s of 770
    assert lag.get_xdata()[-1] == pytest.approx(1e3 * run.time[-1])


def test_rate_line_jumps_at_the_strike(figure):
    rate = artist(figure, "relative speed")
    jump = rate.get_ydata()[np.isclose(rate.get_xdata(), 1e3 * STRIKE, atol=1e-12)]
    expected = AMPLITUDE * FREQUENCY * math.sin(FREQUENCY * STRIKE)
    assert jump == pytest.approx([expected, -expected], rel=1e-9)


def test_paths_meet_at_the_strike(figure, run):
    struck = 1e3 * run.tip[60]
    assert artist(figure, "tip path").get_xydata()[-1] == pytest.approx(struck, abs=1e-9)
    assert artist(figure, "tip path after the strike").get_xydata()[0] == pytest.approx(struck, abs=1e-9)


def test_ghost_ends_at_the_tip(figure, run):
    number = 1 + [event.name for event in key_events(run)].index("strike")
    outline = artist(figure, f"wire {number}").get_xy()
    assert 0.5 * (outline[1] + outline[2]) == pytest.approx(1e3 * run.tip[60], abs=1e-9)
    assert np.hypot(*(outline[1] - outline[2])) == pytest.approx(0.71, rel=1e-9)  # mm, the wire's diameter


def test_drawing_is_to_scale(figure):
    (left, right), (bottom, top) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    box = figure.axes[0].get_window_extent()
    assert (right - left) / box.width == pytest.approx((top - bottom) / box.height, rel=1e-6)


def overlaps(figure) -> list[tuple[str, str]]:
    """Texts that are written over each other, but for slanted ones, whose boxes say little."""
    figure.draw_without_rendering()
    scales = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    ticks = {id(each) for axis in scales for each in axis.findobj(Text) if each is not axis.label}
    texts = [each for each in figure.findobj(Text) if each.get_text().strip() and id(each) not in ticks]
    boxes = [(each.get_text(), each.get_window_extent()) for each in texts if each.get_rotation() % 90.0 == 0.0]
    pairs = itertools.combinations(boxes, 2)
    return [(one, other) for (one, box), (other, second) in pairs if box.shrunk(0.98, 0.9).overlaps(second)]


@pytest.mark.parametrize("penetration", [0.0045, -0.003])
def test_texts_keep_clear_of_each_other_with_and_without_a_strike(penetration):
    tool = Tool(workpart=Workpart(penetration=penetration))
    figure = pass_figure(simulate(tool), tool)
    assert overlaps(figure) == []
    written = {each.get_text() for each in figure.findobj(Text)}
    colours = {"tip path until the strike", "tip path after it"} if penetration > 0.0 else {"tip path"}
    assert colours | {"wire, in the colour of its instant", "root in the belt"} <= written


def test_every_event_is_labelled_and_every_text_is_on_the_page(figure, run):
    written = {each.get_text() for each in figure.findobj(Text)}
    assert {f"{number} {event.name}" for number, event in enumerate(key_events(run), start=1)} <= written
    # The box of all that is drawn, in inches; what axes clip does not count.
    drawn, page = figure.get_tightbbox(), figure.get_size_inches()
    assert (drawn.min >= 0.0).all()
    assert (drawn.max <= page).all()


def test_labels_of_a_crowd_of_events_keep_apart():
    names = ("bar touch", "bar release", "largest retraction", "strike", "highest relative speed", "jam")
    crowd = make_trajectory(events=tuple(Event(name, STRIKE + number * 1e-8) for number, name in enumerate(names)))
    figure = pass_figure(crowd, Tool())
    slanted = [each for each in figure.findobj(Text) if each.get_rotation() == LABEL_SLANT]
    slanted.sort(key=lambda each: each.get_position()[0])
    across = [each.get_transform().transform(each.get_position())[0] for each in slanted]
    between = np.diff(across) * math.sin(math.radians(LABEL_SLANT))
    assert len(slanted) == 1 + len(names)  # the start, away from the radial direction, is labelled too
    assert between.min() > slanted[0].get_fontsize() * figure.dpi / 72.0  # a line's distance is more than a letter size


def test_a_run_without_a_strike_or_obstacles_is_drawn():
    run = make_trajectory(events=(Event("highest relative speed", STRIKE),))
    bare = Trajectory(**{**{name: getattr(run, name) for name in run.__slots__}, "contacts": ()})
    written = {each.get_text() for each in pass_figure(bare, Tool(bar=None, workpart=None)).findobj(Text)}
    assert "no strike; the run ended:" in written
    assert not {"bar", "workpart"} & written


@given(st.lists(st.floats(0.0, 1.0), max_size=8).map(sorted))
def test_spread_keeps_gap_order_and_bounds(positions):
    moved = spread(positions, 0.1, 0.0, 1.0)
    assert (np.diff(moved) >= 0.1 - 1e-12).all()
    assert ((moved >= -1e-12) & (moved <= 1.0 + 1e-12)).all()


def test_spread_leaves_alone_what_is_apart():
    assert spread([0.1, 0.4, 0.9], 0.2, 0.0, 1.0) == pytest.approx([0.1, 0.4, 0.9])
    assert spread([0.5, 0.5], 0.2, 0.0, 1.0) == pytest.approx([0.4, 0.6])


def test_close_up_holds_wire_bar_and_surface_at_the_aspect_asked_for(run):
    tool, course = Tool(), Motion(run).course()
    view = close_up(course, tool, 1.5)
    assert (view.right - view.left) / (view.top - view.bottom) == pytest.approx(1.5)
    assert view.left < 1e3 * min(run.tip[:, 0].min(), -tool.bar.horizontal - tool.bar.radius)
    assert view.bottom < -1e3 * tool.workpart_depth < view.top


def test_wire_outline_is_a_rectangle_about_the_centre_line():
    corners = wire_outline(np.array([[0.0, 0.0], [3.0, 4.0]]), 0.5)
    assert corners.mean(axis=0) == pytest.approx([1.5, 2.0])
    sides = np.hypot(*np.diff(np.vstack([corners, corners[:1]]), axis=0).T)
    assert sides == pytest.approx([5.0, 0.5, 5.0, 0.5])


def test_wire_outline_is_mitred_at_a_knee():
    """Two pieces at a right angle: the corners stand half a diameter from both, at the root of 2 from the knee."""
    corners = wire_outline(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]), 1.0)
    assert corners == pytest.approx(
        np.array([[0.0, 0.5], [3.5, 0.5], [3.5, 3.0], [4.5, 3.0], [4.5, -0.5], [0.0, -0.5]])
    )


# The story


def test_key_events_take_the_release_that_throws_and_the_first_of_the_rest():
    times = {"bar touch": (1.0, 2.0), "bar release": (1.5, 3.0), "strike": (4.0,), "workpart touch": (5.0, 6.0)}
    events = sorted((Event(name, 1e-4 * time) for name in times for time in times[name]), key=lambda each: each.time)
    chosen = [(event.name, round(1e4 * event.time)) for event in key_events(make_trajectory(events=tuple(events)))]
    assert chosen == [("bar touch", 1), ("bar release", 3), ("strike", 4), ("workpart touch", 5)]


def test_captions_tell_held_from_bounced():
    events = (Event("bar touch", 1e-4), Event("bar release", 2e-4), Event("bar touch", 3e-4), Event("strike", STRIKE))
    told = phases(make_trajectory(events=events), strike_shown=1e-4)
    captions = [phase_at(told, time).caption for time in (0.0, 1.5e-4, 2.5e-4, 4e-4, STRIKE, STRIKE + 2e-4)]
    thrown = "released: the belt throws the tip"
    assert captions == [thrown, "held back by the bar", thrown, "bounces off the bar", "strike", "rebound"]


def test_a_release_in_the_instant_of_a_touch_is_a_bounce():
    events = (
        Event("bar touch", 1e-4),
        Event("bar release", 1e-4),
        Event("bar touch", 2e-4),
        Event("bar release", 3e-4),
    )
    run = make_trajectory(events=(*events, Event("strike", STRIKE), Event("workpart release", STRIKE)))
    assert [event.name for event in key_events(run)] == ["bar touch", "bar release", "strike"]
    captions = [phase_at(phases(run, strike_shown=1e-4), time).caption for time in (1.5e-4, 2.5e-4, STRIKE + 2e-4)]
    assert captions == ["bounces off the bar", "held back by the bar", "rebound"]


def test_story_ends_soon_after_the_last_touch_or_with_the_run(run):
    assert story_end(run) == pytest.approx(1.12 * STRIKE)
    assert story_end(make_trajectory(events=())) == END


def test_signed_has_no_negative_zero_and_a_real_minus():
    assert signed(-0.001, 2) == "0.00"
    assert signed(-12.345, 1, 6) == " \N{MINUS SIGN}12.3"


# Files


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_figures_are_written_whole_and_alike(figure, tmp_path, suffix):
    first, second = (save_figure(figure, tmp_path / f"{name}{suffix}") for name in "ab")
    assert first.read_bytes() == second.read_bytes()
    assert sorted(each.name for each in tmp_path.iterdir()) == [f"a{suffix}", f"b{suffix}"]
    opening = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
    assert first.read_bytes().startswith(opening)
    if suffix == ".png":
        with Image.open(first) as picture:
            assert picture.width == pytest.approx(16.0 / 2.54 * 200.0, abs=1.0)  # px: 16 cm at 200 dots per inch


def test_bad_figure_targets_are_refused_in_one_line(tmp_path):
    for path in (tmp_path / "a.bmp", tmp_path / "none" / "a.png"):
        with pytest.raises(ValueError, match=r"a\.(bmp|png)") as refusal:
            save_figure(blank_figure(2.0, 2.0), path)
        assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


def test_a_failing_figure_leaves_the_old_file(tmp_path, monkeypatch):
    target = tmp_path / "a.png"
    target.write_bytes(b"old")
    figure = blank_figure(2.0, 2.0)

    def fail(partial, **_):
        partial.write_bytes(b"half")
        raise RuntimeError("no ink")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(RuntimeError, match="no ink"):
        save_figure(figure, target)
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("a.png", b"old")]


# Slow motion


@given(st.floats(0.0, 1.0), st.floats(1.0, 50.0))
def test_time_warp_is_monotonic_and_spans_run_and_film(focus, slower):
    warp = slow_motion(2.0, 3.0, 8.0, [2.0 + focus], slower=slower)
    film = np.linspace(0.0, 8.0, 999)
    physical = warp.physical_time(film)
    assert (np.diff(physical) > 0.0).all()
    assert physical[[0, -1]] == pytest.approx([2.0, 3.0], rel=1e-12)
    assert warp.film_time(physical) == pytest.approx(film, abs=1e-9)
    assert warp.slow_down_at(warp.film_time(2.0 + focus)) == pytest.approx(slower * warp.slow_down.min(), rel=0.01)


def test_slow_down_is_the_rate_of_film_time():
    warp = slow_motion(0.0, 9e-3, 8.0, [4.5e-3])
    physical = np.linspace(1e-3, 8e-3, 50)
    rate = (warp.film_time(physical + 1e-6) - warp.film_time(physical - 1e-6)) / 2e-6
    # Nodes are 2.2 us apart and the bump 360 us wide: linear interpolation is off by their ratio's square, 4e-5, at most.
    assert warp.slow_down_at(warp.film_time(physical)) == pytest.approx(rate, rel=1e-2)


@pytest.mark.parametrize(
    "bad", [{"end": 0.0}, {"duration": 0.0}, {"duration": math.nan}, {"duration": 1e9}, {"slower": 0.5}]
)
def test_bad_slow_motion_is_refused(bad):
    with pytest.raises(ValueError, match=r"allowed|needed"):
        slow_motion(**{"start": 0.0, "end": 1.0, "duration": 8.0} | bad)


# The film


def test_scene_shows_the_run(run):
    scene = PassScene(run, Tool(), width=320, height=240, duration=4.0, until=END)
    film_time = float(scene.warp.film_time(run.time[20]))
    scene.show(film_time)
    outline = scene.wire.wire.get_xy()
    # The sample's instant comes back from the warp but for rounding, times a tip speed of some 20 m/s.
    assert 0.5 * (outline[1] + outline[2]) == pytest.approx(1e3 * run.tip[20], abs=1e-9)
    assert scene.trail.get_xydata()[-1] == pytest.approx(1e3 * run.tip[20], abs=1e-9)
    retraction, clock = -math.degrees(run.relative_angle[20]), 1e3 * run.time[20]
    texts = [readout.text.replace("\N{MINUS SIGN}", "-") for readout in scene.readouts]
    assert float(texts[0].split()[1]) == pytest.approx(clock, abs=0.5e-3)  # half of the last digit shown
    assert float(texts[2].split()[1].rstrip("°")) == pytest.approx(retraction, abs=0.05)


def test_scene_tells_the_strike_and_marks_it_where_it_is(run):
    scene = PassScene(run, Tool(), width=320, height=240, duration=4.0, until=END)
    for offset, caption in ((-0.1, "released: the belt throws the tip"), (0.1, "strike"), (0.6, "rebound")):
        scene.show(float(scene.warp.film_time(STRIKE)) + offset)
        assert scene.caption.get_text() == caption
        assert scene.mark.get_visible() == (caption == "strike")
    assert scene.mark.get_xydata()[0] == pytest.approx(1e3 * run.tip[60], abs=1e-9)


def test_stage_draws_what_is_still_once(monkeypatch):
    stage = Stage(64, 48)
    axes = stage.figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=(0, 64), ylim=(0, 48))
    (dot,) = axes.plot([10.0], [20.0], "s", color="black", markersize=6)
    stage.add(dot)
    drawn = []
    draw = stage._canvas.draw
    monkeypatch.setattr(stage._canvas, "draw", lambda: drawn.append(draw()))
    places = []
    for x in (10.0, 40.0):
        dot.set_xdata([x])
        dark = np.argwhere(np.asarray(stage.frame())[..., 0] < 128)
        places.append(dark.mean(axis=0))
    assert len(drawn) == 1
    # Rows count from the top: y = 20 of 48 is row 28, and a pixel's centre is half a pixel off its index.
    assert np.array(places) == pytest.approx(np.array([[28.0, 10.0], [28.0, 40.0]]), abs=1.0)


def test_readout_darkens_its_own_place_alone_and_survives_the_edge():
    readout = Readout(50, 5, 15.0)
    picture = np.full((30, 64, 4), 255, dtype=np.uint8)
    readout.text = "8888 \N{SNOWMAN}"
    readout.paint(picture)
    dark = np.argwhere(picture[..., 0] < 128)
    assert dark.size
    assert dark[:, 1].min() >= 50
    assert dark[:, 0].min() >= 5
    assert dark[:, 0].max() < 5 + readout.height
    blank = np.full_like(picture, 255)
    readout.text = "\N{SNOWMAN}"
    readout.paint(blank)
    assert (blank == 255).all()


def test_gif_has_every_frame_at_its_time(run, tmp_path):
    path = pass_video(run, Tool(), tmp_path / "a.gif", fps=15.0, width=160, height=120, duration=1.0)
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (15, (160, 120))
        durations = []
        for number in range(film.n_frames):
            film.seek(number)
            durations.append(film.info["duration"])
    assert sum(durations) == 1000  # ms, though a fifteenth of a second is no whole number of hundredths
    assert [each.name for each in tmp_path.iterdir()] == ["a.gif"]


# The reader of imageio-ffmpeg leaves its pipes to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_mp4_has_every_frame_in_the_format_that_plays_everywhere(run, tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg")
    path = pass_video(run, Tool(), tmp_path / "a.mp4", fps=10.0, width=160, height=120, duration=1.0)
    frames = reader.read_frames(str(path))
    about = next(frames)
    assert (about["size"], about["fps"], about["codec"]) == ((160, 120), 10.0, "h264")
    assert about["pix_fmt"].startswith("yuv420p")
    assert sum(1 for _ in frames) == 10
    assert [each.name for each in tmp_path.iterdir()] == ["a.mp4"]


def grey_frames(count, size=(32, 24), fail_at=None):
    for number in range(count):
        if number == fail_at:
            raise RuntimeError("out of paint")
        yield memoryview(np.full((size[1], size[0], 4), 10 * number, dtype=np.uint8))


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_failing_film_leaves_no_file(tmp_path, suffix):
    with pytest.raises(RuntimeError, match="out of paint"):
        write_video(tmp_path / f"a{suffix}", grey_frames(9, fail_at=5), (32, 24), 10.0)
    with pytest.raises(ValueError, match="frame of shape"):
        write_video(tmp_path / f"a{suffix}", grey_frames(9), (64, 48), 10.0)
    assert not list(tmp_path.iterdir())


def test_a_film_without_frames_is_no_film(tmp_path):
    with pytest.raises(ValueError, match="no frames"):
        write_video(tmp_path / "a.gif", grey_frames(0), (32, 24), 10.0)
    assert not list(tmp_path.iterdir())


def test_a_failing_encoder_is_reported_and_leaves_no_file(tmp_path, monkeypatch):
    encoder = pytest.importorskip("imageio_ffmpeg")
    failing = shutil.which("false")
    if failing is None:
        pytest.skip("no program that fails")
    monkeypatch.setattr(encoder, "get_ffmpeg_exe", lambda: failing)
    with pytest.raises(OSError, match="ffmpeg failed"):
        write_video(tmp_path / "a.mp4", grey_frames(50, size=(320, 240)), (320, 240), 10.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "size", "fps", "words"),
    [
        ("a.avi", (32, 24), 10.0, "ends in .gif, .mp4"),
        ("none/a.gif", (32, 24), 10.0, "does not exist"),
        ("a.mp4", (33, 24), 10.0, "even numbers"),
        ("a.gif", (8, 24), 10.0, "16 to 8192"),
        ("a.gif", (32, 24), 60.0, "fps <= 50"),
        ("a.mp4", (32, 24), math.nan, "fps = nan"),
    ],
)
def test_bad_films_are_refused_before_the_first_frame(run, tmp_path, name, size, fps, words):
    if name.endswith(".mp4"):
        pytest.importorskip("imageio_ffmpeg")
    with pytest.raises(ValueError, match=words):
        write_video(tmp_path / name, grey_frames(3, fail_at=0), size, fps)
    with pytest.raises(ValueError, match=words):
        pass_video(run, Tool(), tmp_path / name, fps=fps, width=size[0], height=size[1])
    assert not list(tmp_path.iterdir())


def test_mp4_without_its_encoder_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ValueError, match=r"pip install bristle-sim\[video\]"):
        write_video(tmp_path / "a.mp4", grey_frames(3), (32, 24), 10.0)
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0)  # needs no encoder


class Terminal(io.StringIO):
    """Standard error as a person sees it."""

    def isatty(self):
        return True


def test_progress_is_for_terminals_alone(tmp_path, monkeypatch, capsys):
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert capsys.readouterr() == ("", "")
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setattr(video.sys, "stderr", Terminal())
    write_video(tmp_path / "b.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert video.sys.stderr.getvalue() == ""


def test_progress_counts_frames_on_standard_error(tmp_path, monkeypatch, capsys):
    pytest.importorskip("tqdm")
    terminal = Terminal()
    monkeypatch.setattr(video.sys, "stderr", terminal)
    write_video(tmp_path / "a.gif", grey_frames(3), (32, 24), 10.0, total=3)
    assert "/3" in terminal.getvalue()
    assert capsys.readouterr().out == ""


def test_drawing_imports_neither_pyplot_nor_a_display():
    modules = "pass_figure", "pass_video", "video"
    imports = "; ".join(f"import bristle_sim.render.{name}" for name in modules)
    script = f"{imports}; import sys; print([name for name in sys.modules if name in ('matplotlib.pyplot', 'tkinter')])"
    answer = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_odd_tools_are_drawn(run):
    thin = Tool(hub=Hub(radius=0.0), bar=Bar(radius=1e-4))
    pass_figure(run, thin).draw_without_rendering()
    scene = PassScene(run, thin, width=320, height=240, duration=1.0)
    assert sum(1 for _ in scene.frames(3)) == 3
