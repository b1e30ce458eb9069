"""Surfaces of many craters: the rules against a slow script of their definitions, laws of coverage and mass, refusals."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq

import bristle_sim as bs
from bristle_sim.cli.command import main
from bristle_sim.parameters import Blasting, Bristle, Crater, Hub, Spreads, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.crater_study import crater_study, swept_crater
from bristle_sim.studies.strike_point import crater_depth
from bristle_sim.studies.surface import height_columns, surface_study
from bristle_sim.theory.crater_body import Paraboloid, SweptTip
from bristle_sim.theory.crater_kinematics import TipFace

DEPTH, LENGTH, WIDTH = 130e-6, 325e-6, 651e-6
PRINTED = {"crater_depth": DEPTH, "crater_length": LENGTH, "crater_width": WIDTH}
AREA = math.pi / 4.0 * LENGTH * WIDTH
RANDOM = {**PRINTED, "places": "random", "depth_scatter": 0.0}
SMALL = {"ground_length": 4e-3, "cutoff_wavelength": 8e-4, "cell": 2e-5}


def slow_surface(made, rule, shape, volume):
    """Cut the strikes of a surface by the words of a rule, over all cells, each as far as the nearest image of the place.

    ``shape(x, y)`` is the height above the lowest point; ``volume`` that of a crater on the plane.
    """
    cell = made.blasting.cell
    rows, columns = np.indices(made.heights.shape)
    across, along = rows * cell, columns * cell / 2.0
    length, width = made.heights.shape[1] * cell / 2.0, made.heights.shape[0] * cell
    heights = np.zeros(made.heights.shape)
    for (x, y), depth in zip(made.places, made.depths, strict=True):
        body = shape(
            (along - x + 0.5 * length) % length - 0.5 * length,
            (across - y + 0.5 * width) % width - 0.5 * width,
        )
        if rule == "plane":
            heights = np.minimum(heights, np.where(body < depth, body - depth, 0.0))
        elif rule == "ground":
            inside = body <= depth
            mean = heights[inside].mean()
            heights = np.where(inside, np.minimum(heights, mean + body - depth), heights)
        else:

            def missing(bottom, body=body, heights=heights):
                return np.maximum(heights - bottom - body, 0.0).sum() * cell**2 / 2.0 - volume

            bottom = brentq(missing, -0.01, 0.001, xtol=1e-15, rtol=1e-14)
            heights = np.minimum(heights, bottom + body)
    return heights


@pytest.mark.parametrize("rule", ["energy", "plane", "ground"])
def test_the_rules_by_their_definitions(rule):
    """A paraboloid, of which 60 cover the ground about five times."""
    made = bs.surface(**RANDOM, **SMALL, ground_width=2e-3 / 2, crater_rule=rule, areal_ratio=2.5)

    def shape(x, y):
        return DEPTH * ((2.0 * x / LENGTH) ** 2 + (2.0 * y / WIDTH) ** 2)

    expected = slow_surface(made, rule, shape, math.pi / 8.0 * DEPTH * LENGTH * WIDTH)
    np.testing.assert_allclose(made.heights, expected, atol=1e-12)  # of 1e-4
    assert made.depths.size == round(2.5 * 4e-6 / AREA)


@pytest.mark.parametrize("rule", ["energy", "plane", "ground"])
def test_the_rules_for_the_path_of_a_tip(rule):
    """A face that rises forward at 28 deg; behind its edge the floor rises at gamma."""
    keys = {**SMALL, "ground_width": 2e-3, "places": "random", "depth_scatter": 0.0}
    made = bs.surface(crater=Crater(), **keys, crater_rule=rule, areal_ratio=2.0)
    depth, gamma = made.body.depth, math.radians(23.4)
    full = 0.5 * 7.1e-4 / math.cos(math.radians(39.5)) * math.sin(math.radians(28.0))

    tilt, slope = math.tan(math.radians(28.0)), math.tan(gamma)
    length = depth / slope + depth / tilt

    def edge(y):
        return full * (1.0 - np.sqrt(np.maximum(1.0 - (2.0 * y / 7.1e-4) ** 2, 0.0)))

    def shape(x, y):
        """The lowest place of the half face over all places of the tip, which ends at ``ahead = 0``."""
        ahead = x - 0.5 * length + depth / tilt
        # The edge's point at y has passed x, or the face stands over x: a place of the tip behind its last one by s.
        behind = np.maximum(edge(y) / tilt - ahead, 0.0)
        body = (ahead + behind) * tilt + behind * slope
        return np.where(np.abs(y) <= 3.55e-4, body, 1.0)

    side = np.linspace(-3.55e-4, 3.55e-4, 400_001)
    below = np.maximum(depth - edge(side), 0.0)
    volume = np.trapezoid(below**2, side) * 0.5 * (1.0 / slope + 1.0 / tilt)
    # The volume of 400,000 strips, whose ends are steep, is known to 1e-8.
    expected = slow_surface(made, rule, shape, volume)
    np.testing.assert_allclose(made.heights, expected, atol=1e-11)


def test_a_first_crater_has_its_own_depth_and_outline():
    ground = {"ground_length": 4e-3, "ground_width": 1.5e-3, "cell": 5e-6}
    for body in (PRINTED, {"crater": Crater()}):
        keys = {**body, **ground, "places": "random", "depth_scatter": 0.0}
        for rule in ("energy", "plane", "ground"):
            made = bs.surface(**keys, crater_rule=rule, areal_ratio=0.03)
            assert made.depths.size == 1
            # Cells of 5 um in a crater of 325 um or more.
            assert -made.heights.min() == pytest.approx(made.body.depth, rel=0.01)
            assert made.coverage * 6e-6 == pytest.approx(made.body.area(), rel=0.01)
            assert made.removed_volume == pytest.approx(made.body.volume(), rel=0.01)


def test_random_places_cover_as_avrami_says():
    """1 - (1 - a/S)^N of N craters of the area a, rule plane and ground; rule energy cuts wider."""
    covered = {}
    for rule in ("plane", "ground", "energy"):
        found = [
            bs.surface(**RANDOM, **SMALL, crater_rule=rule, areal_ratio=1.5, seed=seed)
            for seed in range(12)
        ]
        covered[rule] = np.array([each.coverage for each in found])
    number = found[0].depths.size
    expected = 1.0 - (1.0 - AREA / 12e-6) ** number
    assert expected == pytest.approx(1.0 - math.exp(-1.5), abs=5e-3)
    error = covered["plane"].std(ddof=1) / math.sqrt(12)
    assert abs(covered["plane"].mean() - expected) < 4.0 * error
    np.testing.assert_array_equal(covered["ground"], covered["plane"])
    assert np.all(covered["energy"] > covered["plane"])


def test_a_lattice_covers_as_its_craters_lie():
    """Two planes 0.75 mm apart: craters 0.5 mm apart do not meet; 50 um apart they leave furrows as wide as a crossing."""
    keys = {
        **PRINTED,
        "depth_scatter": 0.0,
        "place_scatter": 0.0,
        "planes": 2,
        "track_width": 1.5e-3,
    }
    keys |= {"ground_length": 4e-3, "ground_width": 1.5e-3, "cell": 5e-6, "crater_rule": "plane"}
    apart = bs.surface(**keys, areal_ratio=16 * AREA / 6e-6)
    assert apart.depths.size == 16
    assert apart.coverage == pytest.approx(
        16 * AREA / 6e-6, rel=5e-3
    )  # 3,300 of 5 um cells on a rim
    assert sorted({round(1e6 * each) for each in apart.places[:, 1]}) == [375, 1125]
    spacing = 4e-3 / 80
    dense = bs.surface(**keys, areal_ratio=160 * AREA / 6e-6)
    least, most = 2.0 * WIDTH * math.sqrt(1.0 - (spacing / LENGTH) ** 2), 2.0 * WIDTH
    assert least / 1.5e-3 - 5e-3 < dense.coverage < most / 1.5e-3 + 5e-3
    overlapping = bs.surface(**{**keys, "planes": 3}, areal_ratio=160 * AREA / 6e-6)
    assert overlapping.coverage == 1.0


@pytest.mark.parametrize("rule", ["energy", "plane", "ground"])
def test_the_removed_volume_is_the_sum_of_the_craters_taken(rule):
    made = bs.surface(**SMALL, places="random", crater_rule=rule, areal_ratio=5.0)
    assert np.all(made.taken >= 0.0)
    assert made.removed_volume == pytest.approx(made.taken.sum(), rel=1e-12)
    assert made.mean_depth * made.heights.size * 2e-10 == pytest.approx(made.removed_volume)
    if rule == "energy":
        np.testing.assert_allclose(made.taken, made.body.volume(made.depths), rtol=1e-9)


def test_rz_does_not_depend_on_the_grid():
    for keys in (RANDOM, {}):
        coarse, fine = (
            bs.surface(**keys, areal_ratio=2.0, cell=cell, ground_length=0.012, ground_width=2.4e-3)
            for cell in (1e-5, 5e-6)
        )
        # Lowest points lie over the middle of a cell.
        np.testing.assert_allclose(coarse.places, fine.places, rtol=0.0, atol=7.6e-6)
        assert fine.rz == pytest.approx(coarse.rz, rel=0.01)


def test_the_first_estimate_is_reproduced():
    """Rule plane, areal ratio 3.9: figures that were estimated before this was programmed, as means of ten seeds, to 6 %."""
    found = [
        bs.surface(**RANDOM, crater_rule="plane", areal_ratio=3.9, seed=seed, cell=2e-5)
        for seed in range(10)
    ]

    def mean(name):
        return 1e6 * np.mean([getattr(each, name) for each in found])

    assert mean("rz") == pytest.approx(79.0, rel=0.06)
    assert mean("rz_at_2_5_mm") == pytest.approx(118.0, rel=0.06)
    assert mean("rz_across") == pytest.approx(49.0, rel=0.06)
    assert mean("mean_depth") == pytest.approx(97.0, rel=0.06)


def test_the_blasting_ends_as_requested_and_the_feed_follows():
    for places in ("pattern", "random"):
        made = bs.surface(**SMALL, places=places, coverage=0.9)
        assert made.coverage == pytest.approx(0.9, abs=1e-2)  # a crater is 1.6 % of the ground
        ended = bs.surface(**SMALL, places=places, areal_ratio=2.0)
        assert ended.strikes_per_crater_area == pytest.approx(2.0, rel=0.01)
        again = bs.surface(**SMALL, places=places, feed_speed=ended.feed)
        assert again.depths.size == ended.depths.size
        np.testing.assert_array_equal(again.heights, ended.heights)
    per_second = 8 * 19 * 261.8 / (2.0 * math.pi)
    assert ended.strike_rate == pytest.approx(per_second, rel=1e-12)
    assert ended.area_rate == pytest.approx(per_second * ended.body.area() / 2.0, rel=0.01)
    assert ended.area_rate == pytest.approx(0.024 * ended.feed, rel=1e-12)
    assert ended.removal_rate == pytest.approx(per_second * ended.body.volume(ended.depths).mean())
    twice = bs.surface(**SMALL, areal_ratio=2.0, passes=2)
    assert twice.feed == pytest.approx(2.0 * ended.feed, rel=1e-12)


def test_a_seed_gives_one_surface_bit_for_bit():
    one, same, other = (bs.surface(**SMALL, areal_ratio=1.0, seed=seed) for seed in (7, 7, 8))
    assert one == same
    assert one != other


def test_the_tip_s_path_is_as_deep_as_the_contact_cuts():
    """The depth of ``crater_depth``, and the outline of the face of the wire's diameter."""
    found = crater_study(Hub(), Bristle(), Crater(), Settings())
    depth = next(each for each in found.quantities if each.name == "contact_energy_depth_inclined")
    body = swept_crater(Hub(), Bristle(), Crater(), Settings())
    assert body.depth == depth.simulated
    assert body.length == pytest.approx(
        body.depth * (1.0 / math.tan(math.radians(23.4)) + 1.0 / math.tan(math.radians(28.0)))
    )
    thin = swept_crater(Hub(), Bristle(wire_diameter=5e-4), Crater(), Settings())
    assert thin.width < 5e-4 < body.width
    for each in (body, thin, SweptTip(3e-4), SweptTip(5e-5, 0.7, TipFace(short_axis=4e-4))):
        start, end, half = each.reach(each.depth)
        assert (start, end) == pytest.approx((-0.5 * each.length, 0.5 * each.length))
        assert half == pytest.approx(0.5 * each.width)
        along = np.linspace(start, end, 1001)
        side = np.linspace(-half, half, 1001)
        below = np.maximum(each.depth - each.shape(along, side), 0.0)
        unit = (end - start) * 2.0 * half
        # Sums over a million points of a shape with kinks.
        assert each.volume() == pytest.approx(below.mean() * unit, rel=5e-3)
        assert each.area() == pytest.approx((below > 0.0).mean() * unit, rel=5e-3)
    bowl = Paraboloid(DEPTH, LENGTH, WIDTH)
    assert bowl.volume(0.5 * DEPTH) == pytest.approx(0.25 * bowl.volume())


