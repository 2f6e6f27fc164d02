"""What the commands of studies share: the files that they write, how long they simulate, how they end."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lcpflex.errors import ModelError, writable_path

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["add_files", "check_files", "duration_of", "shown"]

PICTURES = (".png", ".pdf", ".svg")


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


def check_files(request: argparse.Namespace) -> None:
    """Raise ModelError for files that cannot be written, before anything is run."""
    for name in ("output", "csv"):
        path = getattr(request, name)
        if path is not None:
            writable_path(f"--{name}", path)
    if request.output is not None and request.output.suffix.lower() not in PICTURES:
        raise ModelError(f"--output: {str(request.output)!r}; expected a name that ends in {', '.join(PICTURES)}")


def duration_of(request: argparse.Namespace, known: float | None) -> float:
    """The duration asked for, or that of the scene [s]; raises ModelError if there is neither."""
    duration = known if request.duration is None else request.duration
    if duration is None:
        raise ModelError(f"--duration: not given, and {request.scene!r} does not say; expected a number of seconds > 0")
    return float(duration)


def shown(request: argparse.Namespace, study: Study, success: bool) -> int:
    """Print a study and write its files. The exit code: 130 after Ctrl-C, else 0 for ``success`` and 1 without."""
    print(study)
    if request.csv is not None:
        study.csv(request.csv)
        print(f"\ntable: {request.csv.resolve()}")
    if request.output is not None:
        study.plot().savefig(request.output, dpi=150)
        print(f"\nchart: {request.output.resolve()}")
    if not study.complete:
        print("lcpflex: interrupted", file=sys.stderr)
        return 130
    return 0 if success else 1
