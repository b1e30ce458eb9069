"""Declarations of parameters: default, unit, range, meaning and source in one place.

A declaration checks every value that enters a parameter object, whether from Python, a file or the
command line. It is also the documentation of its field and the entry in a script's list of
parameters.
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
"""Value of ``usual`` for a number whose default does not indicate likely values, such as an
accuracy: no magnitude causes a warning."""

RULE = re.compile(r"(\S+) (<=?) (\w+) <= ([^\s:]+)(?: ([^:\[]+?))?(?:: (.+?))?(?: \[(.+)\])?")
"""Pattern of the text that declares a number: range, unit, meaning and source.

An example is ``0 <= hub_radius <= 10 m: radius of the root circle [Zhang 2020, eq. 2.2]``."""


def quantity(
    default: float | None,
    rule: str,
    *,
    usual: tuple[float, float] | None = None,
    needs: str = "",
    whole: bool = False,
) -> Any:
    """Declare a dataclass field for a real number.

    Args:
        default: default value; None makes the parameter optional.
        rule: range, unit, meaning and source, in the form of :data:`RULE`.
        usual: smallest and largest magnitude that causes no warning; None means within a factor of
            100 of the default.
        needs: condition on another key without which this key has no effect.
        whole: whether the number must be whole.
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
"""Pattern of the text that declares a word: key, meaning and source, as in ``contact: law of impact
[Stronge 1990]``."""


def words_of(rule: str) -> dict[str, Any]:
    """Return key, meaning and source from the text that declares a word, in the form of
    :data:`WORDS`.
    """
    found = WORDS.fullmatch(rule)
    assert found is not None, rule
    return dict(zip(("key", "meaning", "source"), found.groups(""), strict=True))


def choice(rule: str, *options: str) -> Any:
    """Declare a dataclass field whose value is one of a few words; the first is the default.

    ``rule`` gives key, meaning and source, in the form of :data:`WORDS`.
    """
    return declared_field(options[0], Choice(options=options, **words_of(rule)))


def declared_field(default: Any, declared: Any) -> Any:
    """Return a dataclass field that carries its declaration as metadata."""
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
    """Check every declared field of a frozen dataclass instance, and replace it by its checked
    value.

    A text such as "27 mm" becomes a number in the declared unit. An unusual value causes a warning.

    Raises:
        ValueError: for a value that its declaration refuses.
    """
    kind: Any = type(instance)
    for name, (declared, default) in declared_fields(kind).items():
        given = getattr(instance, name)
        if given is None and declared.optional:
            continue
        value = declared.parse(given)
        object.__setattr__(instance, name, value)
        if value != default and (line := unusual_value(declared, default, value, given)):
            warnings.warn(line, UnusualValueWarning, stacklevel=4)


class Computed(float):
    """Value of a field that was not given but computed from other fields of its object.

    ``dataclasses.replace`` computes it again, and a tool file omits it.
    """

    __slots__ = ()


class UnusualValueWarning(UserWarning):
    """Warns that a parameter is so far from its default that its unit may be mistaken."""


class UnknownFieldError(TypeError, ValueError):
    """Raised for a keyword argument that is not a field of the parameter class."""


class Declared:
    """Base class of frozen parameter dataclasses, whose declared fields are checked on creation.

    Unusual values cause a warning. The docstring of a subclass lists key, meaning, unit, range,
    default and source of each declared field.
    """

    __slots__ = ()

    def __init_subclass__(cls) -> None:
        """Append a description of each declared field to the docstring of the subclass.

        This happens before the dataclass decorator replaces the fields by their defaults.
        """
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
        """Refuse an unknown keyword argument, and suggest the most similar field.

        Raises:
            UnknownFieldError: for a keyword argument that is not a field.
        """
        known = [each.name for each in dataclasses.fields(cls)]  # type: ignore[arg-type]
        for name in given:
            if name not in known:
                raise UnknownFieldError(
                    f"{cls.__name__}: unknown field {name!r}; {likely_key(name, known)}"
                )
        return super().__new__(cls)

    def __post_init__(self) -> None:
        validate(self)
