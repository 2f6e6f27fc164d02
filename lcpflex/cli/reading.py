"""What the commands share: objects in files of the user's own, files that are written, the duration, the exit code."""

from __future__ import annotations

import argparse
import importlib.util
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

from lcpflex.basics.names import meant
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import LcpflexError, ModelError, shown, writable_path

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "PICTURES",
    "add_files",
    "callable_named",
    "called",
    "check_picture",
    "check_files",
    "deliver",
    "duration_of",
    "in_file",
    "load_named",
    "methods_named",
    "one_named",
    "outputs_named",
    "save_figure",
]

PICTURES = (".png", ".pdf", ".svg")
WORDS = ("table", "chart")  # that tell where the files of a study are


class Study(Protocol):
    """The outcome of a study: a text, a table and a chart."""

    @property
    def complete(self) -> bool: ...
    def csv(self, path: Path, /) -> Any: ...
    def plot(self) -> Figure: ...


def add_files(command: argparse.ArgumentParser) -> None:
    """Add the options for the chart, the table and the duration."""
    command.add_argument("--output", type=Path, metavar="FILE", help="write the chart to this png, pdf or svg file")
    command.add_argument("--csv", type=Path, metavar="FILE", help="write every run to this csv file")
    command.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")


def check_files(request: argparse.Namespace, picture: str = "output", data: str = "csv") -> None:
    """Raise ModelError for files that cannot be written, before anything is run; by the names of their options."""
    check_picture(f"--{picture}", getattr(request, picture))
    if getattr(request, data) is not None:
        writable_path(f"--{data}", getattr(request, data))


def check_picture(option: str, path: Path | None) -> None:
    """Raise ModelError for a picture of another kind or one that cannot be written."""
    if path is None:
        return
    if path.suffix.lower() not in PICTURES:
        raise ModelError(f"{option}: {str(path)[-80:]!r}; expected a name that ends in {', '.join(PICTURES)}")
    writable_path(option, path)


def in_file(text: str) -> bool:
    """Whether a text has the form ``file.py:name``."""
    path, colon, name = text.rpartition(":")
    return bool(colon and name) and path.endswith(".py")


def load_named(option: str, text: str) -> Any:
    """The object of a Python file of the user's own that ``file.py:name`` names; the file may import its neighbours.

    Raises ModelError with the name of the option for a file that is not there or fails, and for an unknown name.
    """
    file, _, name = text.rpartition(":")
    path = Path(file)
    if not path.is_file():
        raise ModelError(f"{option}: no file {file[-80:]!r}; expected file.py:name")
    module = called(option, file, lambda: _module(path.resolve(), path.stat().st_mtime_ns), "a file that can be run")
    try:
        return getattr(module, name)
    except AttributeError:
        known = [key for key in vars(module) if not key.startswith("_")]
        raise ModelError(
            f"{option}: {file[-80:]!r} has no function {name[:40]!r}{meant(name[:40], known)}; expected one of "
            f"{', '.join(known)[:200]}"
        ) from None


