"""Count how often a wire that bends touches the workpart in a pass. ``python tests/benchmarks/wire_pass.py``, some minutes.

By the independent solution, with a contact of the stiffness that would keep the rigid bristle in touch for 71 us, at a friction
of 0.31 and no damping of the belt: the rigid bristle, and wires of 8 links of several damping ratios.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence

from bristle_sim.parameters import Bristle, ContactStiffness, Tool
from bristle_sim.reference import simulate_reference

IMPACT_ANGLE = math.radians(23.4)
"""Angle gamma at which the rigid bristle's stiffness is defined (Zhang 2020, caption of fig. 2.7)."""

DAMPING_RATIOS = (0.0, 0.02, 0.1)
"""Of the first bending mode."""


def touches(links: int, damping_ratio: float = 0.0) -> list[tuple[float, float]]:
    """Return start and duration of each contact with the workpart, s."""
    tool = Tool(bristle=Bristle(links=links, bending_damping_ratio=damping_ratio))
    bristle, part = tool.bristle, tool.workpart
    assert part is not None
    inverse_mass = (bristle.length * math.sin(IMPACT_ANGLE)) ** 2 / bristle.inertia_about_root
    stiffness = ContactStiffness().stiffness(inverse_mass, part.restitution)
    run = simulate_reference(tool, accuracy=1e-6, contact_stiffness=stiffness)
    return [(each.time, each.duration) for each in run.contacts if each.obstacle == "workpart"]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the contacts of each wire."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--links", type=int, default=8)
    links = parser.parse_args(arguments).links
    for count, ratio in ((1, 0.0), *((links, each) for each in DAMPING_RATIOS)):
        begin = time.process_time()
        found = touches(count, ratio)
        print(
            f"{count} links, damping ratio {ratio:g}: {len(found)} touches ({time.process_time() - begin:.0f} s of CPU)"
        )
        print(
            "  ms:", ", ".join(f"{1e3 * start:.3f} for {1e3 * duration:.3f}" for start, duration in found), flush=True
        )


if __name__ == "__main__":
    main()
