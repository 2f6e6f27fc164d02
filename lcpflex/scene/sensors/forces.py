"""Sensors of forces: at joints, contacts, sections of beams, and in the material."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lcpflex.basics.arguments import numbers
from lcpflex.basics.options import keep_flag, keep_number
from lcpflex.bodies.body import array_of
from lcpflex.scene.handles import Placed
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.sensors.sensor import check_sensor, keep_body, keep_text

__all__ = ["Contact", "Reaction", "Section", "SpatialContact", "SpatialReaction", "SpatialSection", "Stress"]


@dataclass(frozen=True, slots=True)
class Reaction:
    """Force [N] and moment [N m] of a joint or drive, the largest of them, and the impulses of impacts.

    As :class:`lcpflex.results.result.JointReaction`: under time stepping a mean, and the largest, since the measurement
    before. joint: its name. axes: "world", "body" or the name of a body. every: time between measurements [s], see
    :meth:`lcpflex.Scene.sensor`. name: of the sensor. Raises ModelError for what are no names.
    """

    joint: str
    axes: str = "world"
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        keep_text(self, "joint", "the name of a joint")
        keep_text(self, "axes", "'world', 'body' or the name of a body")


@dataclass(frozen=True, slots=True)
class SpatialReaction:
    """A :class:`Reaction` of a compiled spatial scene."""

    joint: str
    axes: str
    every: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Contact:
    """Normal and tangential force [N], impulse since the start [N s], gap [m] and state of a contact.

    The state is that of :class:`lcpflex.Result`: 0 open, 1 sticking, 2 slipping, 3 creeping; the gap is NaN where it is
    far. In space friction is a vector, on the body of the first surface of the contact, world axes. contact: its name.
    every: time between measurements [s], see :meth:`lcpflex.Scene.sensor`. name: of the sensor. Raises ModelError for
    what is no name.
    """

    contact: str
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        keep_text(self, "contact", "the name of a contact")


@dataclass(frozen=True, slots=True)
class SpatialContact:
    """A :class:`Contact` of a compiled spatial scene."""

    contact: str
    every: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Section:
    """Section forces N, V [N] and M [N m] of a beam or bar at x [m], as :class:`lcpflex.results.result.SectionForces`.

    In a spatial scene N, V_y, V_z, T, M_y and M_z, and whether the motion determines them, as
    :class:`lcpflex.results.spatial.section_forces.SpatialSectionForces`; of a reduced solid as
    :class:`lcpflex.results.spatial.solid_sections.SolidSectionForces`, with a normal as force and moment x, y, z. They
    are computed in Python, in about a millisecond a measurement; a mesh is cut anew now and then, which takes seconds
    of one of 8000 elements. body: a Beam, Bar, SpatialBeam or body of a Solid, or
    its name. x: along its axis, of a solid normal . r in the plane of the section [m]. every: time between measurements
    [s], see :meth:`lcpflex.Scene.sensor`. name: of the sensor. normal: of a section of a solid, (1, 0, 0) if omitted.
    Raises ModelError for another body, a place off its axis, or a plane beside it.
    """

    body: PlacedBody | str
    x: float
    every: float | None = None
    name: str = ""
    normal: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        check_sensor(self)
        keep_body(self)
        keep_number(self, "x", -math.inf, math.inf, label="Section: x")
        if self.normal is not None:
            object.__setattr__(self, "normal", tuple(array_of("Section: normal", self.normal, (3,)).tolist()))


@dataclass(frozen=True, slots=True)
class SpatialSection:
    """A :class:`Section` of a compiled spatial scene."""

    body: str
    x: float
    every: float | None
    name: str
    normal: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True)
class Stress:
    """Stresses of a flexible body at one place [Pa], as :class:`lcpflex.results.result.StressHistory`.

    They are computed in Python, in some milliseconds a measurement, and what they need of a mesh now and then, which
    takes as long as its reduction. body: a flexible one, or its name. place: (x, y), or (x, y, z) in space, of a place
    where stresses are known, such as a node [m], undeformed, in its frame. static: with what its modes leave out.
    every: time between measurements [s], see :meth:`lcpflex.Scene.sensor`. name: of the sensor. Raises ModelError for a
    body without elements, or a place where no stress is known.
    """

    body: Placed | str
    place: tuple[float, ...]
    static: bool = True
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        keep_body(self)
        given = numbers(self.place)
        components = 3 if given is not None and given.shape == (3,) else 2
        place = array_of("Stress: place", self.place, (components,))
        object.__setattr__(self, "place", tuple(place.tolist()))
        keep_flag(self, "static", label="Stress: static")
