"""Functions of time of a scene in compiled form, and the Python functions that are called for them while it runs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from lcpflex.basics.attributes import NamesNearest
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.dynamics.compiled_function import (
    DIFFERENCE_STEP,
    MOTION,
    PAIR,
    VALUE,
    VECTOR,
    CompiledFunction,
    called,
    compiled_source,
)
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Model, Signals, frozen
from lcpflex.model.planar import N_RIGID
from lcpflex.scene.functions_of_time import Harmonic, Motion, Signal, Table, takes_state

__all__ = [
    "COMPILED",
    "DIFFERENCE_STEP",
    "Callback",
    "Calls",
    "ForceCallback",
    "Materials",
    "MotionCallback",
    "SignalTable",
    "State",
    "known_material",
    "supplier",
]

PIECES, HARMONIC, EXTERNAL, COMPILED = range(4)
COMPONENTS = {1: VALUE, 2: PAIR, 3: VECTOR}
WHOLE = -1  # in place of a component: a motion with its derivatives


class OnBody(Protocol):
    """A placed body or a point of one."""

    @property
    def body(self) -> int: ...


class Materials:
    """The material of points of a scene in the bodies that they were given when the scene was compiled.

    A point of the scene that was compiled is of these bodies. One of another scene, whose bodies were reduced or
    exchanged since the point was made, has other modes, or none: it is made again.

    handles: of the bodies of the compiled scene, in their order
    """

    def __init__(self, handles: Sequence[Any]) -> None:
        self._handles = handles
        self._known: dict[int, tuple[PlacedPoint, Any]] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        """Without what is known by identity: copies of points are others."""
        return Materials, (self._handles,)

    def of(self, point: PlacedPoint) -> Any:
        """The material at a point of a body of the scene as it was declared: a MaterialPoint, or a SpatialPoint."""
        if point.scene is self._handles[point.body].scene:
            return point.material
        if id(point) not in self._known:
            self._known[id(point)] = (point, point.again(self._handles[point.body]).material)
        return self._known[id(point)][1]


def known_material(materials: Materials | None, point: PlacedPoint) -> Any:
    """The material at a point of a body in a compiled scene; None of ``materials``: as the point has it."""
    return point.material if materials is None else materials.of(point)


@dataclass(frozen=True, slots=True, eq=False)
class State(NamesNearest):
    """The state that a Python force is asked at; nothing in it may be changed.

    Places and velocities are in world axes [m], [m/s]; q and u are laid out as told in :mod:`lcpflex.model.arrays`.
    """

    time: float  # [s]
    q: FloatArray  # (ndof,)
    u: FloatArray  # (ndof,)
    dof: IntArray  # (nb + 1,) offsets of the bodies into q and u
    materials: Materials | None = field(default=None, repr=False)  # of points of a scene that was reduced; None: theirs

    def position(self, point: PlacedPoint) -> FloatArray:
        """r_P (2,) [m]."""
        place, _, d = self._local(point)
        return place if d is None else self.q[d : d + 2] + _turned(self.q[d + 2], place)

    def velocity(self, point: PlacedPoint) -> FloatArray:
        """rdot_P (2,) [m/s]."""
        place, rate, d = self._local(point)
        if d is None:
            return np.zeros(2)
        spin = self.u[d + 2] * np.array([-place[1], place[0]])
        return self.u[d : d + 2] + _turned(self.q[d + 2], rate + spin)

    def angle(self, of: OnBody) -> float:
        """Angle [rad] of a body, or of the material at a point of one; 0 for the ground."""
        return self._angular(of, self.q)

    def angular_velocity(self, of: OnBody) -> float:
        """Angular velocity [rad/s] of a body, or of the material at a point of one; 0 for the ground."""
        return self._angular(of, self.u)

    def _angular(self, of: OnBody, values: FloatArray) -> float:
        if of.body < 0:
            return 0.0
        d = int(self.dof[of.body])
        elastic = 0.0
        if isinstance(of, PlacedPoint):
            elastic = float(self._material(of).psi @ values[d + N_RIGID : self.dof[of.body + 1]])
        return float(values[d + 2] + elastic)

    def _local(self, point: PlacedPoint) -> tuple[FloatArray, FloatArray, int | None]:
        """x + Phi q and Phi qdot, body axes, and the offset of the body; None for the ground."""
        material = self._material(point) if point.body >= 0 else point.material
        place = np.array(material.place, dtype=float)
        if point.body < 0:
            return place, np.zeros(2), None
        d = int(self.dof[point.body])
        modal = slice(d + N_RIGID, int(self.dof[point.body + 1]))
        return place + self.q[modal] @ material.phi, self.u[modal] @ material.phi, d

    def _material(self, point: PlacedPoint) -> Any:
        return known_material(self.materials, point)


def _turned(angle: float, s: FloatArray) -> FloatArray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([cos * s[0] - sin * s[1], sin * s[0] + cos * s[1]])


@dataclass(frozen=True, slots=True)
class ForceCallback:
    """A Python force: f(t) or f(t, state), for an external slot or one for each component."""

    name: str
    function: Callable[..., Any]
    slots: tuple[int, ...]
    with_state: bool

    def fill(self, t: float, state: Any, external: FloatArray) -> None:
        """Write f into ``external`` (slots, 3). Raises ModelError if the function fails or returns something else."""
        arguments = (t, state) if self.with_state else (t,)
        values = called(self.name, COMPONENTS[len(self.slots)], self.function, *arguments)
        external[list(self.slots), 0] = values.reshape(len(self.slots))


@dataclass(frozen=True, slots=True)
class MotionCallback:
    """A Python motion f(t) with its derivatives, given by the function or taken by central differences."""

    name: str
    function: Callable[..., Any]
    slot: int

    def fill(self, t: float, state: Any, external: FloatArray) -> None:
        """Write (f, f', f'') into ``external`` (slots, 3). Raises ModelError if the function fails."""
        values = called(self.name, MOTION, self.function, t)
        if values.shape == (3,):
            external[self.slot] = values
            return
        h = DIFFERENCE_STEP
        around = (called(self.name, MOTION, self.function, t + k * h) for k in (-2, -1, 1, 2))
        far_before, before, after, far_after = (float(values.flat[0]) for values in around)
        now = float(values.flat[0])
        external[self.slot, 0] = now
        external[self.slot, 1] = (8.0 * (after - before) - (far_after - far_before)) / (12.0 * h)
        external[self.slot, 2] = (16.0 * (after + before) - (far_after + far_before) - 30.0 * now) / (12.0 * h * h)


Callback = ForceCallback | MotionCallback


@dataclass(slots=True)
class Calls:
    """How often Python functions of time of a scene were called in a run, and how long they took."""

    number: int = 0
    time: float = 0.0  # [s]


def supplier(callbacks: tuple[Callback, ...], calls: Calls, state_of: Callable[..., Any]) -> Callable[..., None]:
    """What stands in for the kernel ``supply``: it fills ``work.free.external`` from Python functions, and counts.

    state_of: what they are asked at, of t, q and u.
    """

    def supply(model: Model, t: float, q: FloatArray, u: FloatArray, work: Any) -> None:
        began = time.perf_counter()
        state = state_of(t, _read_only(q), _read_only(u))
        for callback in callbacks:
            callback.fill(t, state, work.free.external)
        calls.number += len(callbacks)
        calls.time += time.perf_counter() - began

    return supply


def _read_only(values: FloatArray) -> FloatArray:
    view = values.view()
    view.setflags(write=False)
    return view


class SignalTable:
    """Collects functions of time while a scene is compiled; hands out their indices."""

    def __init__(self) -> None:
        self._kind: list[int] = []
        self._first: list[int] = []
        self._last: list[int] = []
        self._breaks: list[float] = []
        self._coefficients: list[tuple[float, ...]] = []
        self._callbacks: list[Callback] = []
        self._functions: list[CompiledFunction] = []
        self.n_external = 0

    @property
    def functions(self) -> tuple[CompiledFunction, ...]:
        """The compiled functions so far, which must live as long as the arrays of :meth:`compile`."""
        return tuple(self._functions)

    def motion(self, name: str, value: Motion, rate: float | None = None) -> int:
        """Register a prescribed motion; a table becomes a cubic spline, with ``rate`` at the start where it fits."""
        if compiled_source(value) is not None:
            return self._compiled(name, value, MOTION, (WHOLE,))[0]
        if callable(value):
            self._callbacks.append(MotionCallback(name, value, self.n_external))
            return self._external()
        return self._add(value, smooth=True, rate=rate)

    def force(self, name: str, value: Signal) -> int:
        """Register a component of a force or a torque; a table becomes straight lines."""
        if compiled_source(value) is not None:
            return self._compiled(name, value, VALUE, (0,))[0]
        if callable(value):
            self._callbacks.append(ForceCallback(name, value, (self.n_external,), takes_state(value)))
            return self._external()
        return self._add(value, smooth=False)

    def force_components(self, name: str, value: Callable[..., Any], n: int) -> tuple[int, ...]:
        """Register a Python function that returns all n components of a force."""
        if compiled_source(value) is not None:
            return tuple(self._compiled(name, value, COMPONENTS[n], tuple(range(n))))
        slots = tuple(self.n_external + k for k in range(n))
        self._callbacks.append(ForceCallback(name, value, slots, takes_state(value)))
        return tuple(self._external() for _ in range(n))

    def compile(self) -> tuple[Signals, tuple[Callback, ...]]:
        """All functions so far as read-only arrays, and the Python ones among them."""
        signals = Signals(
            kind=frozen(self._kind, np.int64),
            first=frozen(self._first, np.int64),
            last=frozen(self._last, np.int64),
            breaks=frozen(self._breaks),
            coefficients=frozen(self._coefficients, columns=4),
            address=frozen([function.address for function in self._functions], np.int64),
        )
        return signals, tuple(self._callbacks)

    def _compiled(self, name: str, value: Any, form: int, components: tuple[int, ...]) -> list[int]:
        """The functions of the components of a compiled one."""
        self._functions.append(CompiledFunction(name, value, form))
        for component in components:
            self._put(COMPILED, len(self._functions) - 1, component)
        return [len(self._kind) - len(components) + k for k in range(len(components))]

    def _external(self) -> int:
        self._put(EXTERNAL, self.n_external, self.n_external + 1)
        self.n_external += 1
        return len(self._kind) - 1

    def _add(self, value: float | Harmonic | Table, smooth: bool, rate: float | None = None) -> int:
        first = len(self._breaks)
        if isinstance(value, Table):
            breaks, coefficients = value.pieces(smooth, rate)
            self._breaks.extend(float(b) for b in breaks)
            self._coefficients.extend(tuple(float(c) for c in row) for row in coefficients)
            self._put(PIECES, first, len(self._breaks))
            return len(self._kind) - 1
        if isinstance(value, float):
            value = Harmonic(0.0, 0.0, 0.0, value)
        assert isinstance(value, Harmonic)
        self._breaks.append(0.0)  # breaks and coefficients share their offsets
        self._coefficients.append((value.mean, value.amplitude, value.omega, value.phase))
        self._put(HARMONIC, first, first + 1)
        return len(self._kind) - 1

    def _put(self, kind: int, first: int, last: int) -> None:
        self._kind.append(kind)
        self._first.append(first)
        self._last.append(last)
