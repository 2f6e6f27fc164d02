"""How sensors of each kind are measured, on some instants of a run at a time.

What is measured at an instant must not depend on how many are looked at together: sums over modes are therefore taken
one mode after the other, and what is computed by matrices instant by instant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import absent, called, numbers
from lcpflex.errors import ModelError, shown
from lcpflex.kinematics.places import trajectory, velocity
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.planar import N_RIGID
from lcpflex.model.spatial import N_PLACE
from lcpflex.results.energy_balance import Energies
from lcpflex.results.instant import Instant
from lcpflex.results.joint_reaction import joint_reaction
from lcpflex.results.orientation import body_angle
from lcpflex.results.section_forces import body_of_result
from lcpflex.results.sections import sections
from lcpflex.results.stress_history import stress_history
from lcpflex.scene.sensors.forces import (
    Contact,
    Reaction,
    Section,
    SpatialContact,
    SpatialReaction,
    SpatialSection,
    Stress,
)
from lcpflex.scene.sensors.motions import Body, Coordinates, Energy, MaterialPoint, SpatialFrame, StateNumbers
from lcpflex.scene.sensors.user_function import Function

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["Columns", "Window", "Unmeasured", "columns_of", "known", "measured"]

AXES = ("x", "y", "z")
STORED = tuple(name for name in Energies.__dataclass_fields__ if name != "remainder")
AT_NODE = 1e-9  # of the extent of a body: a place so near is that one


class Columns(NamedTuple):
    """Names of what a sensor measures, and their units."""

    names: tuple[str, ...]
    units: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Window:
    """Some instants of a run in order, the first ``skipped`` of which have been measured before."""

    result: Result
    skipped: int
    step: float  # mean one of the run so far [s]

    @property
    def rows(self) -> range:
        """Instants to be measured."""
        return range(self.skipped, len(self.result.times))


def _motion(what: str = "", components: int = 2) -> tuple[tuple[str, ...], tuple[str, ...]]:
    return tuple(f"{what}{axis}" for axis in AXES[:components]), ("m/s" if what else "m",) * components


def _point_columns(sensor: MaterialPoint) -> Columns:
    (places, m), (rates, m_s) = (_motion(what, len(sensor.place)) for what in ("", "velocity "))
    return Columns((*places, *rates), (*m, *m_s))


def _point(sensor: MaterialPoint, window: Window) -> Any:
    result = window.result
    assert result.compiled is not None
    at = result.compiled.model, result.q[window.skipped :], sensor.body, sensor.place, sensor.phi
    return np.column_stack([trajectory(*at), velocity(at[0], at[1], result.u[window.skipped :], *at[2:])])


def _body_columns(sensor: Body) -> Columns:
    (places, m), (rates, m_s) = _motion(), _motion("velocity ")
    return Columns((*places, "angle", *rates, "angular velocity"), (*m, "rad", *m_s, "rad/s"))


def _body(sensor: Body, window: Window) -> Any:
    result = window.result
    body_angle(result, str(sensor.body))
    compiled, b = body_of_result(result, sensor.body, "Body")
    frame = slice(int(compiled.model.bodies.dof[b]), int(compiled.model.bodies.dof[b]) + N_RIGID)
    return np.column_stack([result.q[window.skipped :, frame], result.u[window.skipped :, frame]])


def _frame_columns(sensor: SpatialFrame) -> Columns:
    (places, m), (rates, m_s) = (_motion(what, 3) for what in ("", "velocity "))
    turning = tuple(f"angular velocity {axis}" for axis in AXES)
    return Columns((*places, "p0", "p1", "p2", "p3", *rates, *turning), (*m, *["1"] * 4, *m_s, *["rad/s"] * 3))


def _frame(sensor: SpatialFrame, window: Window) -> Any:
    assert window.result.compiled is not None
    bodies = window.result.compiled.model.bodies
    k, d = int(bodies.place[sensor.body]), int(bodies.dof[sensor.body])
    q, u = window.result.q[window.skipped :, k : k + N_PLACE], window.result.u[window.skipped :, d : d + 6]
    return np.column_stack([q, u[:, :3], rotated(q[:, 3:], u[:, 3:])])


def _numbers_columns(sensor: StateNumbers) -> Columns:
    return Columns(sensor.columns, sensor.units)


def _numbers(sensor: StateNumbers, window: Window) -> Any:
    whole = np.column_stack([part[window.skipped :] for part in (window.result.q, window.result.u)])
    return whole[:, list(sensor.chosen)]


def _coordinates_columns(sensor: Coordinates) -> Columns:
    rates = tuple(f"{name}'" for name in sensor.names)
    units = tuple(_unit_of(name) for name in sensor.names)
    return Columns((*sensor.names, *rates), (*units, *(f"{unit}/s" if unit else "" for unit in units)))


def _unit_of(coordinate: str) -> str:
    """Unit of a coordinate of a scene; that of a user's own is not known."""
    what = coordinate.rpartition(".")[2] if "." in coordinate else ""
    return "kg^1/2 m" if what.startswith("mode ") else {"x": "m", "y": "m", "angle": "rad"}.get(what, "")


