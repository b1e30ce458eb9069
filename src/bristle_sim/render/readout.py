"""Write numbers that change with every frame from characters drawn once: fifty times cheaper than text laid out anew."""

from __future__ import annotations

import string
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bristle_sim.render.colours import BLACK

Pixels = NDArray[np.uint8]

CHARACTERS = string.ascii_letters + string.digits + " .,:;+-/=()°²µ·\N{MINUS SIGN}\N{MULTIPLICATION SIGN}"
FONT = "DejaVu Sans Mono"
ADVANCE, LINE, DESCENT = 0.602, 1.35, 0.35
"""Width of a character, height of a line and depth of the baseline's lower edge, in letter sizes."""


class Readout:
    """One line of text in letters of equal width, at a fixed place in the picture.

    Characters darken what is below them, so a light ground shows through. Unknown characters are left blank.
    """

    def __init__(self, left: int, top: int, letter_size: float, *, color: str = BLACK) -> None:
        """Place the line's upper left corner, px from the picture's; ``letter_size`` in px."""
        self.left, self.top, self.text = left, top, ""
        self.advance, self.height = round(ADVANCE * letter_size), round(LINE * letter_size)
        self._letters = _alphabet(letter_size, self.advance, self.height, color)

    def paint(self, picture: Pixels) -> None:
        """Write the text onto an RGBA picture, clipped at its edges."""
        if self.text:
            line = np.concatenate([self._letters.get(each, self._letters[" "]) for each in self.text], axis=1)
            place = picture[self.top : self.top + self.height, self.left : self.left + line.shape[1]]
            np.minimum(place, line[: place.shape[0], : place.shape[1]], out=place)


@lru_cache(maxsize=8)
def _alphabet(letter_size: float, width: int, height: int, color: str) -> dict[str, Pixels]:
    """Return every character as a picture of one size, on white."""
    figure = Figure(figsize=(width / 100.0, height / 100.0), dpi=100.0, facecolor="white")
    canvas: Any = FigureCanvasAgg(figure)
    style: dict[str, Any] = {"family": FONT, "fontsize": 0.72 * letter_size, "color": color, "va": "baseline"}
    text = figure.text(0.0, DESCENT * letter_size / height, "", **style)
    letters = {}
    for character in CHARACTERS:
        text.set_text(character)
        canvas.draw()
        letters[character] = np.array(canvas.buffer_rgba(), dtype=np.uint8)
    return letters
