"""The command line: ``lcpflex`` or ``python -m lcpflex``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex import __version__
from lcpflex.basics.whole_file import whole_file
from lcpflex.cli.chart import add_chart
from lcpflex.cli.cross_check import add_cross_check
from lcpflex.cli.parser import Parser
from lcpflex.cli.reading import called, check_picture, in_file, load_named
from lcpflex.cli.right_size import add_right_size
from lcpflex.cli.stability import add_stability
from lcpflex.errors import LcpflexError, ModelError, StepError, nearest, shown, writable_path

if TYPE_CHECKING:
    from lcpflex.gallery import Case
    from lcpflex.results.result import Result

__all__ = ["main"]

DEMO = "pendulum"  # the flexible pendulum that falls onto its stop, with friction
STEPPERS = ("moreau-jean", "event-driven", "generalized-alpha", "massless-boundary", "smooth")
STEP = 1e-4  # of a stepper that is asked for by name without a step [s]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns the exit code: 0 done, 1 the simulation failed or a solver claimed wrongly, 2 the request cannot be.
    """
    parser = _parser()
    request = parser.parse_args(arguments)
    if request.command is None:
        parser.print_help()
        return 0
    try:
        return int(request.command(request))
    except ModelError as error:
        print(f"lcpflex: {error}", file=sys.stderr)
        return 2
    except LcpflexError as error:
        print(f"lcpflex: {error}", file=sys.stderr)
        if isinstance(error, StepError) and error.result is not None:
            print(f"\nUp to there:\n\n{error.result.summary()}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("lcpflex: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="lcpflex", description="Frictional contact in flexible multibody systems.")
    parser.add_argument("--version", action="version", version=f"lcpflex {__version__}")
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")

    demo = commands.add_parser("demo", help="a flexible pendulum falls onto its stop: summary, picture and film")
    demo.add_argument("--folder", type=Path, default=Path(), help="where to write the files (default: here)")
    demo.set_defaults(command=_demo)

    gallery = commands.add_parser("gallery", help="list the reference scenes")
    gallery.set_defaults(command=_gallery)

    run = commands.add_parser("run", help="run one scene and print its summary")
    run.add_argument("scene", metavar="SCENE", help="a name from `lcpflex gallery`, or file.py:function")
    run.add_argument("--stepper", choices=STEPPERS, help="default: the one of the scene")
    run.add_argument("--step", type=float, metavar="SECONDS", help="step; largest step of event-driven and smooth")
    run.add_argument("--stiffness", type=float, metavar="N/M", help="of every contact, for --stepper smooth")
    run.add_argument("--duration", type=float, metavar="SECONDS", help="default: the one of the scene")
    run.add_argument("--save", type=Path, metavar="FILE", help="write the result to this npz file")
    run.add_argument("--plot", type=Path, metavar="FILE", help="write a chart to this png, pdf or svg file")
    run.set_defaults(command=_run)

    add_cross_check(commands)
    add_chart(commands, _scene)
    add_right_size(commands, _scene)
    add_stability(commands, _found)
    warmup = commands.add_parser("warmup", help="compile every kernel into the cache, once for this machine")
    warmup.set_defaults(command=_warmup)
    return parser


def _demo(request: argparse.Namespace) -> int:
    from lcpflex.runs.simulate import simulate

    folder = _checked_folder(request.folder)
    case = _case(DEMO)
    print(f"{case.title}\n", flush=True)
    result = simulate(case.build(), case.duration, case.stepper)
    print(result.summary(), "\n", flush=True)
    picture, chart, film = (folder / f"lcpflex-demo.{name}" for name in ("png", "chart.png", "gif"))
    _save_figure(result.draw(_telling_time(result)), picture)
    _save_figure(result.plot(), chart)
    print("drawing the film ...", file=sys.stderr, flush=True)
    result.animate(film, fps=20.0)
    print("written: " + "\n         ".join(str(path.resolve()) for path in (picture, chart, film)))
    return 0 if result.complete else 1


def _gallery(request: argparse.Namespace) -> int:
    from lcpflex.gallery import scenes

    cases = scenes()
    width = max(len(name) for name in cases)
    for name, case in cases.items():
        print(f"{name:<{width}}  {case.title}")
    print("\nrun one with: lcpflex run NAME")
    return 0