def _coordinates(sensor: Coordinates, window: Window) -> Any:
    result, names = window.result, window.result.coordinate_names()
    for name in sensor.names:
        if name not in names:
            raise ModelError(f"names: no coordinate {absent(name, names)}")
    chosen = [names.index(name) for name in sensor.names]
    return np.column_stack([part[window.skipped :, chosen] for part in (result.q, result.u)])


def _energy_columns(sensor: Energy) -> Columns:
    return Columns(STORED, ("J",) * len(STORED))


def _energy(sensor: Energy, window: Window) -> Any:
    return np.column_stack([getattr(window.result.energies, name)[window.skipped :] for name in STORED])


def _spatial_reaction_columns(sensor: SpatialReaction) -> Columns:
    force, moment, push, twist = (
        tuple(f"{what} {axis}" for axis in AXES) for what in ("force", "moment", "impulse", "angular impulse")
    )
    names = (*force, *moment, "largest force", "largest moment", *push, *twist, "drive", "unique")
    units = (*["N"] * 3, *["N m"] * 3, "N", "N m", *["N s"] * 3, *["N m s"] * 3, "N or N m", "")
    return Columns(names, units)


def _reaction_columns(sensor: Reaction) -> Columns:
    forces, impulses = ([f"{what} {axis}" for axis in AXES[:2]] for what in ("force", "impulse"))
    names = (*forces, "moment", "largest force", "largest moment", *impulses, "angular impulse", "drive", "unique")
    along, pushed = ("N",) * 2, ("N s",) * 2
    return Columns(names, (*along, "N m", "N", "N m", *pushed, "N m s", "N or N m", ""))


def _reaction(sensor: Reaction | SpatialReaction, window: Window) -> Any:
    found = joint_reaction(window.result, sensor.joint, sensor.axes)
    drive = np.full(len(found.times), np.nan) if found.drive is None else found.drive
    parts = (
        found.force, found.moment, found.largest_force, found.largest_moment, found.impulse, found.angular_impulse,
        drive, found.unique,
    )  # fmt: skip
    return np.column_stack(parts)[window.skipped :]


def _contact_columns(sensor: Contact) -> Columns:
    names = ("normal force", "tangential force", "normal impulse", "tangential impulse", "gap", "state")
    return Columns(names, ("N", "N", "N s", "N s", "m", ""))


def _spatial_contact_columns(sensor: SpatialContact) -> Columns:
    forces, impulses = ([f"friction {what} {axis}" for axis in AXES] for what in ("force", "impulse"))
    names = ("normal force", *forces, "normal impulse", *impulses, "gap", "state")
    return Columns(names, (*["N"] * 4, *["N s"] * 4, "m", ""))


def _contact(sensor: Contact | SpatialContact, window: Window) -> Any:
    found = window.result.contact(sensor.contact)
    return np.column_stack([found.force, found.impulse, found.gap, found.state])[window.skipped :]


def _section_columns(sensor: Section) -> Columns:
    return Columns(("N", "V", "M"), ("N", "N", "N m"))


def _section(sensor: Section, window: Window) -> Any:
    found: Any = sections(window.result, str(sensor.body), sensor.x, sensor.normal, np.array(window.rows), window.step)
    return np.column_stack([found.N, found.V, found.M])


def _spatial_section_columns(sensor: SpatialSection) -> Columns:
    units = (*["N"] * 3, *["N m"] * 3, "")
    if sensor.normal is None:
        return Columns(("N", "V_y", "V_z", "T", "M_y", "M_z", "unique"), units)
    force, moment = (tuple(f"{what} {axis}" for axis in AXES) for what in ("force", "moment"))
    return Columns((*force, *moment, "unique"), units)


