"""Table 3.1 of the dissertation, as printed."""

from __future__ import annotations

__all__ = ["TABLE_3_1"]

TABLE_3_1 = ("0.13", "0.43", "0.79", "1.18", "1.56", "1.93", "2.24", "2.49", "2.67", "2.76")
"""Ten-segment impulses of the bristle, 1e-4 N s, with the digits they have in print (Zhang 2020, table 3.1)."""
