"""Figures, films without a display, and the report page; nothing here steps physics.

Public: ``pass_figure``, ``tool_films.PassFilm``, ``report.write_report``, the figures and films of
the scenarios, and ``style.save_figure``.
"""
