"""Redraws the dissertation's figures, recomputes its table 3.1 and audits its printed numbers, from
its own equations and parameters and by simulation.

Public: ``figures.redrawn``, ``figures.figures_report``, ``audit.audit_rows`` and
``audit.audit_report``.
"""
