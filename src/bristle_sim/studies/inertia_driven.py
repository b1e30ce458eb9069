"""A tool without a bar, compared with the tool with a bar: by simulation, by conservation of
energy, and by the independent reference solution.

The bristle travels in translation on the straight part of the belt and then enters the pulley,
which rotates at the angular velocity omega. At the entry the bristle is radial and does not rotate.
Its angular velocity relative to the pulley is therefore -omega. The bristle lags, and the belt
swings it back. The report states the tip speed at the instant at which the bristle is radial again.
It also states the pulley speed at which this tip speed would equal the tip speed at the strike of
the tool with a bar.
"""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, newton

from bristle_sim.comparison import Report, Values, rows
from bristle_sim.parameters import Tool
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import require_result, require_rigid, run_fields
from bristle_sim.theory import cueing, inertia_drive
from bristle_sim.trajectory import Interpolation, Trajectory

QUANTITIES = {
    "largest_retraction_deg": ("largest retraction", "deg"),
    "time_to_radial": ("time until radial again", "s"),
    "relative_speed_at_radial": ("bristle's speed relative to the pulley then", "rad/s"),
    "tip_speed_at_radial": ("tip speed then", "m/s"),
    "hub_speed_for_equal_tip_speed": ("pulley speed for the bar-cued tip speed", "rad/s"),
}

# Duration of the first run, in half periods of the bristle on its belt. The factor is more than 1,
# since large amplitude and damping lengthen the period.
HALF_PERIODS = 1.3
# Number of times that the duration of the first run is doubled before the bristle counts as never
# returning
DOUBLINGS = 6
LEAST_TURN = 1e-12  # smallest angle by which the hub may turn in a run, rad
# Least angle beyond the radial direction, divided by the largest retraction, at which the bristle
# counts as having passed it. An overdamped bristle creeps towards the radial direction and passes
# it by rounding errors alone.
LEAST_OVERSHOOT = 1e-6
# Largest number of iterations of the secant method for the hub speed. Few are needed, since the tip
# speed is nearly proportional to the hub speed.
TRIES = 20

BareRun = Callable[[Tool, float], Trajectory]
"""Function (tool, time) that simulates a tool without a bar from the bristle's entry into the pulley,
for a time in s."""


@dataclass(frozen=True, slots=True)
class InertiaDriven:
    """Results of the study of a bristle without a bar.

    Attributes:
        tool: the tool.
        radial: motion of the bristle without a bar, from its entry into the pulley until it is
            radial again. It is None if the bristle does not become radial again.
        pass_with_bar: simulated pass of the tool with its bar.
    """

    tool: Tool
    radial: Trajectory | None
    pass_with_bar: Trajectory


def inertia_driven(tool: Tool, settings: Settings, *, with_reference: bool = True) -> Report:
    """Simulate a bristle that swings through its own inertia, without a bar.

    The study also finds the pulley speed at which the tip is as fast as in the tool with a bar.

    Raises:
        ValueError: if the hub is at rest, the wire bends, or a run exceeds the step budget.
    """
    require_rigid(tool)
    if not tool.hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or nothing throws the bristle (in rad/s)")

    def run(bare: Tool, time: float) -> Trajectory:
        """Simulate the tool ``bare``, which has no bar, for a given time (s)."""
        turn = bare.hub.speed * time
        if turn < LEAST_TURN:
            raise ValueError(
                f"hub_speed = {bare.hub.speed:g}: must be faster, or the belt softer; the hub turns by {turn:g} rad while the"
                " bristle swings (in rad/s)"
            )
        found = simulate(
            bare, dataclasses.replace(settings, hub_turn=turn), start_relative_rate=-bare.hub.speed
        )
        require_result(found, settings)
        return found

    radial = until_radial(tool, run)
    with_bar = simulate(tool, settings, stop_after="strike")
    strike_speed = _tip_speed_at_strike(with_bar)
    simulated = _values(tool, run, radial, strike_speed)
    # The error of the angular velocity is a fraction of the hub speed, the initial relative angular
    # velocity. If the bristle returns more slowly, the relative error is larger.
    slow = 1.0
    fields = {}
    if radial is not None:
        slow = max(1.0, tool.hub.speed / float(radial.relative_rate[-1]))
        fields = run_fields(radial) | {"events": (("radial", float(radial.time[-1])),)}
    if not fields.get("not_reached"):
        fields["not_reached"] = with_bar.accuracy_not_reached
    allowed = slow * max(1e-8, 10.0 * settings.accuracy)
    # The pulley speed of equal tip speed follows from the strike of the tool with a bar, whose
    # error is ten times as large.
    within = dict.fromkeys(QUANTITIES, allowed) | {"hub_speed_for_equal_tip_speed": 10.0 * allowed}
    reference = _reference(tool) if with_reference else {}
    theory = _theory(tool, strike_speed)
    return Report(
        quantities=rows(QUANTITIES, simulated, theory, reference, tolerances=within),
        **fields,
        subject=InertiaDriven(tool, radial, with_bar),
        answer=_answer(simulated, strike_speed, with_bar.stop_reason),
    )


