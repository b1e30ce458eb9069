"""Figures, films and HTML pages of results that are already computed; nothing here simulates.

Films need no display. Public: ``pass_figure``, ``tool_films.pass_film``, ``report.write_report``,
the figures and films of the scenarios, and ``style.save_figure``.
"""
