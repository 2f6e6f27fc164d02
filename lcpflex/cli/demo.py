"""``lcpflex demo``: a flexible pendulum falls onto its stop."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.cli import later
from lcpflex.cli.reading import save_figure
from lcpflex.cli.scenes import case_named
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["add_demo"]

DEMO = "pendulum"  # the flexible pendulum that falls onto its stop, with friction


def add_demo(commands: Any) -> None:
    """Add the command to the subparsers."""
    demo = commands.add_parser("demo", help="a flexible pendulum falls onto its stop: summary, picture and film")
    demo.add_argument("--folder", type=Path, default=Path(), help="where to write the files (default: here)")
    demo.set_defaults(command=_demo)


def _demo(request: argparse.Namespace) -> int:
    folder = _checked_folder(request.folder)
    case = case_named(DEMO)
    print(f"{case.title}\n", flush=True)
    result = later.simulate(case.build(), case.duration, case.stepper)
    if result.complete:
        print("measuring the error, with a half and a quarter of the step ...", file=sys.stderr, flush=True)
        result.verify(other=False)  # another method would be compiled first
    print(result.summary(), "\n", flush=True)
    picture, chart, film = (folder / f"lcpflex-demo.{name}" for name in ("png", "chart.png", "gif"))
    save_figure(result.draw(_telling_time(result)), picture)
    save_figure(result.plot(), chart)
    print("drawing the film ...", file=sys.stderr, flush=True)
    result.animate(film, fps=20.0)
    print("written: " + "\n         ".join(str(path.resolve()) for path in (picture, chart, film)))
    return 0 if result.complete else 1


def _telling_time(result: Result) -> float:
    """The stored instant, of those with a contact force, at which the bodies are bent most."""
    touching = result.force[:, :, 0].sum(axis=1) > 0.0
    return float(result.times[np.where(touching, result.energies.elastic, -1.0).argmax()])


def _checked_folder(folder: Path) -> Path:
    """Refuse a folder that cannot be written to before time is spent."""
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise ModelError(f"folder: {str(folder)!r} cannot be written to; expected an existing, writable folder")
    return folder
