"""Fields of parameter classes. One text declares the range, unit, meaning and source of a field."""

import functools
import math
import re
from dataclasses import field
from typing import Any

from bristle_sim.declared import Choice, Declaration, Range

ANY = (0.0, math.inf)
"""Value of ``usual`` for a number whose default does not indicate likely values, such as an
accuracy: no magnitude causes a warning."""

RULE = re.compile(r"(\S+) (<=?) (\w+) <= ([^\s:]+)(?: ([^:\[]+?))?(?:: (.+?))?(?: \[(.+)\])?")
"""Pattern of the text that declares a number: range, unit, meaning and source.

An example is ``0 <= hub_radius <= 10 m: radius of the root circle [Zhang 2020, eq. 2.2]``."""

WORDS = re.compile(r"(\w+)(?:: (.+?))?(?: \[(.+)\])?")
"""Pattern of the text that declares a word or another text: key, meaning and source, as in
``contact: law of impact [Stronge 1990]``."""


def quantity(default: float | None, rule: str, **further: Any) -> Any:
    """Declare a dataclass field for a real number.

    Args:
        default: default value; None makes the parameter optional.
        rule: range, unit, meaning and source, in the form of :data:`RULE`.
        further: further attributes of the :class:`Range`: ``usual``, ``needs``, ``whole`` and
            ``listed``.
    """
    found = RULE.fullmatch(rule)
    assert found is not None, rule
    lowest, sign, key, highest, unit, meaning, source = found.groups("")
    declared = Range(
        key,
        unit or "1",
        float(lowest),
        float(highest),
        sign == "<=",
        source=source,
        default=default,
        meaning=meaning,
        optional=default is None,
        **further,
    )
    return _declared(declared)


count = functools.partial(quantity, usual=ANY, whole=True)
"""Declare a dataclass field for a whole number between two bounds, both included."""


def choice(rule: str, *options: str) -> Any:
    """Declare a dataclass field whose value is one of a few words.

    Args:
        rule: key, meaning and source, in the form of :data:`WORDS`.
        options: the permitted words; the first is the default.
    """
    return _declared(Choice(**_words(rule), default=options[0], options=options))


def text(rule: str, kind: str) -> Any:
    """Declare a dataclass field for an optional text.

    Args:
        rule: key, meaning and source, in the form of :data:`WORDS`.
        kind: kind of the text: ``file``, ``folder`` or ``column``.
    """
    return _declared(Declaration(**_words(rule), unit=kind, optional=True))


def _words(rule: str) -> dict[str, Any]:
    """Return key, meaning and source from a text in the form of :data:`WORDS`."""
    found = WORDS.fullmatch(rule)
    assert found is not None, rule
    return dict(zip(("key", "meaning", "source"), found.groups(""), strict=True))


def _declared(declaration: Declaration) -> Any:
    """Return a dataclass field that carries its declaration as metadata."""
    return field(default=declaration.default, metadata={"declaration": declaration})
