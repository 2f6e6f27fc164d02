"""``lcpflex right-size SCENE``: how few modes will do for each body?"""

from __future__ import annotations

import argparse
import math
from types import SimpleNamespace
from typing import Any

from lcpflex.cli import later
from lcpflex.cli.reading import add_files, callable_named, check_files, deliver, duration_of, in_file, outputs_named
from lcpflex.cli.scenes import Loader, scene_named
from lcpflex.errors import ModelError, in_range

__all__ = ["add_right_size"]

TOLERANCE = 1e-2
LIMIT = 60.0  # wall time of a run [s]


def add_right_size(commands: Any, load: Loader = scene_named) -> None:
    """Add the command to the subparsers; ``load`` makes scene, duration and stepper of the text that names a scene."""
    command = commands.add_parser(
        "right-size",
        help="the smallest bodies that will do: rigid, a few modes, or the full mesh",
        description="Climb from rigid bodies to full meshes until the outputs are within a tolerance of those of the "
        "full mesh; say which modes that takes, how far off it is, and what it saves. Exit code 1 if nothing is "
        "promised to be within the tolerance: because nothing is, or because the steps or richer bodies say no.",
    )
    command.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    command.add_argument("--tolerance", type=float, default=TOLERANCE, metavar="RATIO",
                         help=f"largest error of each quantity, relative to its range ({TOLERANCE:g})")  # fmt: skip
    command.add_argument("--quantity", action="append", metavar="NAME", help="may be repeated: motion, impulses, "
                         "trajectory, peak force, energy, or file.py:name of a function of a result (default: motion "
                         "and impulses)")  # fmt: skip
    add_files(command)
    command.add_argument("--step", type=float, metavar="SECONDS",
                         help="of Moreau-Jean steps; default: the stepper of the scene, another where rich bodies "
                         "cannot be trusted with it")  # fmt: skip
    command.add_argument("--stepper", metavar="NAME", help="file.py:name of a stepper, or of a function of the scene "
                         "that makes one")  # fmt: skip
    command.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS",
                         help=f"leave out what takes longer for one run (default: {LIMIT:g})")  # fmt: skip
    command.set_defaults(command=lambda request: _right_size(request, load))


def _right_size(request: argparse.Namespace, load: Loader) -> int:
    """Run the study, print table and sentence, write the files. 1 if nothing will do, 130 after Ctrl-C."""
    check_files(request)
    in_range("--tolerance", request.tolerance, 0.0, 1.0, open_ends=True)
    in_range("--limit", request.limit, 0.0, math.inf, open_ends=True)
    given = _stepper(request)
    outputs = outputs_named("--quantity", request.quantity or (), later.known_outputs())
    scene, duration, stepper = load(request.scene)
    duration = in_range("--duration", duration_of(request, duration), 0.0, math.inf, open_ends=True)
    case = SimpleNamespace(build=lambda: scene, duration=duration, stepper=stepper)
    found = later.right_size(
        case, outputs or None, request.tolerance, duration=duration, stepper=given, limit=request.limit
    )
    print(found)
    return deliver(request, found, found.within)


def _stepper(request: argparse.Namespace) -> Any:
    """The stepper asked for: Moreau-Jean with a step, or what a file of the user's own has; None where none is."""
    if request.stepper is None:
        if request.step is None:
            return None
        return later.MoreauJean(step=in_range("--step", request.step, 0.0, math.inf, open_ends=True))
    if request.step is not None:
        raise ModelError("--step: given with --stepper, which has its own; expected one of them")
    if not in_file(request.stepper):
        raise ModelError(f"--stepper: {request.stepper[:80]!r}; expected file.py:name")
    return callable_named("--stepper", request.stepper, "start", "a stepper, or a function of the scene that makes one")