def _spatial_section(sensor: SpatialSection, window: Window) -> Any:
    rows = np.array(window.rows)
    found: Any = sections(window.result, sensor.body, sensor.x, sensor.normal, rows, window.step)
    if hasattr(found, "middle"):  # of a solid
        return np.column_stack([found.force, found.moment, found.unique])
    return np.column_stack([found.N, found.V_y, found.V_z, found.T, found.M_y, found.M_z, found.unique])


def _stress_columns(sensor: Stress) -> Columns:
    parts = ("xx", "yy", "xy", "zz", *(("yz", "zx") if len(sensor.place) == 3 else ()))
    return Columns((*parts, "von Mises"), ("Pa",) * (len(parts) + 1))


def _stress(sensor: Stress, window: Window) -> Any:
    history = stress_history(window.result, str(sensor.body), sensor.static, window.step)
    components = history.places.shape[1]
    if len(sensor.place) != components:
        raise ModelError(f"place: {shown(sensor.place)} was given, expected {components} numbers, undeformed")
    away = np.hypot.reduce(history.places - sensor.place, axis=1)
    k = int(away.argmin())
    if not away[k] <= AT_NODE * float(np.ptp(history.places, axis=0).max()):
        nearest = ", ".join(f"{value:.9g}" for value in history.places[k])
        raise ModelError(
            f"place: {shown(sensor.place)} was given, expected a place where stresses are known, the nearest of which "
            f"is ({nearest})"
        )
    names = [name.replace(" ", "_").lower() for name in _stress_columns(sensor).names]
    found = [history.of(row) for row in window.rows]
    return np.array([[getattr(one, name)[k] for name in names] for one in found]).reshape(-1, len(names))


def _function_columns(sensor: Function) -> Columns:
    return Columns(tuple(sensor.columns), tuple(sensor.units))


def _function(sensor: Function, window: Window) -> Any:
    count = len(sensor.columns)
    expected = "one number" if count == 1 else f"{count} numbers, one a column"
    rows = np.full((len(window.rows), count), np.nan)
    for k, row in enumerate(window.rows):
        now = Instant.of(window.result, row)
        try:
            given = called("function", sensor.function, expected, now)
            values = numbers(given)
            if values is None or values.size != count:
                raise ModelError(f"function: it returned {shown(given)}, expected {expected}")
        except ModelError as error:
            raise Unmeasured(f"{error} (at t = {now.time:.9g} s)", rows[:k]) from error
        rows[k] = values.reshape(count)
    return rows


class Unmeasured(ModelError):
    """A function of the user failed; what was measured before it did is kept."""

    def __init__(self, message: str, rows: FloatArray) -> None:
        super().__init__(message)
        self.rows = rows


KINDS: dict[type, tuple[Callable[[Any], Columns], Callable[[Any, Window], Any]]] = {
    MaterialPoint: (_point_columns, _point),
    Body: (_body_columns, _body),
    SpatialFrame: (_frame_columns, _frame),
    StateNumbers: (_numbers_columns, _numbers),
    Coordinates: (_coordinates_columns, _coordinates),
    Energy: (_energy_columns, _energy),
    Reaction: (_reaction_columns, _reaction),
    SpatialReaction: (_spatial_reaction_columns, _reaction),
    Contact: (_contact_columns, _contact),
    SpatialContact: (_spatial_contact_columns, _contact),
    Section: (_section_columns, _section),
    SpatialSection: (_spatial_section_columns, _spatial_section),
    Stress: (_stress_columns, _stress),
    Function: (_function_columns, _function),
}


def known(sensor: Any) -> bool:
    """Whether sensors of this kind can be measured."""
    return type(sensor) in KINDS


def columns_of(sensor: Any) -> Columns:
    """What a sensor measures."""
    return KINDS[type(sensor)][0](sensor)


def measured(sensor: Any, window: Window) -> FloatArray:
    """(m, k) what a sensor measures at the instants of a window.

    Raises ModelError where it cannot, and :class:`Unmeasured` with the instants before where a function of the user
    fails.
    """
    return np.asarray(KINDS[type(sensor)][1](sensor, window), dtype=np.float64)
