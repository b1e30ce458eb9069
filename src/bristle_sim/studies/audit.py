"""The audit: every printed number and decidable statement of chapters 2-4 of the dissertation, recomputed.

Rows come in the order of the chapters. Nothing is stored: each call computes all of them, the simulated pass once.
"""

from __future__ import annotations

from bristle_sim.studies.audit_crater import crater_rows
from bristle_sim.studies.audit_force import force_rows
from bristle_sim.studies.audit_impact import impact_rows
from bristle_sim.studies.audit_row import DIFFERS, NOT_COMPUTABLE, REPRODUCED, AuditRow
from bristle_sim.studies.audit_tool import tool_rows

__all__ = ["DIFFERS", "NOT_COMPUTABLE", "REPRODUCED", "AuditRow", "audit_rows"]


def audit_rows() -> tuple[AuditRow, ...]:
    """All rows of the audit (see AuditRow); numbers are finite, places unique."""
    return (*tool_rows(), *impact_rows(), *force_rows(), *crater_rows())
