"""``lcpflex stability SCENE --x step=1e-5:1e-2:8 --y friction=0:1:6``."""

from __future__ import annotations

import argparse
import inspect
import math
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.errors import ModelError, writable_path
from lcpflex.written import whole_file

__all__ = ["add_stability"]

WIDE = 100.0  # ratio of the ends from which on values are spaced evenly in their logarithms
FINEST, COARSEST = 0.1, 100.0  # ends of the default axis, in steps of the scene's own stepper
COUNT = 7
SHARE = 1e-4  # of the duration, the step around which they lie where the stepper of the scene has none
CHARTS = (".png", ".pdf", ".svg")
RANGE = "NAME=START:STOP:COUNT"
STEPPED = "moreau-jean"
STEP = 1e-4  # of methods where neither an axis nor the scene's own stepper gives one [s]


def add_stability(commands: Any, find: Callable[[str], Any]) -> None:
    """Add the command to the subparsers ``commands``; ``find`` turns SCENE into a Case or a function that builds one.

    ``find`` raises ModelError for a scene that is not there.
    """
    command = commands.add_parser(
        "stability",
        help="map where in a plane of two parameters the methods work and how they fail elsewhere",
        description="Map where in a plane of two parameters the methods work and how they fail elsewhere. An axis is a "
        f"parameter of the scene or of the methods with its values, {RANGE} or NAME=VALUE,VALUE,... Ranges whose ends "
        f"are at least {WIDE:g} apart in ratio are spaced logarithmically. Parameters of the methods: step (all; the "
        "longest of event-driven), theta (moreau-jean), rtol (event-driven), rho_inf (generalized-alpha), "
        "dynamic_modes (massless-boundary), stiffness and damping (penalty, Verlet's steps). acceleration-level asks, "
        "without time stepping, whether the start has one motion.",
    )
    command.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    command.add_argument("--x", metavar=RANGE, help="default: the step, about that of the scene")
    command.add_argument("--y", metavar=RANGE, help="default: none, one row only")
    command.add_argument(
        "--method", action="append", choices=tuple(_methods()), help=f"may be repeated; default: {STEPPED}"
    )
    command.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")
    command.add_argument("--time-limit", type=float, metavar="SECONDS", help="computing time of a cell; default: none")
    command.add_argument("--plot", type=Path, metavar="FILE", help="write the map to this png, pdf or svg file")
    command.add_argument("--csv", type=Path, metavar="FILE", help="write every cell to this file")
    command.set_defaults(command=lambda request: _run(request, find))


def _run(request: argparse.Namespace, find: Callable[[str], Any]) -> int:
    from lcpflex.studies.stability import stability

    for name in ("plot", "csv"):
        if getattr(request, name) is not None:
            writable_path(f"--{name}", getattr(request, name))
    if request.plot is not None and request.plot.suffix.lower() not in CHARTS:
        raise ModelError(f"--plot: {str(request.plot)!r}; expected a name that ends in {', '.join(CHARTS)}")
    scene = find(request.scene)
    if not (callable(scene) or hasattr(scene, "build")):
        raise ModelError(f"SCENE: {request.scene!r} is {scene!r}; expected a Case or a function that builds a scene")
    known = _methods(getattr(getattr(scene, "stepper", None), "step", STEP))
    methods = {label: known[label] for label in request.method or [STEPPED]}
    asked = [("--x", request.x), ("--y", request.y)]
    axes: dict[str, list[Any]] = {}
    for option, text in asked:
        if text is not None:
            name, values = _axis(option, text, (getattr(scene, "build", scene), *methods.values()))
            if name in axes:
                raise ModelError(f"{option}: {name!r} was given twice; expected two parameters")
            axes[name] = values
    if request.x is None and "step" not in axes:
        axes = {"step": _default_steps(scene, request.duration), **axes}
    found = stability(scene, methods, axes, request.duration, time_limit=request.time_limit)
    print(f"{found}\n\n{found.table()}")
    if request.csv is not None:
        print(f"\ncells: {found.csv(request.csv).resolve()}")
    if request.plot is not None:
        with whole_file("plot", request.plot) as part:
            found.plot().savefig(part, dpi=150)
        print(f"\nmap: {request.plot.resolve()}")
    if not found.complete:
        print("lcpflex: interrupted", file=sys.stderr)
    return 0 if found.complete else 130


def _methods(step: float = STEP) -> dict[str, Callable[..., Any]]:
    """By name, each with the parameters that can be an axis; ``step`` [s] where none is."""
    return {
        STEPPED: partial(_moreau_jean, step=step),
        "event-driven": _event_driven,
        "generalized-alpha": partial(_generalized_alpha, step=step),
        "massless-boundary": partial(_massless_boundary, step=step),
        "penalty": partial(_penalty, step=step),
        "acceleration-level": _acceleration_level,
    }


def _moreau_jean(step: float, theta: float = 0.5) -> Any:
    from lcpflex.steppers.moreau_jean import MoreauJean

    return MoreauJean(step=step, theta=theta)


def _event_driven(step: float = math.inf, rtol: float = 1e-8) -> Any:
    from lcpflex.steppers.event_driven import EventDriven

    return EventDriven(rtol=rtol, max_step=step)


def _generalized_alpha(step: float, rho_inf: float = 0.8) -> Any:
    from lcpflex.steppers.generalized_alpha import GeneralizedAlpha

    return GeneralizedAlpha(step=step, rho_inf=rho_inf)


def _massless_boundary(step: float, dynamic_modes: float | None = None) -> Any:
    from lcpflex.steppers.massless_boundary import MasslessBoundary

    return MasslessBoundary(step=step, dynamic_modes=None if dynamic_modes is None else round(dynamic_modes))


def _penalty(step: float, stiffness: float = 1e6, damping: float = 0.0) -> Any:
    from lcpflex.contact.penalty import Penalty
    from lcpflex.steppers.smooth import Smooth, Verlet

    return Smooth(Penalty(stiffness=stiffness, damping=damping), integrator=Verlet(step))


def _acceleration_level(scene: Any) -> Any:
    from lcpflex.studies.acceleration_level import acceleration_level

    return acceleration_level(scene)


def _axis(option: str, text: str, owners: tuple[Callable[..., Any], ...]) -> tuple[str, list[Any]]:
    """Name and values; whole numbers where the default of the parameter is one."""
    name, equals, values = text.partition("=")
    try:
        numbers = _spread(values) if ":" in values else [float(part) for part in values.split(",")]
    except ValueError:
        numbers = []
    if not (name and equals and numbers and np.isfinite(numbers).all()):
        raise ModelError(f"{option}: {text!r}; expected {RANGE} or NAME=VALUE,VALUE,... of finite numbers")
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
