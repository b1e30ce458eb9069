"""The dissertation recomputed: its figures and table 3.1 with their own data, and an audit of its printed numbers.

Public: ``figures.redrawn``, ``figures.figures_report``, ``audit.audit_rows`` and ``audit.audit_report``.
"""
