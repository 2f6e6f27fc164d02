"""What handles of bodies in the plane and in space have in common."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.basics.attributes import NamesNearest

__all__ = ["PlacedBody"]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedBody(NamesNearest):
    """A body in a scene, or its ground."""

    name: str
    body: int  # index in the scene, -1 for the ground
