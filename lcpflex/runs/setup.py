"""What a run is made of before it begins: a system, a stepper, a duration, and what is asked for beside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol

from lcpflex.dynamics.time_structure import for_system, with_instants
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import is_spatial
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.results.problem_log import ProblemLog, RecordProblems
from lcpflex.runs.sensing import Sensing, rates_of
from lcpflex.scene.scene import Scene
from lcpflex.scene.user_system import UserSystem
from lcpflex.steppers.user_functions import watch

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.runs.default_stepper import Choice
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.steppers.records import Records
    from lcpflex.steppers.system import System

__all__ = ["Run", "Setup", "Stepper", "compiled_for", "set_up"]


class Run(Protocol):
    """A stepper at work on a system."""

    records: Records

    @property
    def time(self) -> float: ...
    @property
    def steps(self) -> int: ...
    @property
    def finished(self) -> bool: ...
    @property
    def touching(self) -> list[int]: ...
    @property
    def motion(self) -> tuple[FloatArray, FloatArray]: ...
    @property
    def events(self) -> list[tuple[float, str, int, float]]: ...
    def advance(self, n_steps: int) -> str:
        """Make up to n_steps steps; empty, or why the run cannot go on."""


class Stepper(Protocol):
    """A time-integration scheme: a frozen value with its numbers."""

    def start(self, system: System, duration: float, interval: float) -> Run:
        """A run over ``duration`` [s] that stores an instant about every ``interval`` [s]."""


@dataclass(frozen=True, slots=True)
class Options:
    """What is asked of a run beside its scene and stepper; a checkpoint holds it as it is."""

    duration: float  # [s]
    interval: float  # between stored instants [s]
    project: bool
    energy_growth: EnergyGrowth
    notes: tuple[str, ...] = ()  # on the start, for the result
    began_wrong: tuple[str, ...] = ()  # clauses: why what it began from is not to be trusted
    every: float = 0.0  # between checkpoints [s]
    records_problems: bool = False
    choice: Choice | None = None  # of the stepper, where none was given


@dataclass(frozen=True, slots=True)
class Setup:
    """A run before it begins."""

    options: Options
    stepper: Stepper
    system: System
    source: CompiledScene | UserSystem
    names: tuple[str, ...]  # of the declared contacts
    problem_log: ProblemLog | None
    sensing: Sensing = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensing", Sensing(self))

    @property
    def compiled(self) -> CompiledScene | None:
        """What the scene was compiled to; None for a user's own system."""
        return None if isinstance(self.source, UserSystem) else self.source

    def contact_name(self, law: int) -> str:
        """What a result calls a contact."""
        return self.names[law] if law < len(self.names) else self.system.name_of(law)

    def run(self) -> Run:
        """The run at its start."""
        run = self.stepper.start(self.system, self.options.duration, self.options.interval)
        watch(run.records, [("", function) for function in self.system.functions])
        self.sensing.begin(run)
        return run


def compiled_for(
    scene: Scene | SpatialScene | UserSystem, stepper: Stepper, project: bool, push: bool | None = False
) -> CompiledScene | UserSystem:
    """``scene`` compiled for ``stepper``, what penetrates pushed out with ``push``; a user's own system as it is.

    ``push`` None: nobody looks at what penetrates, as the run begins elsewhere.
    """
    if isinstance(scene, UserSystem):
        return scene
    if not isinstance(scene, Scene):
        from lcpflex.scene.spatial.scene import SpatialScene  # which planar runs do without

        if not isinstance(scene, SpatialScene):
            raise ModelError(f"scene: {shown(scene)} was given, expected a Scene, a SpatialScene or a UserSystem")
    return scene.compiled(project, _indents(stepper), getattr(stepper, "gives_way", False), push)


def set_up(
    source: CompiledScene | UserSystem, stepper: Stepper, options: Options, record_problems: RecordProblems | None
) -> Setup:
    """Everything that a run needs, of a compiled scene or of a user's own system."""
    if isinstance(source, UserSystem):
        system, names = source.system(project=options.project, indents=_indents(stepper)), tuple(source.names)
    else:
        system, names = source.system(), source.layout.contacts
        known = (*source.callbacks, *source.functions)
        start = source.state(0.0, system.q, system.u)
        system = replace(system, model=with_instants(system.model, known, start, options.duration))
    if system.probe is not None:
        system = replace(system, model=for_system(system.model, system.probe, options.duration))
    system = replace(system, intervals=rates_of(source.sensors, options.duration, options.interval))
    _check_solver(stepper, system)
    problem_log = None
    if record_problems is not None:
        # asked when a problem comes: the pairs of a run that is restored are those of its file
        problem_log = ProblemLog(record_problems, lambda law: made.contact_name(law))
        system = replace(system, watch=problem_log.watch)
    made = Setup(options, stepper, system, source, names, problem_log)
    made.sensing.try_all()
    return made


def _indents(stepper: Stepper) -> Callable[[str], bool] | None:
    """Which contacts the stepper gives a force law."""
    indents: Callable[[str], bool] | None = getattr(stepper, "indents", None)
    return indents


def _check_solver(stepper: Stepper, system: System) -> None:
    """Refuse a solver that cannot solve what the scene may come to pose."""
    solver, friction = getattr(stepper, "solver", None), system.model.contacts.friction
    if other := getattr(solver, "model", ""):
        raise ModelError(
            f"solver: {shown(solver)} was given, expected one of Coulomb's law such as Auto(): "
            f"it solves another model ({other})"
        )
    if getattr(solver, "only_cones", False) and not is_spatial(system.model):
        raise ModelError(
            f"solver: {shown(solver)} was given, expected one of planar contact such as Auto(): it takes contact in "
            "space alone"
        )
    if getattr(solver, "only_frictionless", False) and friction.size and friction.max() > 0.0:
        raise ModelError(
            f"solver: {shown(solver)} was given for contacts with friction (up to "
            f"{friction.max():g}), expected Lemke(): "
            "a quadratic program solves frictionless contact only"
        )
