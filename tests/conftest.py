"""A browser that tests of pages share, the examples that hypothesis draws, and a random order of the tests on request.

Every run draws the same examples, of however much time each takes, and keeps none: a test passes always or never. The long run of
the night draws its own (``BRISTLE_FRESH_EXAMPLES=1``), and runs the tests in a random order (``--random-order SEED``).
"""

from __future__ import annotations

import gc
import os
import random
import shutil
from collections.abc import Iterator
from typing import Any

import hypothesis
import pytest

hypothesis.settings.register_profile(
    "same examples", deadline=None, derandomize=True, database=None
)
hypothesis.settings.register_profile(
    "fresh examples", deadline=None, print_blob=True, database=None
)
hypothesis.settings.load_profile(
    "fresh examples" if os.environ.get("BRISTLE_FRESH_EXAMPLES") else "same examples"
)

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--random-order",
        type=int,
        metavar="SEED",
        help="run files, and tests within each, in the order of a seed",
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Shuffle as requested, alike in all processes, but leave the tests of a file together, as they share its fixtures."""
    seed = config.getoption("--random-order")
    if seed is None:
        return
    drawn = random.Random(seed)
    files = sorted({str(item.path) for item in items})
    drawn.shuffle(files)
    drawn.shuffle(items)
    items.sort(key=lambda item: files.index(str(item.path)))


def pytest_collection_finish() -> None:
    """Run the garbage collector less often, and not on the imported modules. It took 5 to 10 % of the tests' CPU time."""
    gc.freeze()
    gc.set_threshold(20_000)


@pytest.fixture(autouse=True)
def no_reminder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no progress line come between the lines of a command on a machine that is slow; tests of progress set their own time."""
    monkeypatch.setattr("bristle_sim.cli.output.SILENCE", 3600.0)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    if CHROMIUM is None:
        pytest.skip("needs a Chromium browser")
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-background-networking"]
        )
        yield opened
        opened.close()


@pytest.fixture
def browser(chromium: Any) -> Iterator[Any]:
    """The browser, whose pages are closed after each test: the bench would go on to compute their maps."""
    yield chromium
    for each in chromium.contexts:
        each.close()
