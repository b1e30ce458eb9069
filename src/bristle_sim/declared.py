"""Declared parameters: default, unit, range, meaning and source in one place.

A declaration checks every value that enters a parameter object, from Python, a file or the command
line. The scripts list and parse it, and it is the documentation of its field.
"""

import dataclasses
import functools
import inspect
import math
import re
import textwrap
import warnings
from dataclasses import field
from typing import Any

from bristle_sim.units import Choice, Range, likely_key, unusual_value

ANY = (0.0, math.inf)
"""Usual sizes of a number whose default does not indicate likely values, such as an accuracy."""

RULE = re.compile(r"(\S+) (<=?) (\w+) <= ([^\s:]+)(?: ([^:\[]+?))?(?:: (.+?))?(?: \[(.+)\])?")
"""Pattern of a rule: range, unit, meaning and source.

An example is ``0 <= hub_radius <= 10 m: radius of the root circle [Zhang 2020, eq. 2.2]``."""


def quantity(
    default: float | None,
    rule: str,
    *,
    usual: tuple[float, float] | None = None,
    needs: str = "",
    whole: bool = False,
) -> Any:
    """Declare a dataclass field for a real number by a default and a rule as in :data:`RULE`.

    A default of None makes the parameter optional. The other arguments are attributes of
    :class:`Range`.
    """
    found = RULE.fullmatch(rule)
    assert found is not None, rule
    lowest, sign, key, highest, unit, meaning, source = found.groups("")
    words = (source, default is None, meaning, usual, needs, whole)
    return declared_field(
        default, Range(key, unit or "1", float(lowest), float(highest), sign == "<=", *words)
    )


count = functools.partial(quantity, usual=ANY, whole=True)
"""Declare a dataclass field for a whole number between two bounds, both included."""


WORDS = re.compile(r"(\w+)(?:: (.+?))?(?: \[(.+)\])?")
"""Pattern of key, meaning and source of a word: ``contact: law of impact [Stronge 1990]``."""


def words_of(rule: str) -> dict[str, Any]:
    """Return key, meaning and source of a declared word or text, by the pattern :data:`WORDS`."""
    found = WORDS.fullmatch(rule)
    assert found is not None, rule
    return dict(zip(("key", "meaning", "source"), found.groups(""), strict=True))


def choice(rule: str, *options: str) -> Any:
    """Declare a dataclass field for one of a few words; the first is the default."""
    return declared_field(options[0], Choice(options=options, **words_of(rule)))


def declared_field(default: Any, declared: Any) -> Any:
    """Return a dataclass field with its declaration."""
    return field(default=default, metadata={"declaration": declared})


@functools.cache
def declared_fields(kind: Any) -> dict[str, tuple[Range | Choice, Any]]:
    """Return declaration and default of each declared field of a parameter class, by the name of
    the field.
    """
    return {
        each.name: (each.metadata["declaration"], each.default)
        for each in dataclasses.fields(kind)
        if each.metadata
    }


def declarations(kind: Any) -> dict[str, Range | Choice]:
    """Return the declarations of a parameter class, by the names of its fields."""
    return {name: declared for name, (declared, _) in declared_fields(kind).items()}


def validate(instance: Any) -> None:
    """Check every declared field of a frozen dataclass instance, and store it as a plain number or
    word.

    A text such as "27 mm" is parsed as if typed. An unusual value causes a warning.
    """
    kind: Any = type(instance)
    for name, (declared, default) in declared_fields(kind).items():
        given = getattr(instance, name)
        if given is None and declared.optional:
            continue
        value = declared.parse(given) if isinstance(given, str) else declared.check(given)
        object.__setattr__(instance, name, value)
        if value != default and (line := unusual_value(declared, default, value, given)):
            warnings.warn(line, UnusualValueWarning, stacklevel=4)


class Computed(float):
    """Number of a declared field that was not given: its object computes it from other fields.

    A copy by ``dataclasses.replace`` computes it again, and a tool's file omits it.
    """

    __slots__ = ()


class UnusualValueWarning(UserWarning):
    """Warning: the value of a parameter is so far from its default that its unit may be mistaken."""


class UnknownFieldError(TypeError, ValueError):
    """A keyword that is no field of a parameter class."""


class Declared:
    """Base class of frozen dataclasses whose declared fields are checked when an object is made.

    Unusual values cause a warning. The docstring of such a class lists key, meaning, unit, range,
    default and source of each declared field.
    """

    __slots__ = ()

    def __init_subclass__(cls) -> None:
        """Document the fields before the dataclass decorator replaces them."""
        own = {
            name: each for name, each in vars(cls).items() if isinstance(each, dataclasses.Field)
        }
        if not own:  # the decorator creates the class a second time, for its slots
            return
        lines = [inspect.cleandoc(cls.__doc__ or ""), "", "Attributes:"]
        for name, each in {**getattr(cls, "__dataclass_fields__", {}), **own}.items():
            if (declared := each.metadata.get("declaration")) is not None:
                key = "" if name == declared.key else f" Key {declared.key}."
                unit = "" if declared.unit in ("1", "word") else f", {declared.unit}"
                default = (
                    each.default if isinstance(each.default, str | None) else f"{each.default:.9g}"
                )
                words = f"{name}: {declared.meaning}{unit}.{key} Must be {declared.allowed}. Default {default} ({declared.source})."
                lines += textwrap.wrap(
                    words, 100, initial_indent="    ", subsequent_indent="        "
                )
        cls.__doc__ = "\n".join(lines)

    def __new__(cls, *_: Any, **given: Any) -> Any:
        """Refuse the name of an unknown field, and propose the likely one."""
        known = [each.name for each in dataclasses.fields(cls)]  # type: ignore[arg-type]
        for name in given:
            if name not in known:
                raise UnknownFieldError(
                    f"{cls.__name__}: unknown field {name!r}; {likely_key(name, known)}"
                )
        return super().__new__(cls)

    def __post_init__(self) -> None:
        validate(self)
