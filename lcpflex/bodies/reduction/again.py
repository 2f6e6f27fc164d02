"""Where a reduced body comes from: by how many modes of its mesh it was made, and what makes it with more of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import partial
from hashlib import sha256
from typing import Any, Generic, TypeVar

import numpy as np

from lcpflex.bodies.reduction.damping import continued
from lcpflex.bodies.reduction.eigenmodes import FULL_LIMIT
from lcpflex.bodies.reduction.fidelity_levels import MOST_MODES, STATIC, ModeLevels
from lcpflex.errors import ModelError, shown

__all__ = ["Reduction", "reduction_by", "sealed_reduction"]

Made = TypeVar("Made")  # a Body, or a SpatialBody


@dataclass(frozen=True, slots=True, eq=False)
class Reduction(Generic[Made]):
    """How a body was reduced.

    Attributes
    ----------
    modes : how many were chosen: free ones, or those of the mesh with its boundary held
    most : how many of these the mesh has
    make : makes the same body with so many of them: of the same mesh, with the same boundary, interfaces and damping
    seal : digest of the numbers of the body that was made so, and of the names on it; empty until there is one
    levels : gives the fidelity levels of the body, which has so many static shapes beside its modes; None where
        those who make the body give its levels themselves
    """

    modes: int
    most: int
    make: Callable[[int], Made]
    seal: bytes = field(default=b"", repr=False)
    levels: Callable[[int], ModeLevels] | None = field(default=None, repr=False)

    def sealed(self, body: Made) -> Reduction[Made]:
        """With the seal of the first body that has it; one in which fields are replaced keeps that of the first."""
        return self if self.seal else replace(self, seal=_digest(body))

    def tells(self, body: Made) -> bool:
        """Whether the body is as its reduction made it: no field of it was replaced."""
        return self.seal == _digest(body)

    def scaled(self, factor: float, coordinates: int, least: int = 0) -> int:
        """So many times as many modes, at most those of the mesh; more than static shapes alone: as many as it has.

        coordinates: how many modal coordinates the body has. least: fewer are not made of more.
        """
        if not self.modes:
            return min(self.most, coordinates if factor > 1.0 else 0)
        return min(self.most, max(round(factor * self.modes), min(least, self.modes)))


def sealed_reduction(reduction: Any, body: Any) -> Reduction[Any]:
    """``reduction`` with the seal of its first body. Raises ModelError for anything else."""
    if not isinstance(reduction, Reduction):
        raise ModelError(f"reduction: {shown(reduction)} was given, expected None, or that of a body that was reduced")
    return reduction.sealed(body)


def _digest(body: Any) -> bytes:
    """Of all numbers and arrays of a body, and of the names of its points and surfaces."""
    found = sha256()
    for part in fields(body):
        value = getattr(body, part.name)
        if isinstance(value, (int, float, np.ndarray)):
            found.update(part.name.encode() + np.ascontiguousarray(value).tobytes())
        elif isinstance(value, Mapping):
            found.update(repr((part.name, *sorted(value))).encode())
    return found.digest()


def reduction_by(
    reduce: Callable[..., Made], modes: int, most: int, damping: Any, whole: int | None = None, **options: Any
) -> Reduction[Made]:
    """Of a body that ``reduce(modes, damping=damping, **options)`` makes, of at most ``most`` modes.

    whole: modes of its full mesh; None: as many as the most.
    """
    levels = partial(_levels, reduce, most if whole is None else whole, damping, options)
    return Reduction(modes, most, partial(_again, reduce, damping, options), levels=levels)


def _again(reduce: Callable[..., Made], damping: Any, options: Mapping[str, Any], modes: int) -> Made:
    return reduce(modes, damping=continued(damping, modes), **options)


def _levels(
    reduce: Callable[..., Any], whole: int, damping: Any, options: Mapping[str, Any], residual: int
) -> ModeLevels:
    static = {name: options[name] for name in STATIC if name in options}
    rest = {name: value for name, value in options.items() if name not in static}
    ends = whole <= FULL_LIMIT
    return ModeLevels(whole, partial(_level, reduce, rest), static, damping, residual, MOST_MODES, ends)


def _level(reduce: Callable[..., Made], options: Mapping[str, Any], modes: int, damping: Any, **static: Any) -> Made:
    """With products of no more modes than there are, where so many were asked for."""
    second = options.get("second_order")
    fewer = {} if second is None else {"second_order": min(second, modes)}
    return reduce(modes, damping=damping, **{**options, **fewer}, **static)
