"""Motion of the bristle while its tip cuts, its energy and the width of the cut, by hand."""

import dataclasses
import math

import pytest

from bristle_sim.parameters import Bristle, Tool
from bristle_sim.theory.crater_kinematics import (
    CraterKinematics,
    CuttingWidth,
    TipFace,
    energy_coefficients,
    path_force,
)

ANGLE = 0.4


class TestMotionAndWidth:
    def test_depths_of_a_tools_own_excursion(self) -> None:
        """delta = c_1 sin gamma (4.8); its trace on a face at the angle given is delta over that angle's sine (4.10)."""
        motion = CraterKinematics.of_tool(Tool(), 800.0, excursion=2e-4, impact_angle=ANGLE, face_angle=0.5)
        assert motion.excursion == 2e-4
        assert motion.depth == pytest.approx(2e-4 * math.sin(ANGLE), rel=1e-14, abs=0.0)
        assert motion.face_depth == pytest.approx(2e-4 * math.sin(ANGLE) / math.sin(0.5), rel=1e-14, abs=0.0)
        usual = CraterKinematics.of_tool(Tool(), 800.0)
        assert usual.face_depth == pytest.approx(usual.depth / math.sin(math.radians(28.0)), rel=1e-14, abs=0.0)

    def test_above_the_surface_nothing_is_cut(self) -> None:
        assert TipFace().width([-1e-3, -1e-9, 0.0]).tolist() == [0.0, 0.0, 0.0]

    def test_width_of_a_face_that_dives_to_its_centre_line_and_no_deeper(self) -> None:
        """With swing = h the width tends to 2 h; a decay may be slow: b(t) = 2 sqrt(h^2 - h^2 e^2), e = e^(-t/2)."""
        width = CuttingWidth(1e-3, 1e-3, 0.5)
        assert width(2.0) == pytest.approx(2e-3 * math.sqrt(1.0 - math.exp(-2.0)), rel=1e-14, abs=0.0)
        for swing, decay in ((0.0, 1.0), (1.001e-3, 1.0), (5e-4, 0.0)):
            with pytest.raises(
                ValueError, match=r"^swing, half_width, decay = .*0 < swing <= half_width.*\(in m, m, 1/s\)$"
            ):
                CuttingWidth(1e-3, swing, decay)

    def test_width_of_a_face_in_its_own_motion(self) -> None:
        motion = dataclasses.replace(CraterKinematics(), decay=5e4)
        assert CuttingWidth.of_face(TipFace(), motion).decay == 5e4

    def test_another_bristle(self) -> None:
        """Twice the mass: twice the energy and twice the force (m/3) lambda v_C."""
        heavy = dataclasses.replace(Bristle(), mass=2.0 * Bristle().mass)
        assert energy_coefficients(bristle=heavy) == pytest.approx(
            [2.0 * each for each in energy_coefficients()], rel=1e-14
        )
        motion = CraterKinematics()
        force = heavy.mass / 3.0 * motion.decay * motion.tip_speed * math.exp(-1.0)
        assert path_force(1.0 / motion.decay, motion, heavy) == pytest.approx(force, rel=1e-14)
