"""Imports go one way, each library stays in its place, and every module says what it is for."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from bristle_sim.trajectory import pictures

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "bristle_sim"
MODULES = sorted(PACKAGE.rglob("*.py"))
SCRIPTS = sorted((ROOT / "scenarios").glob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))

ORDER = (
    "arrays readable",
    "version units",
    "declared files",
    "fields force_file",
    "parameters settings",
    "tool_file trajectory theory",
    "contact_space",
    "scene reference passes",
    "comparison",
    "studies",
    "dissertation benchmarks",
    "render",
    "cli",
    "__main__",
)
RANKS = {layer: rank for rank, layers in enumerate(ORDER) for layer in layers.split()}
"""A layer may import layers of lower rank, and itself. Two layers of one rank know nothing of each other."""

PRINTED = "bristle_sim.dissertation.printed"
"""The printed numbers are data that needs nothing of the package, and any layer may compare with them."""

HOMES = {
    "pymunk": ("contact_space", "scene"),
    "pint": ("units",),
    "scipy.integrate": ("reference",),
    "matplotlib": ("render",),
    "PIL": ("render",),
    "jinja2": ("render",),
    "imageio_ffmpeg": ("render",),
}
"""The only layers that may import a library."""

ALONE = {"contact_space": ("arrays", "units", "theory", "contact_space")}
"""The only layers that a layer may import which serves anybody's scene, without the tool."""

ANNOTATED = {"trajectory.py": "matplotlib"}
"""Files whose annotations alone name a library of another layer."""

PEERS = PACKAGE / "benchmarks" / "accuracy_cost"
"""Measures libraries against each other, so it may import any of them but those that draw."""


def imports(source: str) -> Iterator[str]:
    """Every module that a source imports, at its top or inside a function; of ``from a import b`` both a and a.b."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            stem = "." * node.level + (node.module or "")
            yield stem
            yield from (f"{stem}.{each.name}" for each in node.names)


def layer_of(path: Path) -> str:
    """The package's first name below bristle_sim, of a file or a module."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def faults(layer: str, source: str, homes: Mapping[str, tuple[str, ...]] = HOMES) -> list[str]:
    """What a module of a layer imports but must not."""
    found = []
    for name in imports(source):
        if name.startswith("."):
            found.append(f"{name}: the package is imported by its full name")
        elif within(name, "bristle_sim") and not within(name, PRINTED):
            parts = name.split(".")
            target = parts[1] if len(parts) > 1 else None
            if target in RANKS and target != layer and RANKS[target] >= RANKS[layer]:
                found.append(f"{name}: {target} is not below {layer}")
            if target in RANKS and target not in ALONE.get(layer, RANKS):
                found.append(f"{name}: {layer} needs nothing of {target}")
        found += [
            f"{name}: only in {home}"
            for library, home in homes.items()
            if within(name, library) and layer not in home
        ]
    return found


def test_imports_go_one_way():
    found = {}
    for path in MODULES:
        homes = {
            library: home
            for library, home in HOMES.items()
            if PEERS not in path.parents or "render" in home
        }
        door = ANNOTATED.get(path.name, "none")
        if (layer := layer_of(path)) != "__init__":
            all_faults = faults(layer, path.read_text(encoding="utf-8"), homes)
            found[path] = [each for each in all_faults if not each.startswith(door)]
    assert {path: each for path, each in found.items() if each} == {}


def test_no_files_import_each_other_in_a_circle():
    """Also not for typing or within functions: a reader follows those imports too."""
    sources = {module_name(path): path.read_text(encoding="utf-8") for path in MODULES}
    assert circle(sources) == []


def module_name(path: Path) -> str:
    """Return the name by which a file of the package is imported."""
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(
        ".__init__"
    )


def circle(sources: Mapping[str, str]) -> list[str]:
    """Return the modules that import each other in a circle, or between two circles, from their sources by name."""
    arrows = {
        name: {other for other in imports(text) if other != name} & sources.keys()
        for name, text in sources.items()
    }
    left = dict(arrows)
    while True:
        # Neither a module that imports none of the others nor one that none of them imports is in a circle.
        imported = set().union(*left.values())
        kept = {name for name, others in left.items() if others and name in imported}
        if len(kept) == len(left):
            return sorted(left)
        left = {name: arrows[name] & kept for name in kept}


@pytest.mark.parametrize(
    ("sources", "members"),
    [
        ({"a": "import b", "b": "import c", "c": ""}, []),
        ({"a": "import b", "b": "import c", "c": "import b"}, ["b", "c"]),
        ({"a": "def late():\n    import b", "b": "from a import thing"}, ["a", "b"]),
        ({"a": "import b", "b": "if TYPE_CHECKING:\n    import a", "c": "import a"}, ["a", "b"]),
        ({"a.b": "from a import c", "a.c": "from a.b import thing", "a": ""}, ["a.b", "a.c"]),
    ],
)
def test_a_circle_of_imports_is_found(sources: dict[str, str], members: list[str]):
    assert circle(sources) == members


