"""Numbers of repetitions, and the weights that extrapolate them, against values by hand."""

import pytest

from bristle_sim.scene.integrate import extrapolation as repetitions
from bristle_sim.scene.integrate.extrapolation import Repetitions


class TestRepetitions:
    def test_three_repetitions_by_hand(self) -> None:
        """Lagrange's weights at h = 0 for n = 4, 5, 6: 4/(-1) 4/(-2) = 8, 5/1 5/(-1) = -25, 6/2 6/1 = 18."""
        table = Repetitions(4, 5, 6)
        assert table.counts == (4, 5, 6)
        assert table.weights == [(1.0,), (-4.0, 5.0), (8.0, -25.0, 18.0)]
        # Less the weights without the first result, (1,) and (-5, 6).
        assert table.differences[1:] == [(-4.0, 4.0), (8.0, -20.0, 12.0)]
        assert table.noise == pytest.approx(
            [each * repetitions.ROUNDING for each in (1.0, 9.0, 51.0)], rel=1e-15, abs=0.0
        )

    def test_cost_counts_every_run_and_step(self) -> None:
        """Two runs of 4 and 5 steps cost two overheads and 9 steps."""
        overhead = repetitions.RUN_OVERHEAD
        assert Repetitions(4, 5).costs == [overhead + 4.0, 2.0 * overhead + 9.0]
