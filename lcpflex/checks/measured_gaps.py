"""Gaps of a run at any configuration, and how far bodies move between two of them: what a distance may change by.

A distance of two bodies changes by no more than their points move. The functions of a user's own system tell no points:
there W_N^T dq does it, each term by its size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lcpflex.contact.near import near, surfaces_of
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance, difference
from lcpflex.results.motion_units import Units

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.user_system import Functions

__all__ = ["GapsOfFunctions", "GapsOfScene", "MeasuredGaps"]

NEAR = 0.1  # of the size of the scene: gaps up to this are measured
ROUNDING = 1e-6  # of the size of the scene, or of the largest gap: changes of less are noise of detection
OF_PLACES = (
    1e-9  # of the largest coordinate of a user's own system, which is all that tells how large its gaps might be
)
CURVED = 2.0  # times W_N^T dq at the ends of a way, of gaps that are no linear functions


class MeasuredGaps(Protocol):
    """Smallest gaps by contact."""

    size: float  # [m] what gaps are large or small against
    noise: float  # [m] changes of less are none

    def at(self, q: FloatArray) -> dict[Hashable, float]:
        """Of each contact that is near [m]."""

    def beyond(self) -> float:
        """What the gap of a contact that is not near is at least [m]."""

    def change(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """The velocity that moves configuration a to b in 1 s."""

    def moved(self, a: FloatArray, velocity: FloatArray, share: float) -> FloatArray:
        """Configuration a moved by this velocity for so many seconds."""

    def bound(self, key: Hashable, a: FloatArray, b: FloatArray) -> float:
        """By how much the gap of a contact may change from a to b [m]."""

    def name(self, key: Hashable) -> str:
        """A contact, and what touches there, in words."""


class GapsOfScene:
    """Gaps of a compiled scene, with the names of its contacts."""

    def __init__(self, compiled: CompiledScene) -> None:
        self._compiled = compiled
        self._model: Any = pack(compiled.model)
        self._ndof = int(self._model.bodies.dof[-1])
        self._units = Units(compiled.model, self._ndof)
        self._bodies: dict[Hashable, tuple[int, int]] = {}
        self._way = self._moved = np.zeros(0)  # the last change that was asked for, and what bodies move by it
        self.size = compiled.size
        self.noise = ROUNDING * self.size

    def at(self, q: FloatArray) -> dict[Hashable, float]:
        """By declared contact, or by the two surfaces of a rule."""
        table, count = near(self._model, q, self.beyond())
        found: dict[Hashable, float] = {}
        for k in range(count):
            law = int(table.law[k])
            key: Hashable = law
            if law >= len(self._compiled.layout.contacts):
                a, b = surfaces_of(self._model.contacts, int(table.key[k]))
                key = min(a, b), max(a, b)
            found[key] = min(found.get(key, np.inf), float(table.gap[k]))
            self._bodies[key] = int(table.body[k, 0]), int(table.body[k, 1])
        return found

    def beyond(self) -> float:
        """How far detection looks."""
        return NEAR * self._compiled.size

    def change(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """The velocity that moves configuration a to b in 1 s."""
        out = np.zeros(self._ndof)
        difference(self._model, a, b, out)
        return out

    def moved(self, a: FloatArray, velocity: FloatArray, share: float) -> FloatArray:
        """Configuration a moved by this velocity for so many seconds."""
        out = a.copy()
        advance(self._model, a, velocity, share, out)
        return out

    def bound(self, key: Hashable, a: FloatArray, b: FloatArray) -> float:
        """How far the points of its two bodies move at most, in all."""
        way = self.change(a, b)
        if not np.array_equal(way, self._way):  # all contacts are asked for, one after the other
            self._way, self._moved = way, self._units.of(way)
        return float(sum(self._moved[body] for body in self._bodies[key] if body >= 0))

    def name(self, key: Hashable) -> str:
        """A contact and its bodies."""
        layout = self._compiled.layout
        name = layout.contacts[key] if isinstance(key, int) else layout.pair_name(*key)  # type: ignore[misc]
        ends = [repr(layout.bodies[body]) if body >= 0 else "the ground" for body in self._bodies[key]]
        return f"contact {name!r} between {' and '.join(ends)}"


class GapsOfFunctions:
    """Gaps of a user's own system, by the number of the contact.

    largest: gap [m], place: largest coordinate of its run so far; name: of a contact by its number.
    """

    def __init__(self, functions: Functions, largest: float, place: float, name: Callable[[int], str]) -> None:
        self._functions, self._name = functions, name
        self.size = largest
        self.noise = max(ROUNDING * largest, OF_PLACES * place)

    def at(self, q: FloatArray) -> dict[Hashable, float]:
        """All of them."""
        return dict(enumerate(self._functions.gaps(q.copy()).tolist())) if self._functions.m else {}

    def beyond(self) -> float:
        """There is none that is not told."""
        return np.inf

    def change(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """The velocity that moves configuration a to b in 1 s."""
        return self._functions.kinematics.difference(a, b)

    def moved(self, a: FloatArray, velocity: FloatArray, share: float) -> FloatArray:
        """Configuration a moved by this velocity for so many seconds."""
        return self._functions.kinematics.moved(a, velocity, share)

    def bound(self, key: Hashable, a: FloatArray, b: FloatArray) -> float:
        """What its normal says at both ends, each coordinate by itself."""
        rows = [np.abs(self._functions.normals(q)[:, key]) for q in (a, b)]  # type: ignore[index]
        return CURVED * float(np.maximum(*rows) @ np.abs(self.change(a, b)))

    def name(self, key: Hashable) -> str:
        """A contact by its name, or its number."""
        return f"contact {self._name(key)}"  # type: ignore[arg-type]
