"""What holds for all tests."""

from __future__ import annotations

from pathlib import Path

import pytest

UNTRACED = ("validation", "stability")
"""Folders whose tests compute for long what those of ``unit`` and ``scenarios`` reach too; tracing would double their time."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Measure no coverage of the long comparisons."""
    for item in items:
        if item.path.relative_to(Path(__file__).parent).parts[0] in UNTRACED:
            item.add_marker("no_cover")
