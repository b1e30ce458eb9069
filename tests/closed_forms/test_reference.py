"""The reference against closed forms, conservation laws, geometry recomputed here, and numbers found independently."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.reference.crossing import crossings
from bristle_sim.settings import StopReason

FREE = Tool(bar=None, workpart=None)
SPENT = Tool().replace(contact="compliant", contact_duration=1e-4, restitution=1e-8)
GRAVITY = 9.81


def natural_rate(tool):
    return math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)


def plane(angle):
    """Unit vectors (sin, -cos), shape (n, 2)."""
    return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)


def cross(first, second):
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def carried(points, angle):
    """Points of the wire seen from the root as in Bristle.path, turned with the wire; shape (n, 2)."""
    return -points[1] * plane(angle) + points[0] * plane(angle + 0.5 * math.pi)


def root_and_nearest(tool, run):
    """Root, and the centre line's point nearest to the bar by projection on each piece; shape (n, 2)."""
    root = tool.hub.radius * plane(run.hub_angle)
    found = []
    for start, end in pairwise(((0.0, 0.0), *tool.bristle.path)):
        origin = root + carried(start, run.angles[:, 0])
        length = math.dist(start, end)
        along = carried(np.subtract(end, start) / length, run.angles[:, 0])
        foot = np.clip(((np.array(tool.bar.centre) - origin) * along).sum(axis=1), 0.0, length)
        found.append(origin + foot[:, np.newaxis] * along)
    distances = [np.linalg.norm(point - tool.bar.centre, axis=1) for point in found]
    return root, np.where((distances[0] <= distances[-1])[:, np.newaxis], found[0], found[-1])


def bar_gap(tool, run):
    _, point = root_and_nearest(tool, run)
    return np.linalg.norm(point - tool.bar.centre, axis=1) - tool.bar_reach


def contact_moment(tool, run):
    """Moment about the root of the bar's normal force and of friction on the wire's surface, N m."""
    root, point = root_and_nearest(tool, run)
    normal = (point - tool.bar.centre) / np.linalg.norm(
        point - tool.bar.centre, axis=1, keepdims=True
    )
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    arm = point - 0.5 * tool.bristle.wire_diameter * normal - root
    quarter_turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    velocity = (tool.hub.speed * root + run.rates * arm) @ quarter_turn
    slip = np.sign((velocity * tangent).sum(axis=1, keepdims=True))
    return cross(
        arm, run.normal_force[:, np.newaxis] * (normal - tool.bar.friction * slip * tangent)
    )


class TestOperatingPoint:
    def test_release_over_the_wires_end_is_at_the_instant_of_geometry(self):
        """The force jumps to zero where the bar's foot passes the wire's end: root and bar are sqrt(L^2 + reach^2) apart.

        The foot is located to 1e-13 of the length, and moves at more than 1 m/s.
        """
        bar = Bar(radius=0.002, horizontal=0.075, vertical=0.0115, friction=0.27)
        tool = Tool(Hub(143.0, 0.0456), Belt(0.012), Bristle(0.033, 3e-4, 1.2e-3), bar, None)
        run = simulate_reference(tool, accuracy=1e-12, hub_turn=1.0)
        distance = math.hypot(0.075, 0.0115)
        apart = math.hypot(0.033, tool.bar_reach)
        between = math.acos((distance**2 + 0.0456**2 - apart**2) / (2.0 * distance * 0.0456))
        expected = (math.pi / 2 - math.atan2(0.075, 0.0115) + between) / 143.0
        assert run.event_time("bar release", last=True) == pytest.approx(
            expected, rel=0.0, abs=1e-13 * 0.033 / 1.0
        )


