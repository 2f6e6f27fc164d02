"""What has been declared of a scene: contacts, rules, and all parts together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from lcpflex.bodies.body import Body
from lcpflex.force_laws.law import Law
from lcpflex.scene.handles import Placed
from lcpflex.scene.joints.joint import Joint
from lcpflex.scene.loads.load import Load
from lcpflex.scene.placed_surface import PlacedSurface
from lcpflex.scene.sensors.sensor import Sensor

__all__ = ["ContactRule", "DeclaredContact", "Parts"]


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredContact:
    """Two surfaces and the law between them."""

    pair: tuple[PlacedSurface, PlacedSurface]
    friction: float
    restitution: float
    tangential_restitution: float
    node_side: PlacedSurface | None = None  # the one of the pair whose points alone touch the other; None: by the kinds
    law: Law | None = None  # continuous contact force; None: complementarity
    points: str = ""  # what the face that is the node side touches with, "areas" or "nodes"; "" without a face


@dataclass(frozen=True, slots=True, eq=False)
class ContactRule:
    """One law between all surfaces, but for excluded pairs."""

    friction: float
    restitution: float
    tangential_restitution: float
    exclude: tuple[tuple[Any, Any], ...]  # of bodies and surfaces
    law: Law | None = None


class Parts(NamedTuple):
    """All that has been declared of a scene."""

    placed: tuple[Placed, ...]
    joints: dict[str, Joint]
    loads: tuple[Load, ...]
    contacts: dict[str, DeclaredContact]
    rules: tuple[ContactRule, ...]
    surfaces: tuple[PlacedSurface, ...]  # made by hand on bodies and the ground
    sensors: dict[str, Sensor]

    @property
    def bodies(self) -> tuple[Body, ...]:
        """What was placed, in the same order."""
        return tuple(one.source for one in self.placed if one.source is not None)

    def angle(self, body: int) -> float:
        """Angle of a body at the start [rad]; 0 for the ground."""
        return 0.0 if body < 0 else float(self.placed[body].start[0][2])
