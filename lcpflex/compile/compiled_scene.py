"""A compiled scene: its arrays, their names, and what a stepper takes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.lazy import attach
from lcpflex.compile.state_arrays import mechanics_at
from lcpflex.compile.state_mechanics import StateMechanics
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.compiled_function import CompiledFunction
from lcpflex.dynamics.time_functions import COMPILED, Callback, Calls, Materials, State, supplier
from lcpflex.errors import ModelError
from lcpflex.force_laws.law import Law
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Axis, refrozen
from lcpflex.model.layout import is_spatial
from lcpflex.model.recovery import Shapes
from lcpflex.scene.sensors.sensor import Sensor
from lcpflex.steppers.system import System

__all__ = ["CompiledScene", "Layout"]

__getattr__, __dir__ = attach(__name__, renamed={"Compiled": "CompiledScene"})

MARGIN = 0.2  # gaps are measured up to this part of the size of the scene


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """What the indices of a compiled scene are called, and what is drawn of it."""

    bodies: tuple[str, ...]
    contacts: tuple[str, ...]
    joints: tuple[str, ...]
    outlines: tuple[tuple[int, IntArray, bool], ...]  # (body, material points, closed)
    circles: tuple[tuple[int, float], ...]  # (material point, radius [m])
    points: dict[tuple[str, str], int]  # (body, point) -> material point
    resolutions: tuple[tuple[float, float] | None, ...] = ()  # of meshed bodies: wave speed [m/s], longest element [m]
    residual: tuple[tuple[int, int], ...] = ()  # of each body: how many of its last modes are residual, and of contacts
    axes: tuple[Axis | None, ...] = ()  # of beams
    rule_surfaces: tuple[str, ...] = ()  # labels of the first surfaces, between which a rule holds that is not listed
    shapes: tuple[Any, ...] = ()  # of the bodies of a spatial scene, to be drawn; None: of no known shape

    def pair_name(self, a: int, b: int) -> str:
        """Name of the contact of two surfaces by the rule."""
        return f"{self.rule_surfaces[min(a, b)]}/{self.rule_surfaces[max(a, b)]}"


@dataclass(frozen=True, slots=True, eq=False)
class CompiledScene:
    """A scene as flat read-only arrays with its initial state; it does not change with the scene any more."""

    model: Any  # a Model, or a SpatialModel
    layout: Layout
    q: FloatArray  # (nq,) initial configuration
    u: FloatArray  # (nu,) initial velocity
    size: float  # extent of the largest body [m]: what gaps are large or small against
    n_external: int  # slots that callbacks fill
    callbacks: tuple[Callback, ...] = field(default=(), repr=False)
    laws: tuple[Law | None, ...] = ()  # of the declared contacts; None: by complementarity
    functions: tuple[CompiledFunction, ...] = field(default=(), repr=False)  # called by address while they live
    materials: Materials | None = field(default=None, repr=False)  # of points of a scene that was reduced for this
    warnings: tuple[str, ...] = ()  # pairs that a rule leaves out, bodies that give way too little where they are held
    notes: tuple[str, ...] = ()  # which nodes of surfaces have residual modes, which bodies have no surface
    recovery: tuple[Shapes | None, ...] = field(default=(), repr=False)  # of each body, what stresses come from
    spread: Mapping[int, tuple[IntArray, FloatArray]] = field(default_factory=dict, repr=False)  # nodes and weights
    # that a material point is the mean of, of meshes whose stresses can be recovered
    laws_are_lost: bool = False  # whether contacts have force laws that are not here any more, as in a file
    sensors: tuple[Sensor, ...] = field(default=(), repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """By its fields; see ``_compiled_again``."""
        return _compiled_again, tuple(getattr(self, part.name) for part in fields(self))

    def state(self, time: float, q: FloatArray, u: FloatArray) -> Any:
        """What Python functions of time and state are called with: a State, or a SpatialState."""
        if self.spatial:
            from lcpflex.dynamics.spatial.state import SpatialState

            return SpatialState(time, q, u, self.model.bodies, self.materials)
        return State(time, q, u, self.model.bodies.dof, self.materials)

    def at(
        self,
        q: npt.ArrayLike | None = None,
        u: npt.ArrayLike | None = None,
        t: float = 0.0,
        *,
        margin: float | None = None,
        gap_tolerance: float | None = None,
        velocity_threshold: float | None = None,
    ) -> StateMechanics:
        """Equations of motion, contacts, joints and index sets at one state, as arrays with names.

        Nothing is projected: of a state that violates its joints, or in which bodies overlap, the arrays tell by how
        much.

        Parameters
        ----------
        q, u
            Configuration (nq,) and velocity (n,); those of the start if omitted.
        t
            Time [s], for loads and drives.
        margin
            Contacts with gaps up to this are told of [m]; 0.2 of the size of the largest body if omitted.
        gap_tolerance
            Gaps up to this are closed [m]; 1e-9 of that size, or rounding of places, if omitted.
        velocity_threshold
            Closed contacts neither approach nor separate up to this [m/s], and stick up to a thousandth of it;
            if omitted as in ``EventDriven``, 1e-6 of a speed that is usual in the scene.

        Raises
        ------
        ModelError
            For numbers out of their range, arrays of another shape, a state so far out that a number is not finite,
            a body bent or a contact with a force law compressed beyond its range, a user's function that fails, and
            a scene of a file, which keeps no functions and laws.
        """
        return mechanics_at(self, q, u, t, margin, gap_tolerance, velocity_threshold)

    @property
    def spatial(self) -> bool:
        """Whether bodies move in space."""
        return is_spatial(self.model)

    @property
    def functions_are_lost(self) -> bool:
        """Whether functions of time of a user's are not here any more, as in a scene of a file."""
        slots = sum(len(getattr(callback, "slots", (0,))) for callback in self.callbacks)
        compiled = bool((self.model.signals.kind == COMPILED).any())
        return slots < self.n_external or (compiled and not self.functions)

    def system(self) -> System:
        """What a stepper takes. With Python functions among the loads or motions, its outer loop runs in Python.

        Raises ModelError for a scene of a file that has not kept all of it.
        """
        if self.functions_are_lost or self.laws_are_lost:
            what = "Python functions of time" if self.functions_are_lost else "force laws"
            raise ModelError(
                f"scene: it is that of a result from a file, which keeps no {what}; expected one that was compiled in "
                "this process"
            )
        calls = Calls()
        return System(
            model=self.model,
            q=self.q.copy(),
            u=self.u.copy(),
            n_external=self.n_external,
            hooks={mechanics.supply: supplier(self.callbacks, calls, self.state)} if self.callbacks else {},
            dense=False,
            margin=MARGIN * self.size,
            names=self.layout.contacts,
            bodies=self.layout.bodies,
            laws=self.laws,
            functions=self.functions,
            residual_modes=tuple(modes if contacts else 0 for modes, contacts in self.layout.residual),
            calls=calls if self.callbacks else None,
            size=self.size,
            rule_surfaces=self.layout.rule_surfaces,
        )


def _compiled_again(*values: Any) -> CompiledScene:
    """A copy, or what is unpickled: its arrays are read-only again, and functions are where they are now."""
    again = CompiledScene(*values)
    signals = again.model.signals
    if again.functions:
        signals = signals._replace(address=np.array([function.address for function in again.functions]))
    refrozen((again.q, again.u))
    return replace(again, model=refrozen(again.model._replace(signals=signals)))
