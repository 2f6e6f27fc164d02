"""``lcpflex right-size SCENE``: how few modes will do for each body?"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from lcpflex.errors import ModelError
from lcpflex.studies.command_line import add_files, check_files, duration_of, shown

__all__ = ["add_right_size"]

TOLERANCE = 1e-2
LIMIT = 60.0  # wall time of a run [s]


def add_right_size(commands: Any, load: Callable[[str], tuple[Any, float | None, Any]]) -> None:
    """Add the command to the subparsers; ``load`` makes scene, duration and stepper of the text that names a scene."""
    command = commands.add_parser(
        "right-size",
        help="the smallest bodies that will do: rigid, a few modes, or the full mesh",
        description="Climb from rigid bodies to full meshes until the outputs are within a tolerance of those of the "
        "full mesh; say which modes that takes, how far off it is, and what it saves. Exit code 1 if nothing is "
        "within the tolerance.",
    )
    command.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    command.add_argument("--tolerance", type=float, default=TOLERANCE, metavar="RATIO",
                         help=f"largest error of each quantity, relative to its range ({TOLERANCE:g})")  # fmt: skip
    command.add_argument("--quantity", action="append", metavar="NAME", help="may be repeated: motion, impulses, "
                         "trajectory, peak force or energy (default: motion and impulses)")  # fmt: skip
    add_files(command)
    command.add_argument("--step", type=float, metavar="SECONDS",
                         help="of Moreau-Jean steps; default: the stepper of the scene, another where rich bodies "
                         "cannot be trusted with it")  # fmt: skip
    command.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS",
                         help=f"leave out what takes longer for one run (default: {LIMIT:g})")  # fmt: skip
    command.set_defaults(command=lambda request: _right_size(request, load))


def _right_size(request: argparse.Namespace, load: Callable[[str], tuple[Any, float | None, Any]]) -> int:
    """Run the study, print table and sentence, write the files. 1 if nothing will do, 130 after Ctrl-C."""
    from lcpflex.steppers.moreau_jean import MoreauJean
    from lcpflex.studies.fidelity_scenes import known_outputs
    from lcpflex.studies.right_size import right_size

    check_files(request)
    for quantity in request.quantity or ():
        if quantity not in known_outputs():
            raise ModelError(f"--quantity: {quantity!r}; expected one of {', '.join(known_outputs())}")
    scene, duration, stepper = load(request.scene)
    duration = duration_of(request, duration)
    case = SimpleNamespace(build=lambda: scene, duration=duration, stepper=stepper)
    given = None if request.step is None else MoreauJean(step=request.step)
    found = right_size(case, request.quantity, request.tolerance, duration=duration, stepper=given, limit=request.limit)
    return shown(request, found, found.within)