def test_a_tool_s_own_pass_gives_its_strike():
    """The energy of the rigid impact in compression, at the pass's speed and angle, to the per cent of hub and bristle's turn."""
    made = bs.surface(**SMALL, areal_ratio=0.1)
    strike = bs.ensemble(Tool(), accuracy=1e-6)
    lost = -float(strike.normal_compressive_work) - float(strike.tangential_compressive_work)
    entry = float(strike.entry_angle_at_contact)
    assert made.crater_depth == pytest.approx(
        float(crater_depth(lost, 0.5, entry, 7.1e-4)), rel=0.03
    )
    slower = bs.surface(Tool().replace(hub_speed="2000 rpm"), **SMALL, areal_ratio=0.1)
    assert slower.crater_depth < made.crater_depth


def test_the_default_scatter_is_that_of_the_tolerances():
    """First-order propagation of the spreads to the depth: 1.5 %."""
    tool = Tool()
    variance = 0.0
    values = {**dataclasses.asdict(Spreads())}
    for key, half in values.items():
        if not half:
            continue
        parts = (tool, tool.hub, tool.belt, tool.bristle, tool.bar, tool.workpart)
        name = key.removeprefix("hub_").removeprefix("belt_").removeprefix("bar_")
        names = (key, name, key.removeprefix("bristle_"), key.removeprefix("wire_"))
        owner = {"hub": tool.hub, "belt": tool.belt, "bristle": tool.bristle, "wire": tool.bristle}
        own = {**owner, "bar": tool.bar}.get(key.split("_")[0], tool.workpart)
        middle = next(float(getattr(own, each)) for each in names if hasattr(own, each))
        del parts
        ends = bs.ensemble(**{key: [max(middle - half, 0.0), middle + half]}, accuracy=1e-6)
        lost = -ends.normal_compressive_work - ends.tangential_compressive_work
        depths = crater_depth(lost, 0.5, ends.entry_angle_at_contact, 7.1e-4)
        variance += (0.5 * (depths[1] - depths[0]) / np.mean(depths)) ** 2 / 3.0
    assert Blasting().depth_scatter == pytest.approx(math.sqrt(variance), rel=0.05)


