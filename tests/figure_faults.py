"""What a reader would find wrong with a figure: texts that overlap or are cut, lone units, empty panels, lines without a name."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

COVERED = 0.06
"""Least part of the smaller box that two texts share where they overlap: boxes have a rim without ink."""

RIM = 2.0  # least distance of a text from the page's edge, px: in another resolution its letters are a little wider


def faults(figure: Figure) -> list[str]:
    """Every fault in words; the figure is drawn, not saved."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    page = figure.bbox
    boxes = [(text, text.get_window_extent(canvas.get_renderer())) for text in _texts(figure)]
    found = [
        f"empty panel {axes.get_title(loc='left')!r}" for axes in figure.axes if _is_empty(axes)
    ]
    found += [
        f"not in the legend: {each}" for axes in figure.axes for each in _unnamed(axes, figure)
    ]
    for text, box in boxes:
        if box.x0 < RIM or box.y0 < RIM or box.x1 > page.x1 - RIM or box.y1 > page.y1 - RIM:
            found.append(f"cut: {text.get_text()!r}")
        if text.get_text().strip(" ()") == "°":
            found.append("a lone degree sign")
    for (one, a), (two, b) in itertools.combinations(boxes, 2):
        width, height = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        if min(width, height) > 1.5 and width * height > COVERED * min(
            a.width * a.height, b.width * b.height
        ):
            found.append(f"overlap: {one.get_text()!r} and {two.get_text()!r}")
    return found


def _texts(figure: Figure) -> Iterator[Text]:
    """Texts that are seen: not those of ticks beyond their axis, of hidden axes, or outside their axes' clip."""
    hidden: set[Text] = set()
    for axes in figure.axes:
        off = not axes.axison or not axes.get_visible()
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            rim = 1e-9 * abs(high - low)
            gone = off or not axis.get_visible()
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if gone or not tick.get_visible() or not low - rim <= tick.get_loc() <= high + rim:
                    hidden |= {tick.label1, tick.label2}
            hidden |= {axis.label, axis.offsetText} if gone else set()
    for text in figure.findobj(Text):
        box = text.get_clip_box() if text.get_clip_on() and text.axes is not None else None
        shown = (
            text.get_visible()
            and text.get_text().strip()
            and (text.axes is None or text.axes.get_visible())
        )
        if shown and text not in hidden and (box is None or box.overlaps(text.get_window_extent())):
            yield text


def _is_empty(axes: Axes) -> bool:
    """Whether a panel with scales shows nothing: no artist, or only lines without a finite point and no word why."""
    if not axes.get_visible() or not axes.axison:
        return False
    others = (
        axes.patches
        or axes.collections
        or axes.images
        or axes.tables
        or any(text.get_text() for text in axes.texts)
    )
    return not others and not any(
        np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any() for line in axes.lines
    )


def _unnamed(axes: Axes, figure: Figure) -> Iterator[str]:
    """Colours of lines with data that neither a legend nor a word of that colour names, where there is a legend."""
    own = axes.get_legend()
    legends = [*figure.legends, *([own] if own else [])]
    if not legends or not axes.get_visible():
        return
    handles = [handle for legend in legends for handle in legend.legend_handles]
    named = {to_hex(_colour(handle)) for handle in handles} | {
        to_hex(text.get_color()) for text in _words(axes)
    }
    named |= {to_hex(label.get_color()) for label in (axes.xaxis.label, axes.yaxis.label)}
    drawn = set()
    for line in axes.lines:
        points = np.asarray(line.get_xydata())
        if (
            line.get_transform() == axes.transData
            and line.get_visible()
            and np.isfinite(points).all(axis=1).sum() > 1
        ):
            drawn.add(to_hex(_colour(line)))
    if own or len(drawn) > 1:  # a panel's only line is what its scale names
        yield from drawn - named


def _words(axes: Axes) -> list[Text]:
    """Words in a panel and cells of its tables."""
    return [
        *axes.texts,
        *(cell.get_text() for table in axes.tables for cell in table.get_celld().values()),
    ]


def _colour(artist: Artist) -> Any:
    """The colour that tells an artist from others: of its line or mark, else of its face."""
    if isinstance(artist, Line2D):
        marked = artist.get_linestyle() == "None" and artist.get_markerfacecolor() not in (
            "none",
            "white",
        )
        return artist.get_markerfacecolor() if marked else artist.get_color()
    return artist.get_facecolor()  # type: ignore[attr-defined]
