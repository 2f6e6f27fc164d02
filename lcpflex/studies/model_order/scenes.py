"""One scene at many fidelities: which bodies have fidelity levels, and the scene with each of them on one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from lcpflex.accuracy.outputs import (
    MOST,
    Output,
    Part,
    chosen_outputs,
    motion_of,
    standard_outputs,
    trajectory,
)
from lcpflex.basics.arguments import raised, sequence_of
from lcpflex.bodies.body import FidelityLevel
from lcpflex.errors import LcpflexError, ModelError, shown
from lcpflex.model.layout import PLANE, SPACE
from lcpflex.results.watched_places import two_places
from lcpflex.scene.register import Register
from lcpflex.scene.substitution import settled
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.results.result import Result
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["FULL", "Fidelities", "State", "as_rich", "comparable", "known_outputs", "of_scene", "told", "with_level"]

State: TypeAlias = tuple[int, ...]  # level of each body that has several
MOTION = "motion"
FULL = "full mesh"


def with_level(state: State, body: int, level: int) -> State:
    """The state with another level of one body."""
    return (*state[:body], level, *state[body + 1 :])


def as_rich(a: State, b: State) -> bool:
    """Whether ``a`` is at least as rich as ``b`` in every body."""
    return all(x >= y for x, y in zip(a, b, strict=True))


def told(labels: dict[str, str]) -> str:
    """Names of levels by body, as a text."""
    return ", ".join(f"{name}: {level}" for name, level in labels.items())


@dataclass(frozen=True, slots=True, eq=False)
class Fidelities:
    """A scene whose bodies ``names`` can be had on the levels ``levels``; the others stay as they are."""

    scene: Scene | SpatialScene
    names: tuple[str, ...]
    levels: tuple[tuple[FidelityLevel, ...], ...]
    rigid: int  # coordinates of all bodies without their modes, modes of bodies without levels included
    _made: dict[tuple[int, int], Any] = field(default_factory=dict, repr=False)

    @property
    def bottom(self) -> State:
        """Every body on its first level."""
        return (0,) * len(self.names)

    @property
    def top(self) -> State:
        """Every body on its last level: as its full mesh, where its levels reach that."""
        return tuple(len(levels) - 1 for levels in self.levels)

    def whole(self, body: int) -> bool:
        """Whether the levels of a body end with its full mesh; those of a very large one do not."""
        return self.levels[body][-1].name == FULL

    def full_modes(self) -> tuple[float, ...]:
        """Number of modes of the full mesh of each body, infinite where its levels do not reach it."""
        return tuple(r[-1].modes if self.whole(b) else math.inf for b, r in enumerate(self.levels))

    def modes(self, state: State) -> tuple[int, ...]:
        """Number of modes of each body."""
        return tuple(levels[k].modes for levels, k in zip(self.levels, state, strict=True))

    def coordinates(self, state: State) -> int:
        """Number of coordinates of the scene."""
        return self.rigid + sum(self.modes(state))

    def labels(self, state: State) -> dict[str, str]:
        """Name of the level of each body."""
        return {name: levels[k].name for name, levels, k in zip(self.names, self.levels, state, strict=True)}

    def at(self, state: State) -> Scene | SpatialScene:
        """The scene with its bodies on these levels; a body is made once.

        What a poor body cannot follow of an initial deformation may part it from its joints: then it is moved back.
        """
        bodies: dict[str, Any] = {}
        for b, (name, level) in enumerate(zip(self.names, state, strict=True)):
            if (b, level) not in self._made:
                self._made[b, level] = self.levels[b][level].make()
            bodies[name] = self._made[b, level]
        return settled(self.scene.with_bodies(bodies))


def of_scene(scene: Any) -> Fidelities:
    """The fidelities of the bodies of a scene, of the function that makes it, or of a Case. Raises ModelError."""
    build = getattr(scene, "build", scene)
    try:
        made = build() if callable(build) else build
    except LcpflexError as error:
        raise ModelError(f"scene: {error}") from error
    except Exception as error:
        raise raised("scene", error, "a scene, a function that makes one, or a Case") from error
    if hasattr(made, "build") and hasattr(made, "duration"):  # a function that returns a case
        made = made.build()
    if not isinstance(made, Register):
        what = "a UserSystem, which has no bodies," if isinstance(made, UserSystem) else shown(scene)
        raise ModelError(
            f"scene: {what} was given, expected a Scene, a SpatialScene, a function that makes one, or a Case"
        )
    reduced: Any = made.reduced()  # type: ignore[attr-defined]  # both kinds of scenes have it
    placed = reduced.parts().placed
    found = {
        one.name: one.source.fidelity_levels()
        for one in placed
        if one.source is not None and one.source.fidelity_levels
    }
    found = {name: levels for name, levels in found.items() if len(levels) > 1}
    if not found:
        raise ModelError(
            "scene: none of its bodies has fidelity levels, expected at least one that was reduced from a mesh, "
            "such as Beam(...).reduce(), or in space SpatialBeam(...) or Solid(...)"
        )
    size = SPACE if reduced.spatial else PLANE
    fixed = sum(one.source.modes for one in placed if one.source is not None and one.name not in found)
    return Fidelities(reduced, tuple(found), tuple(found.values()), size.rigid * len(placed) + fixed)


def known_outputs() -> tuple[str, ...]:
    """Names that right_size knows; the first and the impulses are used by default."""
    return (MOTION, *(output.name for output in standard_outputs()))


def comparable(fidelities: Fidelities, outputs: Any) -> tuple[Output, ...]:
    """The outputs, those of motion at the same undeformed places of every level. Raises ModelError."""
    places = two_places(fidelities.scene.compiled(project=True), fidelities.names)
    if outputs is None:
        outputs = (MOTION, "impulses")
    if isinstance(outputs, (str, Output)) or callable(outputs):
        outputs = (outputs,)
    if isinstance(outputs, Sequence):
        outputs = sequence_of("outputs", outputs, "a sequence of outputs", MOST)
        outputs = [_position(places) if isinstance(one, str) and one == MOTION else one for one in outputs]
        unknown = [one for one in outputs if isinstance(one, str) and one not in known_outputs()]
        if unknown:
            raise ModelError(
                f"outputs: no output {shown(unknown[0])}; expected one of {', '.join(known_outputs())}, or a function"
            )
    return tuple(
        Output(one.name, _at(places), one.scale) if one.function is trajectory else one
        for one in chosen_outputs(outputs)
    )


def _position(places: Sequence[tuple[str, tuple[float, ...]]]) -> Output:
    return Output(MOTION, lambda result: motion_of(result, places)[:1])


def _at(places: Sequence[tuple[str, tuple[float, ...]]]) -> Callable[[Result], list[Part]]:
    return lambda result: motion_of(result, places)
