"""Scenes by the text that names them: of the gallery, or of a file of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from lcpflex.basics.names import meant
from lcpflex.cli import later
from lcpflex.cli.reading import called, in_file, load_named
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.runs.case import Case

__all__ = ["Loader", "case_named", "case_or_function", "scene_named"]

Loader: TypeAlias = Callable[[str], tuple[Any, float | None, Any]]  # scene, duration [s] and stepper of a text


def case_named(name: str) -> Case:
    """The case of the gallery of that name; raises ModelError where there is none."""
    cases = later.scenes()
    if name not in cases:
        raise ModelError(
            f"SCENE: no scene {name[:80]!r}{meant(name[:80], cases)}; expected file.py:function or one of "
            f"{', '.join(cases)}"
        )
    return cases[name]


def case_or_function(text: str) -> Any:
    """The case of the gallery, or the function of a file, that SCENE names."""
    if not in_file(text):
        return case_named(text)
    function = load_named("SCENE", text)
    if not callable(function):
        path, _, name = text.rpartition(":")
        raise ModelError(f"SCENE: {path[-80:]!r} has no function {name[:40]!r}; expected one that returns a Scene")
    return function


def scene_named(text: str) -> tuple[Any, float | None, Any]:
    """Scene, its duration [s] and its stepper, the last two None where only a scene was given."""
    there = case_or_function(text)
    takes = "a function without arguments that returns a scene"
    made = there if isinstance(there, later.Case) else called("SCENE", text, there, takes)
    if isinstance(made, later.Case):
        return made.build(), made.duration, made.stepper
    return made, None, None
