"""Parameters of a blasted surface: its craters, the places of the strikes, the simulated area of
the workpart ("ground"), and the roughness measurement.
"""

from dataclasses import dataclass
from typing import Any

from bristle_sim.declared import Declared
from bristle_sim.fields import ANY, choice, count, quantity

# Largest number of square cells of a ground. The stored cells are half as long as they are wide, so
# there are twice as many: 160 MB per copy of the ground.
MOST_CELLS = 1e7
LEAST_CELLS = 2.0  # least number of cells along the length and along the width of a crater
SECTIONS = 5.0  # number of section lengths (cut-off wavelengths) in a profile along the slide


def _crater_size(key: str, words: str) -> Any:
    rule = f"1e-9 <= {key} <= 0.01 m: {words} of the first crater, which is then a paraboloid; none: computed from the strike"
    return quantity(None, f"{rule} [computed from the strike's energy]", usual=ANY)


@dataclass(frozen=True, slots=True)
class Blasting(Declared):
    """A blasted surface: its craters, the strikes, the tool's feed, the simulated area of the
    workpart ("ground"), and the roughness measurement.

    If ``coverage`` (struck fraction of the ground) or ``areal_ratio`` (sum of the craters' areas
    over the ground's area) is given, blasting ends when that value is reached, and the feed follows
    from the number of strikes. Otherwise ``feed_speed``, ``track_width`` and ``passes`` determine
    the number of strikes. The slide is the direction in which the tip slides along the workpart.

    Raises ValueError if both ``coverage`` and ``areal_ratio`` are given, if the cut-off wavelength
    is longer than a fifth of the ground or shorter than two cells, if a given crater is smaller
    than two cells or larger than the ground, or if the ground has too many cells.
    """

    crater_rule: str = choice(
        "crater_rule: depth of a crater where it meets earlier ones: it removes the volume that its energy can cut, or ends at"
        " a first crater's depth below the original plane, or goes as deep below the mean height of the ground under it"
        " [chosen: the hub follows the ground, so that every strike has the first one's energy]",
        *("energy", "plane", "ground"),
    )
    crater_depth: float | None = _crater_size("crater_depth", "depth")
    crater_length: float | None = _crater_size("crater_length", "length along the slide")
    crater_width: float | None = _crater_size("crater_width", "width across the slide")
    places: str = choice(
        "places: where the strikes fall: as feed, bristles and planes place them, or at random"
        " [chosen: as the tool makes them]",
        *("pattern", "random"),
    )
    areal_ratio: float | None = quantity(
        None,
        "0 < areal_ratio <= 100: sum of the craters' areas divided by the ground's area, at the end of blasting; none: the feed"
        " decides"
        " [none: feed and passes decide]",
        usual=ANY,
    )
    coverage: float | None = quantity(
        None,
        "0 < coverage <= 0.9999: struck fraction of the ground at which blasting ends; none: the feed decides"
        " [none: feed and passes decide]",
        usual=ANY,
    )
    cutoff_wavelength: float = quantity(
        0.8e-3,
        "1e-6 <= cutoff_wavelength <= 1 m: cut-off of the Gaussian filter, and section length"
        " [ISO 21920-3: Rz of 10 to 80 um; above it 2.5 mm]",
    )
    ground_length: float = quantity(
        0.02,
        "1e-6 <= ground_length <= 1 m: length of the ground along the slide; a crater that crosses one end continues at the other"
        " [chosen: 25 section lengths of 0.8 mm]",
    )
    ground_width: float = quantity(
        0.003,
        "1e-6 <= ground_width <= 1 m: width of the ground across the slide [chosen: one plane of the belt]",
    )
    cell: float = quantity(
        1e-5,
        "1e-8 <= cell <= 0.001 m: width of the ground's cells across the slide; along it they are half as long [chosen: half of it changes Rz by less than 1 %]",
    )
    planes: int = count(
        8,
        "1 <= planes <= 1000: planes of bristles side by side on the belt [chosen: 3 mm apart; the belt's are not in print]",
    )
    bristles: int = count(
        19,
        "1 <= bristles <= 10000: bristles of one plane, evenly spaced about the hub [chosen: 18.9 deg apart; below 18.7 deg a"
        " follower spoils its strike (scenario neighbours)]",
    )
    feed_speed: float = quantity(
        0.022,
        "1e-9 <= feed_speed <= 10 m/s: speed of the tool over the workpart, along the slide [chosen: covers 98 %]",
    )
    track_width: float = quantity(
        0.024,
        "1e-6 <= track_width <= 10 m: width of the track that the belt strikes [chosen: 23 mm belts are sold]",
    )
    passes: int = count(1, "1 <= passes <= 1000: passes over the same track [chosen]")
    depth_scatter: float = quantity(
        0.015,
        "0 <= depth_scatter <= 0.33: standard deviation of a crater's depth divided by its mean, normally distributed, cut off at three standard deviations"
        " [from the spreads of the scenario tolerances]",
        usual=ANY,
    )
    place_scatter: float | None = quantity(
        None,
        "0 <= place_scatter <= 1 m: standard deviation of the strikes' positions across the slide about their plane; none: half of"
        " the distance between two planes [assumed: wires yield sideways, and a hand sways]",
        usual=ANY,
    )
    seed: int = count(
        1, f"0 <= seed <= {2**32 - 1}: seed of the random positions and depths [chosen]"
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if self.coverage is not None and self.areal_ratio is not None:
            raise ValueError(
                f"coverage = {self.coverage:g}: must be left out with areal_ratio, either ends the blasting"
            )
        longest = self.ground_length / SECTIONS
        if self.cutoff_wavelength > longest * (1.0 + 1e-9):
            raise ValueError(
                f"cutoff_wavelength = {self.cutoff_wavelength:g}: must be at most a fifth of ground_length = {longest:g} (in m)"
            )
        if self.cutoff_wavelength < 2.0 * self.cell:
            raise ValueError(
                f"cutoff_wavelength = {self.cutoff_wavelength:g}: must be at least two cells = {2.0 * self.cell:g} (in m)"
            )
        cells = self.ground_length * self.ground_width / self.cell**2
        if cells > MOST_CELLS:
            raise ValueError(
                f"cell = {self.cell:g}: must be larger (in m); ground_length = {self.ground_length:g} by"
                f" ground_width = {self.ground_width:g} has {cells:.3g} cells, more than {MOST_CELLS:g}"
            )
        for key in ("crater_length", "crater_width"):
            if (size := getattr(self, key)) is not None:
                self.check_crater(key, size)

    def check_crater(self, key: str, size: float) -> None:
        """Check that a crater's length or width (m) is at least two cells and fits on the ground.

        Args:
            key: ``crater_length`` or ``crater_width``.
            size: length or width of the crater, m.

        Raises:
            ValueError: for any other size.
        """
        ground = self.ground_length if key == "crater_length" else self.ground_width
        least = LEAST_CELLS * self.cell
        if not least <= size * (1.0 + 1e-9) or not size <= ground:
            raise ValueError(
                f"{key} = {size:g}: must be from two cells = {least:g} to the ground's {ground:g} (in m)"
            )
