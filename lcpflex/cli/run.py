"""``lcpflex gallery`` and ``lcpflex run SCENE``: the reference scenes, and one of them or of the user's own, run."""

from __future__ import annotations

import argparse
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from lcpflex.cli import later
from lcpflex.cli.reading import check_files, duration_of, save_figure
from lcpflex.cli.scenes import scene_named
from lcpflex.errors import ModelError, shown
from lcpflex.runs.named_steppers import NAMES

__all__ = ["add_gallery", "add_run"]


def add_gallery(commands: Any) -> None:
    """Add the command to the subparsers."""
    gallery = commands.add_parser("gallery", help="list the reference scenes")
    gallery.set_defaults(command=_gallery)


def add_run(commands: Any) -> None:
    """Add the command to the subparsers."""
    run = commands.add_parser("run", help="run one scene and print its summary")
    run.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    run.add_argument("--stepper", choices=tuple(NAMES), help="default: the one of the scene, else one that is chosen")
    run.add_argument("--step", type=float, metavar="SECONDS", help="step; largest step of event-driven and smooth")
    run.add_argument("--stiffness", type=float, metavar="N/M", help="of every contact, for --stepper smooth")
    run.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")
    run.add_argument(
        "--budget", type=float, metavar="SECONDS", help="of computing, after which the run ends where it is"
    )
    run.add_argument(
        "--no-verify", action="store_true", help="do not measure the error by reruns, which take six times the work"
    )
    run.add_argument(
        "--tolerance", type=float, metavar="SHARE", help="error of places to be had, of the largest extent or travel"
    )
    run.add_argument("--save", type=Path, metavar="FILE", help="write the result to this npz file")
    run.add_argument("--plot", type=Path, metavar="FILE", help="write a chart to this png, pdf or svg file")
    run.set_defaults(command=_run)


def _gallery(request: argparse.Namespace) -> int:
    cases = later.scenes()
    width = max(len(name) for name in cases)
    for name, case in cases.items():
        print(f"{name:<{width}}  {case.title}")
    print("\nrun one with: lcpflex run NAME")
    return 0


def _run(request: argparse.Namespace) -> int:
    for option, unit in (("step", "seconds"), ("duration", "seconds"), ("budget", "seconds"), ("stiffness", "N/m")):
        value = getattr(request, option)
        if value is not None and not 0.0 < value < float("inf"):
            raise ModelError(f"--{option}: {shown(value)}; expected a number of {unit} > 0")
    check_files(request, "plot", "save")
    scene, duration, stepper = scene_named(request.scene)
    duration = duration_of(request, duration)
    result = _result(request, scene, duration, stepper)
    print(result.summary())
    if result.choice is not None:
        print(f"\n{result.choice}")
    if request.save is not None:
        print(f"\nsaved: {result.save(request.save).resolve()}")
    if request.plot is not None:
        save_figure(result.plot(), request.plot)
        print(f"\nchart: {request.plot.resolve()}")
    return 0 if result.complete else 1


def _result(request: argparse.Namespace, scene: Any, duration: float, own: Any) -> Any:
    """The run asked for."""
    if request.tolerance is None:
        stepper = _stepper(request.stepper, request.step, request.stiffness, own)
        return later.simulate(scene, duration, stepper, budget=request.budget, verify=not request.no_verify)
    for option in ("step", "stiffness"):
        if getattr(request, option) is not None:
            raise ModelError(f"--{option}: given with --tolerance, which chooses it; expected one of the two")
    return later.simulate(scene, duration, request.stepper, budget=request.budget, tolerance=request.tolerance)


def _stepper(name: str | None, step: float | None, stiffness: float | None, own: Any) -> Any:
    """The stepper asked for, else the scene's own, with the numbers asked for, else what ``simulate`` takes for it."""
    if stiffness is not None and name != "smooth":
        raise ModelError("--stiffness: given without --stepper smooth; rigid contact has none")
    if name == "smooth":
        if stiffness is None:
            raise ModelError("--stiffness: not given; expected the stiffness of the contacts in N/m")
        integrator = later.ExplicitRungeKutta() if step is None else later.ExplicitRungeKutta(max_step=step)
        return later.Smooth(later.Penalty(stiffness), integrator=integrator)
    if name is not None and type(own) is not later.kind_named(name):
        own = None
    if step is None:
        return name if own is None else own
    kind: Any = later.kind_named(name or "moreau-jean") if own is None else type(own)
    option = "step" if "step" in {field.name for field in fields(kind)} else "max_step"
    return kind(**{option: step}) if own is None else replace(own, **{option: step})
