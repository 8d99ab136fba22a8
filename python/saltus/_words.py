"""Arguments of Python as words of the command, and its messages with the names of arguments."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from . import _saltus
from ._saltus import SaltusError
from .answers import Answer
from .jumps import robot_of

__all__ = ["Place", "ask", "flag_of", "words_of"]

UNIT = re.compile(r"_(rad_s|m_s|per_s|rad|deg|psi|s|m)$")
"""What the name of an argument says beside the flag: `omega_rad_s` is `--omega`."""

SPANS = {"firing_angles_rad", "valve_range_s", "state"}
"""Arguments whose parts have colons between them."""
REPEATED = {"set", "plant_set", "disturb", "reward", "state", "known", "effect", "courses"}
"""Arguments whose flag stands once for each item."""
ROBOTS = {"robot", "plant", "believed"}
"""Arguments that may be a robot."""
OTHER = {"lambda_": "lambda"}
"""Arguments that are not called like their flag."""

Place = str | os.PathLike[str] | Mapping[str, Any]
"""A file, or a course as a dictionary."""


def flag_of(argument: str) -> str:
    """The flag of an argument."""
    name = OTHER.get(argument, argument)
    return "--" + UNIT.sub("", name).replace("_", "-")


def ask(
    verb: str, positional: Iterable[Place], arguments: Mapping[str, Any], has_json: bool = True
) -> Answer:
    """The answer of the command; `arguments` by their Python names, None where not given."""
    yes, report, messages = words_of(verb, positional, arguments, ("--format=json",) if has_json else ())
    return Answer(report, yes, messages)


def words_of(
    verb: str, positional: Iterable[Place], arguments: Mapping[str, Any], more: tuple[str, ...]
) -> tuple[bool, str, list[str]]:
    """What the command says for these arguments."""
    words, files, names = [*verb.split(), *more], dict[str, str](), dict[str, str]()
    for argument, value in arguments.items():
        flag = flag_of(argument)
        names[flag] = argument
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
        elif argument in ROBOTS and not isinstance(value, (str, os.PathLike)):
            value = robot_of(value, argument)
            name = value.name if value.name not in files else f"{value.name} ({argument})"
            files[name] = value.toml
            words.append(f"{flag}={name}")
        elif argument in REPEATED:
            words.extend(f"{flag}={item}" for item in items(argument, value))
        else:
            words.append(f"{flag}={word(argument, value)}")
    places = []
    for place in positional:
        if isinstance(place, Mapping):
            if isinstance(place, Answer):
                raise SaltusError(f"an answer of saltus.{place.get('command')}: a course, as a file or a dictionary, or a file of a table")
            files["course.toml"] = _saltus.to_toml(dict(place))
            place = "course.toml"
        if not isinstance(place, (str, os.PathLike)):
            raise SaltusError(f"{place!r}: the path of a file, or a dictionary with its keys")
        places.append(os.fspath(place))
    if places:
        words += ["--", *places]
    try:
        return _saltus.command(words, files)
    except SaltusError as error:
        raise SaltusError(with_names(str(error), names)) from None


def with_names(text: str, names: Mapping[str, str]) -> str:
    """A message of the command with arguments in the place of their flags."""
    return re.sub(r"--[a-z][a-z-]*", lambda found: names.get(found[0], found[0]), text)


def items(argument: str, value: Any) -> list[str]:
    """Items of an argument that takes several: a text, a list of texts, or a mapping."""
    if isinstance(value, Mapping):
        return [f"{key}={item(argument, it)}" for key, it in value.items()]
    if isinstance(value, str):
        return [value]
    try:
        all_of = list(value)
    except TypeError:
        all_of = [value]
    if not all(isinstance(it, str) for it in all_of):
        raise SaltusError(f"{argument} = {value!r}: a text, a list of texts or a dictionary")
    return all_of


def item(argument: str, value: Any) -> str:
    """A value of a mapping; of `known` a value and its standard deviation."""
    if argument == "known" and isinstance(value, (tuple, list)) and len(value) == 2:
        return f"{number(argument, value[0])}±{number(argument, value[1])}"
    if isinstance(value, (str, bool)):
        return str(value).lower() if isinstance(value, bool) else value
    return word(argument, value)


def word(argument: str, value: Any) -> str:
    """A value as one word: every digit of a number, commas between several."""
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, (tuple, list, np.ndarray)) or hasattr(value, "__array__"):
        between = ":" if argument in SPANS else ","
        rows = one_dimension(argument, value)
        # Pairs and triples, as knots and commanded speeds, have colons inside.
        parts = [":".join(number(argument, it) for it in row) if isinstance(row, (tuple, list)) else number(argument, row) for row in rows]
        if not parts:
            raise SaltusError(f"{argument}: is empty: one number or more")
        return between.join(parts)
    return number(argument, value)


def one_dimension(argument: str, value: Any) -> list[Any]:
    """A list of numbers, or of tuples of numbers where the argument takes such."""
    if isinstance(value, (tuple, list)):
        return list(value)
    array = np.asarray(value)
    if array.ndim > 1:
        raise SaltusError(f"{argument}: shape {array.shape}: one dimension")
    listed: list[Any] = np.atleast_1d(array).tolist()
    return listed


def number(argument: str, value: Any) -> str:
    """A number with every digit."""
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise SaltusError(f"{argument} = {value!r}: a number, or a text as in the command")
    return repr(int(value) if isinstance(value, (int, np.integer)) else float(value))