def test_heights_are_listed_row_by_row():
    made = bs.surface(**SMALL, areal_ratio=0.5)
    columns = height_columns(made)
    x, y, z = (columns[name] for name in ("x (m)", "y (m)", "height (m)"))
    assert x[1] - x[0] == pytest.approx(1e-5)
    assert (y[0], y[400]) == (0.0, pytest.approx(2e-5))
    np.testing.assert_array_equal(z.reshape(made.heights.shape), made.heights)


def test_the_height_map_is_written_for_gwyddion(tmp_path):
    surfalize = pytest.importorskip("surfalize")
    file = tmp_path / "ground.xyz"
    keys = "ground_length=2mm ground_width=1mm cutoff_wavelength=0.4mm cell=20um places=random"
    options = [f"--set={each}" for each in keys.split()]
    assert main(["surface", *options, "--csv", str(file)]) == 0
    x, y, height = np.loadtxt(file).T
    assert (x.max(), y.max()) == pytest.approx((1.99e-3, 0.98e-3))
    with pytest.warns(UserWarning, match="different pixel size"):  # cells are half as long as wide
        read = surfalize.Surface.load(file)
    assert read.data.shape == (50, 200)
    np.testing.assert_allclose(read.data.ravel(), 1e6 * height, rtol=1e-12)


