"""Figures, off-screen video and the report page; never steps physics.

Public: ``pass_figure``, ``pass_video``, ``impact_video``, ``report.write_report``, the figures of the scenarios, and
``style.save_figure``.
"""
