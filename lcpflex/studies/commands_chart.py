"""``lcpflex chart SCENE``: which method reaches an accuracy soonest on this scene?"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from lcpflex.errors import ModelError
from lcpflex.studies.command_line import add_files, check_files, duration_of, shown

__all__ = ["add_chart"]

LIMIT = 2.0  # wall time [s] of a run: with three repetitions a series of factors 3 takes about six times as long


def add_chart(commands: Any, load: Callable[[str], tuple[Any, float | None, Any]]) -> None:
    """Add the command to the subparsers; ``load`` makes scene, duration and stepper of the text that names a scene."""
    chart = commands.add_parser("chart", help="work against precision: which method reaches an accuracy soonest")
    chart.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    chart.add_argument("--quantity", metavar="NAME", help="drawn and advised on: trajectory (default), impulses, "
                       "peak force or energy")  # fmt: skip
    add_files(chart)
    chart.add_argument("--repeats", type=int, default=3, metavar="N", help="timed runs whose median counts")
    chart.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS",
                       help=f"refine a method while a run takes no longer (default: {LIMIT:g})")  # fmt: skip
    chart.set_defaults(command=lambda request: _chart(request, load))


def _chart(request: argparse.Namespace, load: Callable[[str], tuple[Any, float | None, Any]]) -> int:
    """Run the study, print table and advice, write the files. 1 if no method has a sound run, 130 after Ctrl-C."""
    from lcpflex.studies.outputs import standard_outputs
    from lcpflex.studies.work_precision import work_precision

    check_files(request)
    outputs = [output.name for output in standard_outputs()]
    if request.quantity is not None:
        if request.quantity not in outputs:
            raise ModelError(f"--quantity: {request.quantity!r}; expected one of {', '.join(outputs)}")
        outputs.remove(request.quantity)
        outputs.insert(0, request.quantity)  # the first one is drawn and decides on the reference
    scene, duration, _ = load(request.scene)
    duration = duration_of(request, duration)
    work = work_precision(
        {request.scene: scene}, duration=duration, repeats=request.repeats, limit=request.limit, outputs=outputs
    )
    return shown(request, work, any(not point.failure for point in work.points))