def test_a_run_is_drawn_by_the_module_that_it_names_and_does_not_import():
    """Whoever imports a result must not get the pictures with it; the module must have the functions that results call."""
    drawing = importlib.import_module(pictures.DRAWN_BY)
    promised = {"plot": 2, "film": 5, "view": 1, "summary_page": 1}
    assert {
        name: len(inspect.signature(getattr(drawing, name)).parameters) for name in promised
    } == promised


def test_the_package_itself_imports_nothing():
    """Whoever imports one layer must not get others with it; what a type checker reads is not imported."""
    face = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    top = [node for node in face.body if isinstance(node, ast.Import | ast.ImportFrom)]
    assert list(imports(ast.unparse(ast.Module(top, [])))) == [
        "typing",
        "typing.TYPE_CHECKING",
        "typing.Any",
    ]


def test_the_wheel_carries_every_folder_and_the_scripts():
    packaged = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "setuptools"
    ]["packages"]
    folders = {
        ".".join(path.parent.relative_to(ROOT / "src").parts)
        for path in PACKAGE.rglob("__init__.py")
    }
    assert packaged == sorted({*folders, "bristle_sim.scenarios"})


@pytest.mark.parametrize(
    ("layer", "source", "faulty"),
    [
        ("theory", "from pymunk.vec2d import Vec2d", True),
        ("theory", "from bristle_sim.scene import build", True),
        ("theory", "from bristle_sim import reference", True),
        ("theory", "from scipy import integrate", True),
        ("contact_space", "from bristle_sim.parameters import Tool", True),
        ("scene", "def later():\n    from scipy.integrate import solve_ivp", True),
        ("scene", "from ..reference import simulate_reference", True),
        ("studies", "import matplotlib.pyplot as plt", True),
        (
            "theory",
            "from scipy.special import ellipk\nfrom bristle_sim.parameters import Tool",
            False,
        ),
        ("scene", "import pymunk\nfrom bristle_sim.theory.impact import energetic_impact", False),
        ("reference", "from scipy import integrate\nfrom bristle_sim import parameters", False),
        (
            "render",
            "from matplotlib.figure import Figure\nfrom bristle_sim.studies.whole_pass import WholePass",
            False,
        ),
    ],
)
def test_faults_are_seen_and_downward_imports_are_none(layer: str, source: str, faulty: bool):
    assert bool(faults(layer, source)) is faulty


INTEGRATING = (
    "bristle_sim.scene",
    "bristle_sim.reference",
    "scipy.integrate",
    "bristle_sim.studies.cue_map.position_map",
)
"""Modules that integrate or simulate; the data of the dissertation's figures and audit are computed for their pages alone."""


def test_drawing_imports_nothing_that_integrates():
    """Studies compute, pictures are drawn from what they return."""
    for path in (PACKAGE / "render").glob("*.py"):
        found = [
            name
            for name in imports(path.read_text(encoding="utf-8"))
            for each in INTEGRATING
            if within(name, each)
        ]
        assert found == [], path


def test_scripts_import_only_the_package_and_the_command_line_draws_only_when_asked():
    """A picture or report is written by ``render``, which is imported inside the function that needs it."""
    for path in (*SCRIPTS, *(PACKAGE / "cli").glob("*.py")):
        source = path.read_text(encoding="utf-8")
        roots = {name.split(".")[0] for name in imports(source)}
        assert path not in SCRIPTS or roots <= {"bristle_sim", *sys.stdlib_module_names}, path
        top = [node for node in ast.parse(source).body if not isinstance(node, ast.FunctionDef)]
        assert not [
            each
            for each in imports(ast.unparse(ast.Module(top, [])))
            if within(each, "bristle_sim.render")
        ], path


NOUNLESS = re.compile(r'(?:"""|#)\W*Returns? (?:what|who)\b')
"""A docstring or comment that begins with a relative clause in place of a noun."""


def test_every_module_says_what_it_is_for_and_names_what_it_returns():
    for path in (*MODULES, *SCRIPTS, *TESTS):
        source = path.read_text(encoding="utf-8")
        assert len((ast.get_docstring(ast.parse(source)) or "").split()) >= 3, path
        assert not NOUNLESS.findall(source), path


@pytest.mark.parametrize("line", ['"""Return {} is new."""', "x = 1  # Returns {} asks"])
@pytest.mark.parametrize("word", ["what", "who"])
def test_a_sentence_without_its_noun_is_found(line: str, word: str):
    assert NOUNLESS.search(line.format(word))
    assert not NOUNLESS.search(line.format("the one that"))
