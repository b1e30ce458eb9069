"""Motion of the bristle while its tip cuts, its energy and the width of the cut, by hand."""

import dataclasses
import math

import pytest

from bristle_sim.parameters import Tool
from bristle_sim.theory.crater_kinematics import (
    CraterKinematics,
    CuttingWidth,
    TipFace,
)

ANGLE = 0.4


class TestMotionAndWidth:
    def test_depths_of_a_tools_excursion(self) -> None:
        """delta = c_1 sin gamma (4.8); its trace on the face is delta over the sine of the face's angle (4.10)."""
        motion = CraterKinematics.of_tool(Tool(), 800.0)
        assert motion.depth == pytest.approx(3.25e-4 * math.sin(math.radians(23.4)), rel=1e-14, abs=0.0)
        assert motion.face_depth == pytest.approx(motion.depth / math.sin(math.radians(28.0)), rel=1e-14, abs=0.0)

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
