"""Interfaces: the places of a body at which something acts on it, and what acts there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import numbers, sequence_of
from lcpflex.basics.options import keep_flag
from lcpflex.bodies.body import array_of
from lcpflex.errors import ModelError, in_range, shown

__all__ = ["Interface", "Interfaces", "NodeMean", "interfaces_of"]


@dataclass(frozen=True, slots=True)
class NodeMean:
    """The point that stands for nodes of a mesh in space, by their numbers; weights None: those of the mesh."""

    nodes: tuple[int, ...]
    weights: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True)
class Interface:
    """A place of a body at which a joint holds it, a spring or load acts on it, or something touches it.

    A reduction adds residual modes for it, the static response of the free body to what acts there, so that the static
    compliance there is that of the mesh.

    Parameters
    ----------
    place : the name of a point ("left"), a place (x, y) or (x, y, z) of the body frame [m], x alone on the axis of a
        beam or bar, or the number of a node of a mesh; of a solid, places are in the coordinates of its mesh
    along : direction (x, y) or (x, y, z) of the only force that acts there, body frame; None for forces in any
        direction
    moment : whether a moment acts there, as of a weld, a prismatic joint, a prescribed angle or a torque
    forces : whether forces act there; False for a torque alone
    contact : whether something touches the body there: ``MasslessBoundary`` makes as many residual modes static as such
        interfaces add, and keeps the others dynamic

    Raises
    ------
    ModelError
        For what is no place, and for a direction that is none.

    Source: MacNeal 1971; Rubin 1975.
    """

    place: str | float | tuple[float, ...] | NodeMean
    along: tuple[float, ...] | None = None
    moment: bool = True
    contact: bool = True
    forces: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.place, str | NodeMean):
            object.__setattr__(self, "place", _place(self.place))
        if self.along is not None:
            given = array_of("along", self.along, _axes(self.along))
            size = float(np.hypot.reduce(given))
            if not size > 0.0:
                raise ModelError(f"along: {shown(self.along)} was given, expected a direction (x, y), not both 0")
            object.__setattr__(self, "along", tuple(float(part) / size for part in given))
        for name in ("moment", "contact", "forces"):
            keep_flag(self, name)
        if not (self.forces or self.moment):
            raise ModelError("forces, moment: both are False, expected at least one: nothing would act there")


MOST = 10_000  # interfaces of a body

Interfaces: TypeAlias = (
    Interface | str | Sequence[Interface | str | float | tuple[float, ...]] | npt.NDArray[np.integer]
)


def interfaces_of(given: Any, make: Callable[[Any], Interface] = Interface) -> tuple[Interface, ...]:
    """The planar interfaces that were given, places made such by ``make``. Raises ModelError for anything else."""
    if isinstance(given, (str, Interface)):
        given = [given]
    given = sequence_of("interfaces", given, "a list of places, such as ['left', (0.5, 0.0)], or Interfaces", MOST)
    found = []
    for k, one in enumerate(given):
        try:
            found.append(_planar(one if isinstance(one, Interface) else make(one)))
        except ModelError as error:
            raise ModelError(f"interfaces[{k}]: {error}") from None
    return tuple(found)


def _planar(interface: Interface) -> Interface:
    """The interface, with places and directions of two numbers."""
    for name in ("place", "along"):
        value = getattr(interface, name)
        if isinstance(value, tuple):
            array_of(name, value, (2,))
    return interface


def _axes(value: Any) -> tuple[int]:
    """The shape of a place or direction: three numbers in space, else two."""
    return (3 if np.shape(numbers(value)) == (3,) else 2,)


def _place(value: Any) -> float | tuple[float, ...]:
    """x, the number of a node, (x, y) or (x, y, z)."""
    if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, (bool, np.timedelta64)):
        number = in_range("place", value, -math.inf, math.inf)
        return int(value) if isinstance(value, (int, np.integer)) else number
    return tuple(array_of("place", value, _axes(value)).tolist())