class TestImpact:
    @pytest.mark.parametrize(("friction", "outcome"), [(0.08, "strike"), (0.095, "jam")])
    def test_a_wire_that_leans_forward_jams(self, friction, outcome):
        """Leaning by phi beyond the normal while the root comes down, the impulse turns it back iff mu < tan phi.

        phi = 5 deg at touch, tan phi = 0.0875.
        """
        hub_angle = math.radians(-20.0)
        lean = math.radians(5.0)
        depth = 0.0275 * math.cos(hub_angle) + 0.027 * math.cos(lean)
        tool = Tool(bar=None, workpart=Workpart(penetration=0.0545 - depth, friction=friction))
        run = simulate_reference(
            tool,
            start_hub_angle=hub_angle,
            start_relative_angle=lean - hub_angle,
            stop_after="strike",
        )
        assert run.first_contact("workpart").time < 1e-12
        assert (run.stop_reason is StopReason.JAM) == (outcome == "jam")
        assert (run.event_time("jam") is not None) == (outcome == "jam")

    def test_taps_accumulate_into_rest(self):
        """Dropped from h with e < 1, the bristle rests after sqrt(2h/a) (1+e)/(1-e), and then weighs m g/2.

        a = 1.5 g sin^2 phi at the tip; h is 1e-3 of the length, which is the size of the next term. Bounces below
        1e-10 of the length are taken as rest, which cuts the sum by less.
        """
        lean = math.radians(80.0)
        e = 0.5
        depth = 0.0275 + 0.027 * math.cos(lean)
        tool = Tool(
            hub=Hub(speed=0.0),
            belt=Belt(stiffness=0.0),
            bar=None,
            workpart=Workpart(penetration=0.0545 - depth, friction=0.0, restitution=e),
            gravity=GRAVITY,
        )
        height = 1e-3 * 0.027
        start = -math.acos(math.cos(lean) - height / 0.027)
        run = simulate_reference(
            tool, start_hub_angle=0.0, start_relative_angle=start, duration=0.05
        )
        fall = math.sqrt(2.0 * height / (1.5 * GRAVITY * math.sin(lean) ** 2))
        sustained = run.contacts[-1]
        assert (sustained.law, sustained.outcome) == ("sustained", "end of run")
        assert sustained.time == pytest.approx(fall * (1.0 + e) / (1.0 - e), rel=2e-3)
        # Statics: torque m g (L/2) sin phi = N L sin phi.
        assert run.normal_force[-1] == pytest.approx(0.5 * tool.bristle.mass * GRAVITY, rel=1e-9)
        assert sustained.impulse[0] == pytest.approx(
            run.normal_force[-1] * sustained.duration, rel=1e-9
        )


class TestHold:
    @pytest.mark.parametrize("speed", [20.0, 261.8])
    def test_friction_locks_a_thick_wire_on_the_bar(self, speed):
        """It jams where the edge of the friction cone points at the root, at any speed: tan of the angle is mu = 1."""
        bar = Bar(radius=0.001, horizontal=0.038, vertical=0.0085, friction=1.0)
        tool = Tool(
            hub=Hub(speed=speed),
            bar=bar,
            workpart=None,
            bristle=Bristle(mass=8.387e-5, wire_diameter=0.018),
        )
        run = simulate_reference(tool, start_hub_angle=-2.6)
        assert (run.stop_reason, run.contacts[-1].law) == ("jam", "sustained")
        assert run.event_time("jam") == run.time[-1]
        root, point = root_and_nearest(tool, run)
        normal = (point[-1] - bar.centre) / np.linalg.norm(point[-1] - bar.centre)
        arm = point[-1] - 0.009 * normal - root[-1]
        # Located to 1e-13 of a length of 27 mm, in a ratio of lengths of 9 mm.
        assert abs(cross(arm, normal) / (arm @ normal)) == pytest.approx(1.0, rel=1e-10)

    def test_tip_slides_along_an_inelastic_workpart(self):
        """In sustained contact the tip is on the surface, friction is mu times the normal force, and dissipates."""
        tool = Tool(bar=None, workpart=Workpart(restitution=0.0))
        run = simulate_reference(tool, sample_interval=1e-6)
        sustained = max(
            (each for each in run.contacts if each.law == "sustained"),
            key=lambda each: each.duration,
        )
        rows = (run.time > sustained.time) & (run.time < sustained.time + sustained.duration)
        assert rows.sum() > 1000
        # Ten roundings of the depth.
        assert np.abs(run.tip[rows, 1] + tool.workpart_depth).max() < 1e-15 * 54.5
        assert sustained.impulse[1] == pytest.approx(-0.31 * sustained.impulse[0], rel=1e-9)
        assert (sustained.velocity_before[0], sustained.velocity_after[0]) == (0.0, 0.0)
        slip = np.gradient(run.tip[rows, 0], run.time[rows])
        power = -0.31 * run.normal_force[rows] * slip
        # Differences and trapezoids of 1 us over milliseconds; the ends of the interval are left out, 1e-3 of it.
        assert trapezoid(power, run.time[rows]) == pytest.approx(
            sustained.compressive_work[1], rel=2e-3
        )


