"""The audit: every printed number and decidable statement of the dissertation's chapters 2 to 4, recomputed.

A number is reproduced when the computed one lies within half a unit of its last printed digit. What differs is told with
the likeliest reason. ``--set show=differs`` leaves the rest out of the table; the JSON always has every row.
"""

import sys
from collections.abc import Mapping
from typing import Any

from bristle_sim.comparison import Report
from bristle_sim.dissertation.audit import AuditView, audit_report
from bristle_sim.scenario_cli import Scenario, build, main


def run(values: Mapping[str, Any]) -> Report:
    """Compute all rows."""
    return audit_report(build(AuditView, values))


SCENARIO = Scenario(
    name="dissertation_audit",
    question="Which of the dissertation's printed numbers do its equations give?",
    parts=(AuditView,),
    run=run,
)

if __name__ == "__main__":
    sys.exit(main(SCENARIO))
