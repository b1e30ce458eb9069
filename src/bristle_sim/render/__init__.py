"""Figures, off-screen video and the report page; never steps physics.

Public: ``pass_figure``, ``pass_video.PassFilm``, ``report.write_report``, the figures and films of the scenarios, and
``style.save_figure``.
"""