class TestNames:
    @pytest.mark.parametrize(
        ("clearance", "event"), [(1e-9, "bar not touched"), (-1e-9, "bar touch")]
    )
    def test_no_touch_is_missed_between_steps(self, clearance, event):
        """A radial bristle passes the bar with a nanometre to spare, or a nanometre short of it.

        Within 2 sqrt(2 reach 1e-9/(S R))/omega = 0.4 us of 18 ms the overlap has come and gone.
        """
        bar = Tool().bar
        scale = (0.0545 + Tool().bar_reach + clearance) / math.hypot(bar.horizontal, bar.vertical)
        moved = replace(bar, horizontal=bar.horizontal * scale, vertical=bar.vertical * scale)
        run = simulate_reference(Tool(bar=moved, workpart=None), accuracy=1e-6)
        assert run.event_time(event) is not None
        assert (run.event_time("bar touch") is None) == (event == "bar not touched")

    @pytest.mark.parametrize(
        ("tool", "settings", "message"),
        [
            (Tool(), {"start_hub_angle": 0.0}, "outside the workpart"),
            (Tool(), {"start_hub_angle": -1.15}, "outside the bar"),
            (Tool(), {"start_relative_angle": 1.6}, "start_relative_angle = 1.6"),
            (Tool(), {"accuracy": 1e-14}, "accuracy = 1e-14"),
            (Tool(), {"hub_turn": math.nan}, "hub_turn = nan"),
            (Tool(), {"stop_after": "release"}, "stop_after = 'release'"),
            (Tool(), {"duration": 1e4}, "duration = 10000"),
            (Tool(), {"sample_interval": 1e-12}, "sample_interval = 1e-12"),
            (SPENT, {"accuracy": 1e-6}, "^restitution = 1e-08: must be 0, or at least 0.001, "),
            (replace(FREE, hub=Hub(speed=0.0), belt=Belt(stiffness=0.0)), {}, "duration = None"),
        ],
    )
    def test_refuses_in_one_line(self, tool, settings, message):
        with pytest.raises(ValueError, match=message) as refusal:
            simulate_reference(tool, **settings)
        assert "\n" not in str(refusal.value)


def points_of(bristle):
    """Mass points that stand for the wire: three-point Gauss quadrature of each piece, exact for its inertia."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    arms = []
    masses = []
    for start, end in pairwise((0j, *(complex(*corner) for corner in bristle.path))):
        arms += list(0.5 * (start + end) + 0.5 * (end - start) * nodes)
        masses += list(0.5 * weights * bristle.mass * abs(end - start) / bristle.length)
    return np.array(arms), np.array(masses)


def free_moment(tool, hub_angle, angle, rate):
    """Moment about the root of belt, weight, and the root's acceleration on the mass points, N m; angle is absolute."""
    arms, masses = points_of(tool.bristle)
    arms = arms * np.exp(1j * np.asarray(angle)[..., np.newaxis])
    root = -1j * tool.hub.radius * np.exp(1j * np.asarray(hub_angle))[..., np.newaxis]
    force = masses * (tool.hub.speed**2 * root - 1j * tool.gravity)
    belt = tool.belt.stiffness * (angle - hub_angle) + tool.belt_damping * (rate - tool.hub.speed)
    return (arms.conj() * force).imag.sum(axis=-1) - belt


