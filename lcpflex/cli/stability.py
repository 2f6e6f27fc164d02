"""``lcpflex stability SCENE --x step=1e-5:1e-2:8 --y friction=0:1:6``."""

from __future__ import annotations

import argparse
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.accuracy.outputs import known_outputs
from lcpflex.cli import later
from lcpflex.cli.reading import check_files, deliver, in_file, one_named, outputs_named
from lcpflex.cli.scenes import case_or_function
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.studies.criteria import Criteria

__all__ = ["add_stability"]

WIDE = 100.0  # ratio of the ends from which on values are spaced evenly in their logarithms
FINEST, COARSEST = 0.1, 100.0  # ends of the default axis, in steps of the scene's own stepper
COUNT = 7
SHARE = 1e-4  # of the duration, the step around which they lie where the stepper of the scene has none
MOST = 10_000  # cells of a map
LONGEST = 12  # digits of a count
OWN = "own"  # the truth of this library
RANGE = "NAME=START:STOP:COUNT"
STEPPED, UNSTEPPED = "moreau-jean", "acceleration-level"
STEP = 1e-4  # of methods where neither an axis nor the scene's own stepper gives one [s]


def add_stability(commands: Any, find: Callable[[str], Any] = case_or_function) -> None:
    """Add the command to the subparsers; ``find`` makes a Case, or a function that builds one, of SCENE."""
    command = commands.add_parser(
        "stability",
        help="map where in a plane of two parameters the methods work and how they fail elsewhere",
        description="Map where in a plane of two parameters the methods work and how they fail elsewhere. An axis is a "
        f"parameter of the scene or of the methods with its values, {RANGE} or NAME=VALUE,VALUE,... Ranges whose ends "
        f"are at least {WIDE:g} apart in ratio are spaced logarithmically. Parameters of the methods: step (all; the "
        "longest of event-driven), theta (moreau-jean), rtol (event-driven), rho_inf (generalized-alpha), "
        "dynamic_modes (massless-boundary), stiffness and damping (penalty, Verlet's steps). acceleration-level asks, "
        "without time stepping, whether the start has one motion. What a run says of itself is at best that there is "
        "no sign of trouble; --truth compares it with a fine run of the same scene, and shows the errors.",
    )
    command.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    command.add_argument("--x", metavar=RANGE, help="default: the step, about that of the scene")
    command.add_argument("--y", metavar=RANGE, help="default: none, one row only")
    command.add_argument(
        "--method", action="append", metavar="NAME", help=f"may be repeated: {', '.join(_methods())}, or file.py:name "
        f"of a stepper or a function of such parameters that makes one; default: {STEPPED}",
    )  # fmt: skip
    command.add_argument(
        "--truth", metavar="NAME", help="compare every run with a truth: 'own', a run of this library that another "
        "method confirms; or a method as above, confirmed by half its step or tolerances; default: none",
    )  # fmt: skip
    command.add_argument(
        "--tolerance", type=float, metavar="RATIO",
        help=f"largest error, relative to the truth, of a run that counts as sound; default: {Criteria().error:g}",
    )  # fmt: skip
    command.add_argument(
        "--quantity", action="append", metavar="NAME", help="compared with the truth, may be repeated: motion (the "
        "default), trajectory, impulses, peak force, energy, or file.py:name of a function of a result",
    )  # fmt: skip
    command.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")
    command.add_argument("--time-limit", type=float, metavar="SECONDS", help="computing time of a cell; default: none")
    command.add_argument("--plot", type=Path, metavar="FILE", help="write the map to this png, pdf or svg file")
    command.add_argument("--csv", type=Path, metavar="FILE", help="write every cell to this file")
    command.set_defaults(command=lambda request: _run(request, find))


def _run(request: argparse.Namespace, find: Callable[[str], Any]) -> int:
    check_files(request, "plot")
    for name in ("duration", "time_limit"):
        if getattr(request, name) is not None:
            in_range(f"--{name.replace('_', '-')}", getattr(request, name), 0.0, math.inf, open_ends=True)
    if request.truth is None and (request.tolerance is not None or request.quantity):
        option = "--quantity" if request.quantity else "--tolerance"
        raise ModelError(f"{option}: given without --truth; nothing is compared")
    tolerance = Criteria().error if request.tolerance is None else request.tolerance
    criteria = Criteria(error=in_range("--tolerance", tolerance, 0.0, 1.0, open_ends=True))
    quantities = outputs_named("--quantity", request.quantity or (), tuple(known_outputs()))
    scene = find(request.scene)
    if not (callable(scene) or hasattr(scene, "build")):
        raise ModelError(
            f"SCENE: {shown(request.scene)} is {shown(scene)}; expected a Case or a function that builds a scene"
        )
    known = _methods(getattr(getattr(scene, "stepper", None), "step", STEP))
    methods = {_label(text): _method("--method", text, known) for text in request.method or [STEPPED]}
    truth = True if request.truth == OWN else None
    if request.truth not in (None, OWN):
        steppers = {name: one for name, one in known.items() if name != UNSTEPPED}
        truth = _method("--truth", request.truth, {OWN: None, **steppers})
    asked = [("--x", request.x), ("--y", request.y)]
    axes: dict[str, list[Any]] = {}
    for option, text in asked:
        if text is not None:
            owners = [one for one in (getattr(scene, "build", scene), *methods.values()) if callable(one)]
            name, values = _axis(option, text, owners)
            if name in axes:
                raise ModelError(f"{option}: {shown(name)} was given twice; expected two parameters")
            axes[name] = values
    if request.x is None and "step" not in axes:
        axes = {"step": _default_steps(scene, request.duration), **axes}
    _check_size(axes, methods)
    found = later.stability(
        scene, methods, axes, request.duration, criteria=criteria, truth=truth, outputs=quantities or None,
        time_limit=request.time_limit,
    )  # fmt: skip
    print(f"{found}\n\n{found.table()}")
    return deliver(request, found, True, "plot", ("cells", "map"))


