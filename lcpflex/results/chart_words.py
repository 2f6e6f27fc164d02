"""Titles and names short enough for a chart, and still told apart."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import MISSING, fields, is_dataclass
from importlib import import_module
from typing import Any

__all__ = ["stepper_words", "told_apart"]

_LONGEST = 28  # characters of a name in a legend
_TITLE = 100  # characters of a title
_UNITS = {"step": " s", "max_step": " s", "first_step": " s"}


def stepper_words(text: str) -> str:
    """A stepper in words, from its ``repr``: its name, and what of its options is not the default.

    ``MoreauJean(step=1e-05, theta=0.5, ...)`` becomes "MoreauJean, step 1e-05 s". What cannot be read stays as it is.
    """
    try:
        call = ast.parse(text, mode="eval").body
        words = ", ".join(_call_words(call)) if isinstance(call, ast.Call) else text
    except (SyntaxError, ValueError):
        words = text
    return words if len(words) <= _TITLE else words[: _TITLE - 3] + "..."


def told_apart(names: Sequence[str], longest: int = _LONGEST) -> list[str]:
    """``names``, those that are too long without their middle, and numbered where that makes them equal."""
    short = [name if len(name) <= longest else _without_middle(name, longest) for name in names]
    doubled = {name for name in short if short.count(name) > 1}
    return [f"{name} ({k + 1})" if name in doubled else name for k, name in enumerate(short)]


def _without_middle(name: str, longest: int) -> str:
    head = (longest - 3) // 2
    return name[:head] + "..." + name[len(name) - (longest - 3 - head) :]


def _call_words(call: ast.Call) -> list[str]:
    """Name of what is called and its options, those at their defaults left out."""
    name = ast.unparse(call.func)
    defaults = _defaults(name)
    words = [name]
    for option in call.keywords:
        value = ast.unparse(option.value)
        if option.arg is None or value == defaults.get(option.arg):
            continue
        if isinstance(option.value, ast.Call):
            inner, *rest = _call_words(option.value)
            value = f"{inner} ({', '.join(rest)})" if rest else inner
        words.append(f"{option.arg.replace('_', ' ')} {value}{_UNITS.get(option.arg, '')}")
    return words


def _defaults(name: str) -> dict[str, str]:
    """What the options of a public class are if they are not given, as written by ``ast``."""
    library: Any = import_module("lcpflex")
    kind: Any = getattr(library, name, None) or getattr(library.laws, name, None)
    if not is_dataclass(kind):
        return {}
    found = {}
    for option in fields(kind):
        value = option.default_factory() if option.default_factory is not MISSING else option.default
        try:
            found[option.name] = ast.unparse(ast.parse(repr(value), mode="eval"))
        except SyntaxError:  # no value, or one that is not written as it is made
            continue
    return found
