"""The audit recomputes every printed number and checks every decidable statement of the
dissertation's chapters 2 to 4.

A number is reproduced if the computed number lies within half a unit of the last printed digit.
Each number that differs is listed with its most likely reason. ``--set show=differs`` limits the
table to these; the JSON always has every row.
"""

import sys

from bristle_sim.cli import Scenario, main
from bristle_sim.comparison import Report
from bristle_sim.dissertation.audit import AuditView


def run(view: AuditView) -> Report:
    """Recompute every printed number."""
    from bristle_sim.dissertation.audit import audit_report

    return audit_report(view)


SCENARIO = Scenario(
    name="dissertation_audit",
    question="Which of the dissertation's printed numbers do its equations give?",
    run=run,
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
