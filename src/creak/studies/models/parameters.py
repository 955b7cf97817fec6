"""Numbers of a study and its deck by their keys: which there are that modes depend on, where they begin."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.studies.design.properties import properties_of, sections_of
from creak.studies.file.changes import value_at
from creak.studies.file.places import dotted
from creak.studies.file.reader import Study

RANGE = 10.0
"""A parameter without bounds may rise and fall by this factor."""
EXPECTED = "KEY, or KEY=LOW:HIGH, as section.PANEL.thickness=0.8:1.5"
OF_DECK = ("material", "section")


@dataclass(frozen=True)
class Parameter:
    """A number that may change."""

    key: str
    """As `creak run --set` takes it."""
    start: float
    low: float
    high: float


def read_parameters(study: Study, model: Model, texts: Sequence[str]) -> list[Parameter]:
    """Parameters of `KEY` or `KEY=LOW:HIGH`; without bounds a tenth to ten times the start.

    Raises
    ------
    InputError : an unknown key, one given twice, one that is no positive number; bounds that are none, or that leave
        the start out.
    """
    found: dict[str, Parameter] = {}
    for text in texts:
        given, sign, bounds = (part.strip() for part in text.partition("="))
        if not given or (sign and not bounds):
            raise InputError(f"{text!r} is no parameter", expected=EXPECTED)
        key = _spelled(study, given)
        same = key.upper() if key.split(".")[0] in OF_DECK else key
        if same in found:
            raise InputError(f"the parameter {key} is given twice", fix="Give it once.")
        start = start_of(study, model, key)
        low, high = _bounds(text, bounds) if sign else (start / RANGE, start * RANGE)
        if not low < start < high:
            raise InputError(
                f"{text}: {key} is {start:g} in the study, which the bounds leave out",
                expected="LOW below and HIGH above it",
                fix="Widen them.",
            )
        found[same] = Parameter(key, start, low, high)
    return list(found.values())


def start_of(study: Study, model: Model, key: str) -> float:
    """The value of a key, of the study or else of the deck.

    Raises
    ------
    InputError : there is none, or it is no positive number.
    """
    value = value_at(study.config.model_dump(by_alias=True), key)
    if value is None and key.split(".")[0] in OF_DECK:
        kind, *words, word = key.split(".")
        name = ".".join(words)
        every = properties_of(model)
        own = sections_of(model, name) if kind == "section" else (name,)
        found = {every.get((kind, one.upper(), word)) for one in own}
        value = found.pop() if len(found) == 1 else None
    if value is None:
        known = candidates(study, model)
        raise InputError(
            f"{key} is no number of the study or its deck",
            expected="a key that `creak run --set` takes, or a number of the deck's materials and sections",
            fix=suggest(key, known),
        )
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise InputError(
            f"{key} is {value!r} in the study",
            expected="a number above 0: parameters are changed by factors",
            fix="Name one number; those of a list by their place, as clip.0.stiffness.4.",
        )
    return float(value)


def candidates(study: Study, model: Model) -> list[str]:
    """Keys of all that the modes can depend on: numbers of materials and sections, stiffness of bushings and of joints.

    Parameters
    ----------
    model : of the deck.
    """
    keys = [_spelled(study, dotted(key)) for key in properties_of(model) if not any("." in word for word in key)]
    for i, clip in enumerate(study.config.clip):
        if isinstance(clip.stiffness, list):
            keys += [f"clip.{i}.stiffness.{j}" for j, k in enumerate(clip.stiffness) if k > 0.0]
        else:
            keys.append(f"clip.{i}.ageing")
    keys += [f"contact.{n}.stiffness" for n, t in study.config.contact.items() if not isinstance(t.stiffness, str)]
    return keys + [f"connector.{i}.stiffness" for i in range(len(study.config.connector))]


def _spelled(study: Study, key: str) -> str:
    """The key with the name of a material or section as the study writes it."""
    kind, *name, word = key.split(".")
    if kind not in OF_DECK or not name:
        return key
    given = study.config.material if kind == "material" else study.config.section
    same = next((n for n in given if n.upper() == ".".join(name).upper()), ".".join(name))
    return f"{kind}.{same}.{word}"


def _bounds(text: str, bounds: str) -> tuple[float, float]:
    words = bounds.split(":")
    try:
        low, high = (float(word) for word in words)
    except ValueError:
        raise InputError(f"{text!r} has no bounds", expected=EXPECTED) from None
    if not 0.0 < low < high < math.inf:
        raise InputError(f"{text!r} has bounds that are none", expected="0 < LOW < HIGH")
    return low, high
