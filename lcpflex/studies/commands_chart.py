"""``lcpflex chart SCENE``: which method reaches an accuracy soonest on this scene?"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lcpflex.errors import ModelError, writable_path

__all__ = ["add_chart"]

LIMIT = 2.0  # wall time [s] of a run: with three repetitions a series of factors 3 takes about six times as long
PICTURES = (".png", ".pdf", ".svg")


def add_chart(commands: Any, load: Callable[[str], tuple[Any, float | None, Any]]) -> None:
    """Add the command to the subparsers; ``load`` makes scene, duration and stepper of the text that names a scene."""
    chart = commands.add_parser("chart", help="work against precision: which method reaches an accuracy soonest")
    chart.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    chart.add_argument("--output", type=Path, metavar="FILE", help="write the chart to this png, pdf or svg file")
    chart.add_argument("--csv", type=Path, metavar="FILE", help="write every run to this csv file")
    chart.add_argument("--quantity", metavar="NAME", help="drawn and advised on: trajectory (default), impulses, "
                       "peak force or energy")  # fmt: skip
    chart.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")
    chart.add_argument("--repeats", type=int, default=3, metavar="N", help="timed runs whose median counts")
    chart.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS",
                       help=f"refine a method while a run takes no longer (default: {LIMIT:g})")  # fmt: skip
    chart.set_defaults(command=lambda request: _chart(request, load))


def _chart(request: argparse.Namespace, load: Callable[[str], tuple[Any, float | None, Any]]) -> int:
    """Run the study, print table and advice, write the files. 1 if no method has a sound run, 130 after Ctrl-C."""
    from lcpflex.studies.outputs import standard_outputs
    from lcpflex.studies.work_precision import work_precision

    for name in ("output", "csv"):
        path = getattr(request, name)
        if path is not None:
            writable_path(f"--{name}", path)
    if request.output is not None and request.output.suffix.lower() not in PICTURES:
        raise ModelError(f"--output: {str(request.output)!r}; expected a name that ends in {', '.join(PICTURES)}")
    outputs = [output.name for output in standard_outputs()]
    if request.quantity is not None:
        if request.quantity not in outputs:
            raise ModelError(f"--quantity: {request.quantity!r}; expected one of {', '.join(outputs)}")
        outputs.remove(request.quantity)
        outputs.insert(0, request.quantity)  # the first one is drawn and decides on the reference
    scene, duration, _ = load(request.scene)
    duration = duration if request.duration is None else request.duration
    if duration is None:
        raise ModelError(f"--duration: not given, and {request.scene!r} does not say; expected a number of seconds > 0")
    work = work_precision(
        {request.scene: scene}, duration=duration, repeats=request.repeats, limit=request.limit, outputs=outputs
    )
    print(work)
    if request.csv is not None:
        work.csv(request.csv)
        print(f"\ntable: {request.csv.resolve()}")
    if request.output is not None:
        work.plot().savefig(request.output, dpi=150)
        print(f"\nchart: {request.output.resolve()}")
    if not work.complete:
        print("lcpflex: interrupted", file=sys.stderr)
        return 130
    return 0 if any(not point.failure for point in work.points) else 1