def bent(angle, position=0.75, **changes):
    return replace(Tool(), bristle=Bristle(knee_angle_deg=angle, knee_position=position), **changes)


KNEES = [(0.0, 0.5), (-60.0, 0.5), (-40.0, 0.8), (25.0, 0.75), (90.0, 0.3)]


class TestKnee:
    @pytest.mark.parametrize(("angle", "position"), KNEES)
    def test_flight_is_that_of_mass_points(self, angle, position):
        """D'Alembert's principle for mass points about the root, integrated on its own; damping and weight included."""
        tool = bent(
            angle,
            position,
            bar=None,
            workpart=None,
            gravity=1000.0 * GRAVITY,
            belt=Belt(damping_ratio=0.1),
        )
        run = simulate_reference(
            tool, start_relative_angle=0.4, start_relative_rate=-200.0, accuracy=1e-12
        )
        arms, masses = points_of(tool.bristle)
        inertia = (masses * np.abs(arms) ** 2).sum()
        speed = tool.hub.speed

        def motion(time, state):
            return [
                state[1],
                free_moment(tool, -math.pi / 2 + speed * time, state[0], state[1]) / inertia,
            ]

        start = [0.4 - math.pi / 2, speed - 200.0]
        settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "t_eval": run.time}
        expected = solve_ivp(motion, (0.0, run.time[-1]), start, **settings).y
        # A hundred times the requested accuracy, of angles of the order of 1 and the natural rate.
        np.testing.assert_allclose(run.angles[:, 0], expected[0], rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(
            run.rates[:, 0], expected[1], rtol=0.0, atol=1e-10 * natural_rate(tool)
        )

    @pytest.mark.parametrize(
        ("angle", "position", "nearness"),
        [(0.0, 0.75, 1.0), (0.0, 0.75, 0.834), (-40.0, 0.8, 0.88), (31.0, 0.9, 0.875)],
    )
    def test_force_gives_the_bristle_its_momentum(self, angle, position, nearness):
        """I d(phi') = (moment of belt, weight, the root's acceleration and the contact) dt, over the samples.

        The motion is led by geometry alone, so this checks the force: along a straight wire's end or flank, over touches
        that pass the knee outside, and inside on both sides of the blow. 1 us of some milliseconds is lost at the ends of
        a sustained contact, and where the force jumps.
        """
        bar = Bar(horizontal=nearness * 0.05037, vertical=nearness * 0.0225, friction=0.3)
        tool = bent(
            angle,
            position,
            bar=bar,
            workpart=None,
            gravity=1000.0 * GRAVITY,
            belt=Belt(damping_ratio=0.05),
        )
        run = simulate_reference(tool, start_hub_angle=-1.4, hub_turn=1.0, sample_interval=1e-6)
        moment = contact_moment(tool, run)
        moment += free_moment(tool, run.hub_angle, run.angles[:, 0], run.rates[:, 0])
        for sustained in (
            each for each in run.contacts if each.law == "sustained" and each.duration > 2e-4
        ):
            rows = (
                (run.time > sustained.time)
                & (run.time < sustained.time + sustained.duration)
                & (run.normal_force > 0.0)
            )
            gained = tool.bristle.inertia_about_root * np.ptp(run.rates[rows, 0][[0, -1]])
            assert abs(trapezoid(moment[rows], run.time[rows])) == pytest.approx(gained, rel=1e-3)
            assert trapezoid(run.normal_force[rows], run.time[rows]) == pytest.approx(
                sustained.impulse[0], rel=1e-3
            )
            # On the bar to rounding of its distance.
            assert np.abs(bar_gap(tool, run)[rows]).max() < 1e-15 * 55.0

    @pytest.mark.parametrize(
        ("links", "position"),
        [(1, 0.9), (1, 0.6), (2, 0.75), pytest.param(2, 0.6, marks=pytest.mark.nightly)],
    )
    def test_a_knee_strikes_the_workpart_before_the_tip_does(self, links, position):
        """Without a bar a reverse bent wire on a stiff belt turns with the hub until its knee meets the surface.

        The shank is then (r_h + p L) cos(psi) = depth from the surface's normal, but for the belt's twist under the
        centrifugal moment, m r_h omega^2 L/k = 7e-7 rad, and as much of its hinge.
        """
        bristle = Bristle(knee_angle_deg=-80.0, knee_position=position, links=links, modulus=1e15)
        tool = replace(
            Tool(), bar=None, bristle=bristle, belt=Belt(stiffness=100.0), hub=Hub(speed=30.0)
        )
        turn = math.acos(tool.workpart_depth / (tool.hub.radius + position * bristle.length))
        run = simulate_reference(
            tool, start_hub_angle=-turn - 0.02, stop_after="strike", accuracy=1e-8
        )
        assert run.event_time("strike") == pytest.approx(
            0.02 / 30.0, rel=0.0, abs=2e-6 / 30.0 / math.tan(turn)
        )


class TestSprings:
    def test_stick_of_a_lone_bristle_on_a_spring(self):
        """Friction of restitution above tan(gamma) stops the tip at the end of compression, and the hub moves on.

        The wire turns about the tip's place: the abscissa r_h sin(psi) + L sin(theta) stays, so theta' = -r_h omega
        cos(psi)/(L cos(theta)), until its tip slides on.
        """
        part = Workpart(
            friction=0.55, restitution_friction=0.5, restitution=0.6, penetration=0.0034
        )
        tool = Tool(bar=None, workpart=part, contact=Contact("compliant", 1e-4))
        run = simulate_reference(tool, hub_turn=1.3, accuracy=1e-9, sample_interval=2e-6)
        assert run.stop_reason is StopReason.END
        still = (run.time > 0.0) & (np.abs(run.tip_velocity[:, 0]) < 1e-6)
        assert still.sum() > 5
        hub = run.hub_angle[still]
        wire = run.angles[still, 0]
        expected = (
            -tool.hub.radius * tool.hub.speed * np.cos(hub) / (tool.bristle.length * np.cos(wire))
        )
        np.testing.assert_allclose(run.rates[still, 0], expected, rtol=1e-6)


class TestRounding:
    """Values within 1e-13 have no sign of their own."""

    @pytest.mark.parametrize("rounding", [1e-15, -1e-15])
    @pytest.mark.parametrize("before", [-1, 0, 1])
    def test_a_function_that_begins_as_rounding(self, rounding, before):
        """Its first change of sign is the one from the sign that it had before, at once, as t^2 is beyond 1e-13 at t = 3e-7."""
        assert crossings(lambda time: rounding * np.cos(50.0 * time), 0.0, 1.0, 1e-13, before) == []
        rises = crossings(lambda time: time**2 + rounding, 0.0, 1.0, 1e-13, before)
        assert [sense for _, sense in rises] == [1] * (before == -1)
        assert all(0.0 <= time < 3.2e-7 for time, _ in rises)

    @pytest.mark.parametrize("rounding", [1e-15, -1e-15])
    def test_a_function_that_ends_as_rounding_or_touches_zero(self, rounding):
        assert crossings(lambda time: (time - 1.0) ** 2 + rounding, 0.0, 1.0, 1e-13) == []
        assert crossings(lambda time: (time - 0.4) ** 2 + rounding, 0.0, 1.0, 1e-13) == []
        # Its two roots are 2e-6 apart; the dip between them is ten times the resolution.
        found = crossings(lambda time: (time - 0.4) ** 2 - 1e-12, 0.0, 1.0, 1e-13)
        assert [sense for _, sense in found] == [-1, 1]
