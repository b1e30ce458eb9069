"""Which tests coverage leaves untraced: tracing takes half of their time again, and shorter tests reach the same lines."""

import pytest

UNTRACED = (
    "tests/scenarios/test_random_command_lines.py",
    "tests/scenarios/test_scripts.py::test_a_video_is_rendered_when_asked_for",
    "tests/scenarios/test_scripts.py::test_every_key_has_an_effect_or_is_refused",
    "tests/scenarios/test_scripts.py::test_the_independent_solution_agrees[cue_map]",
    "tests/stability/test_repeatability.py",
    *(
        f"tests/stability/test_promises.py::test_promise[{theme}"
        for theme in ("belt_stiffness", "budget", "damping", "hub_speed", "limits", "long_run", "mass_ratio", "size")
    ),
    "tests/unit/test_extrapolation.py",
    "tests/unit/test_readme.py::test_the_python_examples_run",
    "tests/unit/test_reference_row.py::TestRow",
    "tests/unit/test_tolerances.py::test_small_spreads",
    "tests/validation/",
)
"""Beginnings of their names."""

TRACED = (
    "test_impacts_in_any_scene.py",
    "test_rows.py",
    "::test_a_video_is_rendered_when_asked_for[double_pendulum",
    "::test_a_video_is_rendered_when_asked_for[inertia_driven",
    "::test_a_video_is_rendered_when_asked_for[neighbours",
    "::test_bad_input_in_one_line",
    "::test_energy_of_double_pendulums",
    "::test_a_run_of_several_links_is_not_resumed",
    "::test_friction_locks_a_thick_wire_on_the_bar",
    "::test_refuses_in_one_line",
    "::test_sliding_over_joints_with_friction",
    "::test_touch_near_the_knee",
    "::test_touches_of_a_compliant_workpart",
)
"""Parts of the names of those among them that reach lines of their own."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.nodeid.startswith(UNTRACED) and not any(name in item.nodeid for name in TRACED):
            item.add_marker("no_cover")