def until_radial(tool: Tool, run: BareRun) -> Trajectory | None:
    """Simulate a bristle without the bar, and return its motion until it is radial again.

    The result is None if the bristle never becomes radial again. ``run`` is a function that takes a
    tool and a duration (s) and simulates the tool for that time.
    """
    bare = dataclasses.replace(tool, bar=None, workpart=None)
    stiffness = bare.belt.stiffness + cueing.field_stiffness(bare)
    if not stiffness:
        return None
    length = HALF_PERIODS * math.pi * math.sqrt(bare.bristle.inertia_about_root / stiffness)
    for doubling in range(DOUBLINGS + 1):
        found = run(bare, length * 2.0**doubling)
        angle = found.relative_angle
        least = LEAST_OVERSHOOT * float(found.retraction.max())
        ahead = np.flatnonzero(angle > least)
        if ahead.size:
            break
        if found.event_time("retraction limit") is not None:
            return None
    else:
        return None
    behind = np.flatnonzero(angle[: ahead[0]] < -least)
    sides = found.time[[behind[-1], ahead[0]]].tolist()
    motion = Interpolation(found, found.contacts)
    return run(bare, brentq(lambda time: float(motion(time).relative_angle), *sides, xtol=1e-18))


def _reference(tool: Tool) -> Values:
    from bristle_sim.reference import simulate_reference

    def run(bare: Tool, time: float) -> Trajectory:
        return simulate_reference(
            bare, start_relative_rate=-bare.hub.speed, duration=time, accuracy=1e-11
        )

    with_bar = simulate_reference(tool, accuracy=1e-10, stop_after="strike")
    return _values(tool, run, until_radial(tool, run), _tip_speed_at_strike(with_bar))


def _values(
    tool: Tool, run: BareRun, radial: Trajectory | None, strike_speed: float | None
) -> Values:
    if radial is None:
        return dict.fromkeys(QUANTITIES)
    equal = None if strike_speed is None else _equal_hub_speed(tool, run, radial, strike_speed)
    return {
        "largest_retraction_deg": math.degrees(radial.retraction.max()),
        "time_to_radial": float(radial.time[-1]),
        "relative_speed_at_radial": float(radial.relative_rate[-1]),
        "tip_speed_at_radial": float(radial.tip_speed[-1]),
        "hub_speed_for_equal_tip_speed": equal,
    }


def _equal_hub_speed(
    tool: Tool, run: BareRun, radial: Trajectory, strike_speed: float
) -> float | None:
    """Return the pulley speed at which the tip is as fast as in the tool with a bar, rad/s.

    Without a bar the tip speed is taken when the bristle is radial again. The secant method finds
    the pulley speed. The result is None if at a tried speed the bristle does not become radial
    again, or if the method does not converge.

    Args:
        tool: the tool.
        run: function that takes a tool without a bar and a duration (s), and simulates the tool for
            that time.
        radial: motion without the bar at the tool's own pulley speed, until the bristle is radial
            again.
        strike_speed: tip speed at the strike of the tool with a bar, m/s.
    """

    def missing(speed: float) -> float:
        """Return the tip speed (m/s) at a pulley speed (rad/s), minus ``strike_speed``."""
        tried: Trajectory | None = radial
        if speed != tool.hub.speed:
            tried = until_radial(tool.replace(hub_speed=speed), run)
        if tried is None:
            raise RuntimeError
        return float(tried.tip_speed[-1]) - strike_speed

    guess = tool.hub.speed * strike_speed / float(radial.tip_speed[-1])
    try:
        return float(
            newton(missing, tool.hub.speed, x1=guess, tol=1e-300, rtol=1e-11, maxiter=TRIES)
        )
    except RuntimeError:  # the bristle does not return, or the secant method does not converge
        return None


def _tip_speed_at_strike(run: Trajectory) -> float | None:
    contact = run.first_contact("workpart")
    return None if contact is None else math.hypot(*contact.velocity_before)


def _theory(tool: Tool, strike_speed: float | None) -> Values:
    """Return the study's quantities, computed from conservation of energy by quadrature.

    The mapping is empty if the belt has damping. ``strike_speed`` is the tip speed (m/s) at the
    simulated strike of the tool with a bar; it determines the pulley speed of equal tip speed.
    """
    if tool.belt_damping:
        return {}
    # When the bristle is radial again, it turns at twice the pulley's speed about its root.
    reach = abs(tool.hub.radius + 2j * complex(*tool.bristle.path[-1]))
    speed = tool.hub.speed
    drive = (
        tool.bristle.inertia_about_root,
        tool.belt.stiffness,
        cueing.field_stiffness(tool),
        speed,
    )
    try:
        retraction = inertia_drive.largest_retraction(*drive)
        time = inertia_drive.time_to_radial(*drive)
    except ValueError:
        return {}
    equal = None if strike_speed is None else strike_speed / reach
    return dict(
        zip(QUANTITIES, (math.degrees(retraction), time, speed, reach * speed, equal), strict=True)
    )


def _answer(simulated: Values, strike_speed: float | None, stop_reason: str) -> str:
    speed = simulated["tip_speed_at_radial"]
    time = simulated["time_to_radial"]
    equal = simulated["hub_speed_for_equal_tip_speed"]
    if speed is None or time is None:
        return "The bristle does not come back to the radial direction: it leans over by 90°, or creeps."
    own = f"Without a bar the tip reaches {amount(speed, 'm/s')} after {amount(time, 's')}"
    if strike_speed is None:
        return f"{own}; with the bar there is no strike to compare with ({stop_reason})."
    compared = f"{own}, {100.0 * speed / strike_speed:.0f} % of the {amount(strike_speed, 'm/s')} with a bar"
    if equal is None:
        return f"{compared}; at no pulley speed is it as fast, as the bristle leans over first."
    return f"{compared}; to reach that speed the pulley must turn at {60.0 * equal / math.tau:.0f} rpm ({equal:.1f} rad/s)."
