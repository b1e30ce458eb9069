"""Film of the bar-cued tool and the inertia-driven one, side by side, up to the strike of either."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.render.colours import BLUE, VERMILION
from bristle_sim.render.drawing import WireDrawing, close_up, draw_film_tool
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.style import styled
from bristle_sim.studies.inertia_driven import InertiaDriven
from bristle_sim.trajectory.sampled_motion import SampledMotion


class InertiaFilm(Film):
    """The drawing that the film shows; time is zero when both strike, at the end."""

    size = (960, 480)

    def __init__(self, driven: InertiaDriven, *, width: int = 960, height: int = 480, duration: float = 8.0) -> None:
        contact, radial = driven.pass_with_bar.first_contact("workpart"), driven.radial
        if contact is None or radial is None:
            raise ValueError(
                "film of both tools: the bristle must strike with the bar, and come back to radial without"
            )
        self.cued, self.thrown = SampledMotion(driven.pass_with_bar), SampledMotion(radial.trajectory)
        self.ends, speed = (contact.time, radial.time), driven.tool.hub.speed
        touch = self.cued.centre_line(contact.time)[0]
        root = self.thrown.centre_line(radial.time)[0]
        # Without gravity the pulley may be entered anywhere: where the bristle is radial at the other one's strike.
        turn = math.atan2(touch[1], touch[0]) - math.atan2(root[1], root[0])
        self._turn = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        entered = self._turn @ self.thrown.centre_line(0.0)[0]
        self._belt = speed * np.array([-entered[1], entered[0]])
        super().__init__(slow_motion(-contact.time, 0.0, duration), width, height, (BLUE, VERMILION))
        with styled():
            course = self.cued.course(contact.time)
            view = close_up(course.centre_line, driven.tool, 0.5 * width / (height * (1.0 - HEADER)), margin=0.04)
            self.wires = []
            for number, color in enumerate((BLUE, VERMILION)):
                axes = self.figure.add_axes((0.5 * number, 0.0, 0.5, 1.0 - HEADER))
                tool = dataclasses.replace(driven.tool, bar=None) if number else driven.tool
                draw_film_tool(axes, tool, view, 0.75 * self.letters)
                self.wires.append(WireDrawing(axes, tool, color=color, details=True))
        self.wires[1].ring.set_visible(False)  # on the straight belt, roots are not on the hub
        self.moving = [artist for wire in self.wires for artist in wire.artists]

    def move(self, time: float) -> tuple[str, ...]:
        """Move both wires to an instant, s; the one without a bar translates on its belt until it enters the pulley."""
        cued, thrown = (time + end for end in self.ends)
        self.wires[0].place(self.cued.centre_line(cued))
        self.wires[1].place(self._without_bar(thrown))
        on_belt = thrown < 0.0
        speed = float(np.hypot(*self._belt)) if on_belt else float(self.thrown.tip_speed(thrown))
        place = "still on the straight belt" if on_belt else "round the pulley"
        bar, without = f"bar-cued tip {self.cued.tip_speed(cued):5.1f} m/s", f"thrown by inertia {speed:5.1f} m/s"
        return f"with the bar, and without it, {place}", bar, without

    def _without_bar(self, time: float) -> Array:
        line = self.thrown.centre_line(max(time, 0.0)) @ self._turn.T
        return np.asarray(line + min(time, 0.0) * self._belt)
