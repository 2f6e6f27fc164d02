"""``lcpflex chart SCENE``: which method reaches an accuracy soonest on this scene?"""

from __future__ import annotations

import argparse
import math
from typing import Any

from lcpflex.accuracy.outputs import known_outputs, standard_outputs
from lcpflex.cli import later
from lcpflex.cli.reading import add_files, check_files, deliver, duration_of, methods_named, outputs_named
from lcpflex.cli.scenes import Loader, scene_named
from lcpflex.errors import ModelError, in_range

__all__ = ["add_chart"]

LIMIT = 1.0  # wall time [s] of a run: with three repetitions a series of factors 3 takes about six times as long


def add_chart(commands: Any, load: Loader = scene_named) -> None:
    """Add the command to the subparsers; ``load`` makes scene, duration and stepper of the text that names a scene."""
    chart = commands.add_parser("chart", help="work against precision: which method reaches an accuracy soonest")
    chart.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    chart.add_argument("--quantity", action="append", metavar="NAME", help="may be repeated, the first is drawn and "
                       "advised on: trajectory (default), motion, impulses, peak force, energy, or file.py:name of "
                       "a function of a result")  # fmt: skip
    chart.add_argument("--method", action="append", metavar="NAME", help="may be repeated: a method by its name, such "
                       "as event-driven, or file.py:name of steppers from coarse to fine (default: all)")  # fmt: skip
    add_files(chart)
    chart.add_argument("--repeats", type=int, default=3, metavar="N", help="timed runs whose median counts")
    chart.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS",
                       help=f"refine a method while a run takes no longer (default: {LIMIT:g})")  # fmt: skip
    chart.set_defaults(command=lambda request: _chart(request, load))


def _chart(request: argparse.Namespace, load: Loader) -> int:
    """Run the study, print table and advice, write the files. 1 if no method has a sound run, 130 after Ctrl-C."""
    check_files(request)
    if request.repeats < 1:
        raise ModelError(f"--repeats: {request.repeats}; expected at least 1 timed run")
    in_range("--limit", request.limit, 0.0, math.inf, open_ends=True)
    asked = outputs_named("--quantity", request.quantity or (), tuple(known_outputs()))
    others = [output.name for output in standard_outputs() if output.name not in asked]
    scene, duration, _ = load(request.scene)
    duration = in_range("--duration", duration_of(request, duration), 0.0, math.inf, open_ends=True)
    methods = methods_named("--method", request.method or (), lambda: later.standard_methods(duration))
    work = later.work_precision(
        {request.scene: scene},
        methods or None,
        duration=duration,
        repeats=request.repeats,
        limit=request.limit,
        outputs=[*asked, *others],  # the first one is drawn and decides on the reference
    )
    print(work)
    return deliver(request, work, any(not point.failure for point in work.points))