def _run(request: argparse.Namespace) -> int:
    from lcpflex.runs.simulate import simulate

    for option, unit in (("step", "seconds"), ("duration", "seconds"), ("stiffness", "N/m")):
        value = getattr(request, option)
        if value is not None and not 0.0 < value < float("inf"):
            raise ModelError(f"--{option}: {shown(value)}; expected a number of {unit} > 0")
    check_picture("--plot", request.plot)
    if request.save is not None:
        writable_path("--save", request.save)
    scene, duration, stepper = _scene(request.scene)
    duration = request.duration or duration
    if duration is None:
        raise ModelError(
            f"--duration: not given, and {shown(request.scene)} does not say; expected a number of seconds > 0"
        )
    stepper = _stepper(request.stepper, request.step, request.stiffness, stepper)
    result = simulate(scene, duration, stepper)
    print(result.summary())
    if request.save is not None:
        print(f"\nsaved: {result.save(request.save).resolve()}")
    if request.plot is not None:
        _save_figure(result.plot(), request.plot)
        print(f"\nchart: {request.plot.resolve()}")
    return 0 if result.complete else 1


def _warmup(request: argparse.Namespace) -> int:
    """Run short scenes that between them use every kernel."""
    from time import perf_counter

    from tqdm import tqdm

    from lcpflex.gallery import warmup_cases
    from lcpflex.jit.cache import lost
    from lcpflex.runs.simulate import simulate

    start = perf_counter()
    with tqdm(warmup_cases(), desc="compiling", unit="scene") as bar:
        for case in bar:
            bar.set_postfix_str(f"{case.name}, {type(case.stepper).__name__}")
            simulate(case.build(), case.duration, case.stepper, progress=False, project=True)
    if lost:
        print(f"{len(lost)} kernels were compiled and could not be kept; {perf_counter() - start:.1f} s")
        return 1
    print(f"every kernel is in the cache; {perf_counter() - start:.1f} s")
    return 0


def _case(name: str) -> Case:
    from lcpflex.gallery import scenes

    cases = scenes()
    if name not in cases:
        raise ModelError(
            f"SCENE: no scene {name[:80]!r}{nearest(name[:80], cases)}; expected file.py:function or one of "
            f"{', '.join(cases)}"
        )
    return cases[name]


def _found(text: str) -> Any:
    """The case of the gallery, or the function of a file, that SCENE names."""
    if not in_file(text):
        return _case(text)
    function = load_named("SCENE", text)
    if not callable(function):
        path, _, name = text.rpartition(":")
        raise ModelError(f"SCENE: {path[-80:]!r} has no function {name[:40]!r}; expected one that returns a Scene")
    return function


def _scene(text: str) -> tuple[Any, float | None, Any]:
    """Scene, its duration [s] and its stepper, the last two None where only a scene was given."""
    from lcpflex.gallery import Case

    found = _found(text)
    takes = "a function without arguments that returns a scene"
    made = found if isinstance(found, Case) else called("SCENE", text, found, takes)
    if isinstance(made, Case):
        return made.build(), made.duration, made.stepper
    return made, None, None


def _stepper(name: str | None, step: float | None, stiffness: float | None, own: Any) -> Any:
    """The stepper asked for, else the scene's own, with the numbers asked for."""
    from dataclasses import fields, replace

    import lcpflex as lf

    if stiffness is not None and name != "smooth":
        raise ModelError("--stiffness: given without --stepper smooth; rigid contact has none")
    kinds: dict[str, Any] = {
        "moreau-jean": lf.MoreauJean,
        "event-driven": lf.EventDriven,
        "generalized-alpha": lf.GeneralizedAlpha,
        "massless-boundary": lf.MasslessBoundary,
    }
    if name == "smooth":
        if stiffness is None:
            raise ModelError("--stiffness: not given; expected the stiffness of the contacts in N/m")
        integrator = lf.ExplicitRungeKutta() if step is None else lf.ExplicitRungeKutta(max_step=step)
        return lf.Smooth(lf.Penalty(stiffness), integrator=integrator)
    kind: Any = lf.MoreauJean if name is None and own is None else type(own) if name is None else kinds[name]
    option = "step" if "step" in {field.name for field in fields(kind)} else "max_step"
    if type(own) is kind:
        return own if step is None else replace(own, **{option: step})
    if kind in (lf.MoreauJean, lf.GeneralizedAlpha):
        return kind(step=step or STEP)
    return kind() if step is None else kind(**{option: step})


def _telling_time(result: Result) -> float:
    """The stored instant, of those with a contact force, at which the bodies are bent most."""
    touching = result.force[:, :, 0].sum(axis=1) > 0.0
    return float(result.times[np.where(touching, result.energies.elastic, -1.0).argmax()])


def _checked_folder(folder: Path) -> Path:
    """Refuse a folder that cannot be written to before time is spent."""
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise ModelError(f"folder: {str(folder)!r} cannot be written to; expected an existing, writable folder")
    return folder


def _save_figure(figure: Any, path: Path) -> None:
    try:
        with whole_file("path", path) as part:
            figure.savefig(part, dpi=150)
    except (OSError, ValueError) as error:
        raise ModelError(f"path: cannot write {str(path)!r}: {error}") from error


if __name__ == "__main__":
    sys.exit(main())
