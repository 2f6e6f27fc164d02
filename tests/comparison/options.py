"""What ``tests/compare.py`` is asked for: its arguments, checked, and the choice of runs that they make."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.comparison.plan import STEPPERS, is_sensible

__all__ = ["BadArgumentError", "chosen", "parser"]


class BadArgumentError(Exception):
    """An argument that cannot be; the message names it, the value and what was expected."""


def parser() -> argparse.ArgumentParser:
    """Of the command line."""
    line = argparse.ArgumentParser(
        prog="compare.py", description="Run all scenes of the gallery in two checkouts, and say what differs."
    )
    line.add_argument("old", metavar="OLD", type=_checkout, help="folder of the checkout that is the measure")
    line.add_argument("new", metavar="NEW", type=_checkout, help="folder of the checkout to compare with it")
    line.add_argument("--scenes", metavar="A,B", type=_names, help="only these; default: all of the gallery")
    line.add_argument("--steppers", metavar="X,Y", type=_steppers, help=f"only these of {', '.join(STEPPERS)}")
    line.add_argument("--jobs", metavar="N", type=_jobs, default=1, help="processes at a time (default 1)")
    line.add_argument(
        "--seconds", metavar="S", type=_seconds, default=300.0,
        help="a run without an end after S seconds has died (default 300); no run is shortened by it",
    )  # fmt: skip
    line.add_argument("--list", action="store_true", help="list the runs, and run nothing")
    line.add_argument(
        "--keep", metavar="FOLDER", type=Path, help="keep what was run there; default: a folder that goes"
    )
    line.add_argument("--old-python", metavar="PATH", type=_python, default=sys.executable, help="interpreter of OLD")
    line.add_argument("--new-python", metavar="PATH", type=_python, default=sys.executable, help="interpreter of NEW")
    return line


def chosen(
    scenes: Sequence[str] | None, steppers: Sequence[str] | None, there: Iterable[str]
) -> tuple[tuple[str, str], ...]:
    """The runs that are asked for, by scene and stepper. Raises BadArgumentError for a scene that is not there."""
    known = tuple(there)
    for name in scenes or ():
        if name not in known:
            raise BadArgumentError(f"--scenes: {name!r} was given; expected names of {', '.join(known)}")
    return tuple(
        (scene, stepper)
        for scene in known
        for stepper in STEPPERS
        if (not scenes or scene in scenes) and (not steppers or stepper in steppers) and is_sensible(scene, stepper)
    )


def _checkout(text: str) -> Path:
    path = Path(text)
    for part in ("lcpflex/__init__.py", "solvers/__init__.py"):
        if not (path / part).is_file():
            raise argparse.ArgumentTypeError(
                f"{text!r} was given; expected the folder of a checkout, with {part} in it"
            )
    return path.resolve()


def _names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",") if name.strip())
    if not names:
        raise argparse.ArgumentTypeError(f"{text!r} was given; expected names with commas between them")
    return names


def _steppers(text: str) -> tuple[str, ...]:
    names = _names(text)
    for name in names:
        if name not in STEPPERS:
            raise argparse.ArgumentTypeError(f"{name!r} was given; expected names of {', '.join(STEPPERS)}")
    return names


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} was given; expected a whole number >= 1")
    return int(text)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} was given; expected a number of seconds > 0")
    return value


def _python(text: str) -> str:
    if not Path(text).is_file():
        raise argparse.ArgumentTypeError(f"{text!r} was given; expected the path of a python")
    return text