def test_the_answer_compares_with_the_measurement():
    found = surface_study(
        Hub(), Bristle(), Crater(), Blasting(**SMALL, areal_ratio=1.0), Settings()
    )
    assert found.answer.startswith("This tool makes Rz ")
    assert "m²/h" in found.answer
    assert found.answer.endswith("measured Rz: 62 to 83 µm.")
    assert [each.name for each in found.quantities if each.ok is False] == []


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"coverage": 1.0}, "coverage = 1.0: must be"),
        ({"coverage": 0.9, "areal_ratio": 1.0}, "must be left out with areal_ratio"),
        ({"cutoff_wavelength": 4.1e-3}, "must be at most a fifth of ground_length = 0.004"),
        ({"cutoff_wavelength": 1e-5}, "must be at least two cells"),
        ({"feed_speed": 0.0}, "feed_speed = 0.0: must be"),
        ({"crater_length": 1.9e-5}, "crater_length = 1.9e-05: must be from two cells = 2e-05"),
        ({"crater_width": 5e-3}, "to the ground's 0.003"),
        ({"cell": 3e-4}, "crater_length = .*: must be from two cells"),
        ({"cell": 1e-7}, "cell = 1e-07: must be larger"),
        ({"feed_speed": 1e-9}, "must make from 1 to 200000 strikes"),
        (
            {"feed_speed": 10.0, "ground_length": 1e-3, "cutoff_wavelength": 1e-4},
            "must make from 1",
        ),
        ({"crater_rule": "sum"}, "energy [|] plane [|] ground"),
        ({"tool": Tool(workpart=None)}, "workpart"),
        ({"tool": Tool().replace(penetration=-1e-3)}, "must strike the workpart"),
        ({"tool": Tool().replace(wire_diameter=0.0, bristle_mass=8e-5)}, "wire_diameter = 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(keys, words):
    with pytest.raises(ValueError, match=words) as refused:
        bs.surface(**keys)
    assert "\n" not in str(refused.value)