@cache
def _module(path: Path, _changed: int) -> ModuleType:
    """The file as a module, run once however often it is named, and again after it ``_changed``."""
    specification = importlib.util.spec_from_file_location(path.stem, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    sys.modules[path.stem] = module  # dataclasses of the file look themselves up there
    specification.loader.exec_module(module)
    return module


def called(option: str, text: str, function: Callable[[], Any], expected: str) -> Any:
    """What a function of the user's own returns; what it raises as ModelError, with the line of it."""
    try:
        return function()
    except LcpflexError:
        raise
    except Exception as error:
        where = extract_tb(error.__traceback__)[-1]
        raise ModelError(
            f"{option}: {text[-80:]!r} raised {type(error).__name__}: {str(error)[:120]} ({where.filename[-80:]}, line "
            f"{where.lineno}); expected {expected}"
        ) from error


def callable_named(option: str, text: str, attribute: str, expected: str) -> Any:
    """What ``file.py:name`` names: something that can be called, or that has the attribute, and is no class."""
    found = load_named(option, text)
    if isinstance(found, type) or not (callable(found) or hasattr(found, attribute)):
        raise ModelError(f"{option}: {text[-80:]!r} is {shown(found)}; expected {expected}")
    return found


def one_named(option: str, text: str, known: Mapping[str, Any], attribute: str, expected: str) -> Any:
    """What is known by that name, or what ``file.py:name`` names, as for :func:`callable_named`."""
    if in_file(text):
        return callable_named(option, text, attribute, expected)
    if text not in known:
        raise no_such(option, text, known)
    return known[text]


def no_such(option: str, text: str, known: Iterable[str], plain: Callable[[str], str] = str) -> ModelError:
    """What to raise for a text that is none of the names, compared as ``plain`` has them."""
    near = meant(plain(text[:80]), map(plain, known))
    return ModelError(f"{option}: {text[:80]!r}{near}; expected file.py:name or one of {', '.join(known)}")


def outputs_named(option: str, texts: Sequence[str], known: Sequence[str]) -> list[Any]:
    """Outputs by name, and those of the user's own as ``file.py:name``: a function of a Result, or an Output."""
    names, expected = {name: name for name in known}, "a function of a Result, or an Output"
    return [one_named(option, text, names, "function", expected) for text in texts]


def methods_named(option: str, texts: Sequence[str], known: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Steppers by label: those ``known`` by name, and those of the user's own as ``file.py:name``.

    That is a stepper, a sequence of them from coarse to fine, a mapping of label to either, or a function without
    arguments that returns one of these.
    """
    chosen: dict[str, Any] = {}
    for text in texts:
        if in_file(text):
            chosen |= _own_methods(option, text)
            continue
        found = {label: one for label, one in known().items() if _plain(label) == _plain(text)}
        if not found:
            raise no_such(option, text, known(), _plain)
        chosen |= found
    return chosen


def _own_methods(option: str, text: str) -> dict[str, Any]:
    found = load_named(option, text)
    if callable(found) and not hasattr(found, "start"):
        found = called(option, text, found, "a function without arguments that returns steppers")
    if not isinstance(found, dict):
        found = {text.rpartition(":")[2]: found}
    for label, one in found.items():
        steppers = one if isinstance(one, list | tuple) else [one]
        if not steppers or any(isinstance(each, type) or not hasattr(each, "start") for each in steppers):
            raise ModelError(f"{option}: {text[-80:]!r} has {shown(one)} as {label!r}; expected a stepper, or several")
    return {str(label): one for label, one in found.items()}


def _plain(label: str) -> str:
    return label.lower().replace(",", "").replace(" ", "-").replace("generalised", "generalized")


def duration_of(request: argparse.Namespace, known: float | None) -> float:
    """The duration asked for, or that of the scene [s]; raises ModelError if there is neither."""
    duration = known if request.duration is None else request.duration
    if duration is None:
        raise ModelError(
            f"--duration: not given, and {shown(request.scene)} does not say; expected a number of seconds > 0"
        )
    return float(duration)


def deliver(
    request: argparse.Namespace, study: Study, success: bool, picture: str = "output", words: Sequence[str] = WORDS
) -> int:
    """Write the files of a study. The exit code: 130 after Ctrl-C, else 0 for ``success`` and 1 without.

    picture: the option for it; words: for table and picture.
    """
    if request.csv is not None:
        study.csv(request.csv)
        print(f"\n{words[0]}: {request.csv.resolve()}")
    if (path := getattr(request, picture)) is not None:
        with whole_file(picture, path) as part:
            study.plot().savefig(part, dpi=150)
        print(f"\n{words[1]}: {path.resolve()}")
    if not study.complete:
        print("lcpflex: interrupted", file=sys.stderr)
        return 130
    return 0 if success else 1


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture whole or not at all; raises ModelError where it cannot be written."""
    try:
        with whole_file("path", path) as part:
            figure.savefig(part, dpi=150)
    except (OSError, ValueError) as error:
        raise ModelError(f"path: cannot write {str(path)!r}: {error}") from error