def _label(text: str) -> str:
    """The name of a function of a file without the file."""
    return text.rpartition(":")[2] if in_file(text) else text


def _method(option: str, text: str, known: Mapping[str, Any]) -> Any:
    """The method of that name, or the stepper or function of a file of the user's own."""
    return one_named(option, text, known, "start", "a stepper, or a function that makes one")


def _check_size(axes: Mapping[str, Sequence[Any]], methods: Mapping[str, Any]) -> None:
    """Refuse a map of more cells than anybody waits for."""
    cells = len(methods) * math.prod(map(len, axes.values()))
    if cells > MOST:
        raise ModelError(f"--x, --y: {cells} cells with {len(methods)} methods; expected at most {MOST}")


def _methods(step: float = STEP) -> dict[str, Callable[..., Any]]:
    """By name, each with the parameters that can be an axis; ``step`` [s] where none is."""

    def massless_boundary(step: float = step, dynamic_modes: float | None = None) -> Any:
        modes = None if dynamic_modes is None else round(dynamic_modes)
        return later.MasslessBoundary(step=step, dynamic_modes=modes)

    def penalty(step: float = step, stiffness: float = 1e6, damping: float = 0.0) -> Any:
        return later.Smooth(later.Penalty(stiffness=stiffness, damping=damping), integrator=later.Verlet(step))

    return {
        STEPPED: lambda step=step, theta=0.5: later.MoreauJean(step=step, theta=theta),
        "event-driven": lambda step=math.inf, rtol=1e-8: later.EventDriven(rtol=rtol, max_step=step),
        "generalized-alpha": lambda step=step, rho_inf=0.8: later.GeneralizedAlpha(step=step, rho_inf=rho_inf),
        "massless-boundary": massless_boundary,
        "penalty": penalty,
        UNSTEPPED: lambda scene: later.acceleration_level(scene),
    }


def _axis(option: str, text: str, owners: Sequence[Callable[..., Any]]) -> tuple[str, list[Any]]:
    """Name and values; whole numbers where the default of the parameter is one."""
    name, equals, values = text.partition("=")
    count = values.rpartition(":")[2] if ":" in values else ""
    if count.strip().isdecimal() and (len(count) > LONGEST or int(count) > MOST):
        raise ModelError(f"{option}: {text[:80]!r}; expected at most {MOST} values")
    try:
        numbers = _spread(values) if ":" in values else [float(part) for part in values.split(",")]
    except ValueError:
        numbers = []
    if not (name and equals and numbers and np.isfinite(numbers).all()):
        raise ModelError(f"{option}: {text[:80]!r}; expected {RANGE} or NAME=VALUE,VALUE,... of finite numbers")
    for owner in owners:
        parameter = inspect.signature(owner).parameters.get(name)
        if parameter is not None and isinstance(parameter.default, int) and not isinstance(parameter.default, bool):
            return name, list(dict.fromkeys(round(number) for number in numbers))
    return name, numbers


def _spread(text: str) -> list[float]:
    """START:STOP:COUNT. Raises ValueError."""
    start, stop, count = text.split(":")
    low, high, number = float(start), float(stop), int(count)
    if number < 1:
        raise ValueError(count)
    if low > 0.0 and high > 0.0 and max(low, high) / min(low, high) >= WIDE:
        return [float(value) for value in np.geomspace(low, high, number)]
    return [float(value) for value in np.linspace(low, high, number)]


def _default_steps(scene: Any, duration: float | None) -> list[float]:
    """Steps around that of the scene's own stepper; of a scene without one, shares of the duration."""
    middle = getattr(getattr(scene, "stepper", None), "step", None)
    if middle is None:
        length = duration if duration is not None else getattr(scene, "duration", None)
        if length is None:
            raise ModelError("--duration: not given, and the scene does not say; expected a number of seconds > 0")
        middle = SHARE * length
    return [float(value) for value in middle * np.geomspace(FINEST, COARSEST, COUNT)]
