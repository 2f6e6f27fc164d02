"""Sensors of motion and energy."""

from __future__ import annotations

from dataclasses import dataclass

from lcpflex.basics.arguments import sequence_of
from lcpflex.bodies.placed_point import PlacedPoint, check_point
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.sensors.sensor import check_sensor, keep_body

__all__ = ["Body", "Coordinates", "Energy", "MaterialPoint", "Point", "SpatialFrame", "StateNumbers"]


@dataclass(frozen=True, slots=True)
class Point:
    """Place r_P = R + A (x + Phi q) [m] and velocity rdot_P [m/s] of a material point, world axes.

    P: ``body.point(name)`` or ``body.at(x, y)``, in space ``body.at(x, y, z)``. every: time between measurements [s],
    see :meth:`lcpflex.Scene.sensor`. name: of the sensor. Raises ModelError for a point on the ground, or none.
    """

    P: PlacedPoint
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        check_point("Point", "P", self.P)
        if self.P.body < 0:
            raise ModelError(f"Point: P: {self.P.label} on the ground was given, expected a point of a body")


@dataclass(frozen=True, slots=True, eq=False)
class MaterialPoint:
    """A :class:`Point` of a compiled scene: the number of the body, x and Phi of the material."""

    body: int
    place: FloatArray
    phi: FloatArray  # (n, 2), in space (n, 3)
    every: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Body:
    """Place (x, y) [m] and angle [rad] of the frame of a body, whole turns counted, and their rates.

    In space place (x, y, z), unit quaternion (p0, p1, p2, p3), scalar first and without changes of sign, velocity [m/s]
    and angular velocity [rad/s], both in world axes.

    body: of the scene, or its name. every: time between measurements [s], see :meth:`lcpflex.Scene.sensor`. name: of
    the sensor. Raises ModelError for what is no body.
    """

    body: PlacedBody | str
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        keep_body(self)


@dataclass(frozen=True, slots=True)
class SpatialFrame:
    """A :class:`Body` of a compiled spatial scene: its number."""

    body: int
    every: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Coordinates:
    """Coordinates and their rates, by their names as in :meth:`lcpflex.Result.coordinate_names`: "q 1", "bar.mode 3".

    In space q and u differ: names of :meth:`lcpflex.Result.coordinate_names` and of
    :meth:`lcpflex.Result.velocity_names`, such as "box.p0" and "box.omega_x", one column each; of a mode its coordinate
    and its rate.

    names: some of these. every: time between measurements [s], see :meth:`lcpflex.Scene.sensor`. name: of the sensor.
    Raises ModelError for what is no sequence of names.
    """

    names: tuple[str, ...]
    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
        given = sequence_of("Coordinates: names", self.names, "a sequence of names such as ('q 1',)")
        if not given or not all(isinstance(one, str) and one for one in given) or len(set(given)) != len(given):
            raise ModelError(
                f"Coordinates: names: {shown(self.names)} was given, expected different names, at least one"
            )
        object.__setattr__(self, "names", tuple(map(str, given)))


@dataclass(frozen=True, slots=True, eq=False)
class StateNumbers:
    """:class:`Coordinates` of a compiled spatial scene: labels, units, and which numbers of (q, u) they are."""

    columns: tuple[str, ...]
    units: tuple[str, ...]
    chosen: tuple[int, ...]  # those of u come behind those of q
    every: float | None
    name: str


@dataclass(frozen=True, slots=True)
class Energy:
    """Kinetic, elastic and potential energy, and what was lost and supplied since the start [J], as ``Energies``.

    every: time between measurements [s], see :meth:`lcpflex.Scene.sensor`. name: of the sensor.
    """

    every: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_sensor(self)
