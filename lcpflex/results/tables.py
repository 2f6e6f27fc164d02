"""Results for other programs: a table of pandas, labelled arrays of xarray; every column and array with its unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.version import VERSION
from lcpflex.compile.coordinates import coordinate_units, rate_labels, velocity_units
from lcpflex.errors import ModelError
from lcpflex.force_laws.friction.creep import CREEP
from lcpflex.model.arrays import OPEN, SLIP, STICK
from lcpflex.results.energy_balance import Energies

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from lcpflex.results.result import Result

__all__ = ["columns_at_rest", "facts", "to_dataframe", "to_xarray"]

AXES = ("x", "y", "z")
COMPONENTS = ("normal", "tangential")
NO_PRESSURE = "0: force over area is no pressure"
IN_SPACE = ("normal", "friction x", "friction y", "friction z")  # components of contact forces there
STATES = {"open": OPEN, "stick": STICK, "slip": SLIP, "creep": CREEP}
OF_EACH_INSTANT = {"residual": "1", "penetration": "m", "joint_drift": "m or rad", "size": "1", "strict": "1"}

OF_SENSORS = "time", "column", "units"

Variable = tuple[tuple[str, ...], "NDArray[Any]", dict[str, Any]]  # dimensions, values, attributes


def facts(result: Result) -> dict[str, Any]:
    """What a result says of its run, as numbers and texts; those that are not known are not among them.

    Warnings, notes and what went wrong are lines of one text; ``complete`` is 0 or 1, as files have no truth values.
    """
    lines = {name: "\n".join(getattr(result, name)) for name in ("warnings", "found_wrong", "notes")}
    plain = ("stepper", "duration", "message", "stored", "steps", "wall_time", "compile_time", "python_calls",
             "python_time", "impact_step")  # fmt: skip
    told = {name: getattr(result, name) for name in plain if getattr(result, name) is not None}
    return {"lcpflex": VERSION, **told, "complete": int(result.complete), **lines, **_error_facts(result)}


def _error_facts(result: Result) -> dict[str, float]:
    """The measured error in numbers [m], [m/s], [s]; none where it was not measured."""
    error = result.error
    if error is None:
        return {}
    names = ("place", "turn", "speed", "speed_rms", "extent", "fastest", "horizon")
    return {f"error_{name}": float(getattr(error, name)) for name in names}


def to_dataframe(result: Result) -> Any:
    """See :meth:`lcpflex.results.result.Result.to_dataframe`."""
    try:
        pandas = libs.pandas
    except ImportError as error:
        raise ModelError("to_dataframe() needs pandas, which is not installed: pip install pandas") from error
    columns = _columns(result)
    table = pandas.DataFrame(
        {name: values for name, (values, _) in columns.items()}, index=pandas.Index(result.times, name="time")
    )
    table.attrs |= {"units": {"time": "s", **{name: unit for name, (_, unit) in columns.items()}}, **facts(result)}
    return table


def _columns(result: Result) -> dict[str, tuple[NDArray[Any], str]]:
    """Values (m,) and unit of each column."""
    rates = _units(result)[1]
    columns = _coordinate_columns(result)
    columns |= {name: (result.u[:, k], rates[k]) for k, name in enumerate(_rates(result))}
    for k, name in enumerate(result.contact_names):
        columns |= _contact_columns(result, k, (("force", result.force, "N"), ("impulse", result.impulse, "N s")))
        columns[f"{name}.gap"] = (result.gap[:, k], "m")
    columns |= _joint_columns(result)
    columns |= {f"energy.{name}": (getattr(result.energies, name), "J") for name in Energies.__dataclass_fields__}
    known = {name: unit for name, unit in OF_EACH_INSTANT.items() if getattr(result, name) is not None}
    return columns | {name: (getattr(result, name), unit) for name, unit in known.items()}


def columns_at_rest(result: Result) -> dict[str, tuple[NDArray[Any], str]]:
    """Those of configurations and forces alone."""
    columns = _coordinate_columns(result)
    for k in range(len(result.contact_names)):
        columns |= _contact_columns(result, k, (("force", result.force, "N"),))
    return columns | _joint_columns(result)


def _coordinate_columns(result: Result) -> dict[str, tuple[NDArray[Any], str]]:
    units = _units(result)[0]
    return {name: (result.q[:, k], units[k]) for k, name in enumerate(result.coordinate_names())}


def _contact_columns(
    result: Result, k: int, told: Sequence[tuple[str, NDArray[Any], str]]
) -> dict[str, tuple[NDArray[Any], str]]:
    """What is told of contact k, (m, nc, parts) each, and its state."""
    name = result.contact_names[k]
    columns: dict[str, tuple[NDArray[Any], str]] = {}
    for what, values, unit in told:
        columns |= {f"{name}.{way} {what}": (values[:, k, c], unit) for c, way in enumerate(_components(result))}
    return columns | {f"{name}.state": (result.state[:, k], "1")}


def _joint_columns(result: Result) -> dict[str, tuple[NDArray[Any], str]]:
    if result.joint_force is None:
        return {}
    return {
        f"{name}.{way}": (result.joint_force[:, k, i], unit)
        for k, name in enumerate(_joints(result))
        for i, (way, unit) in enumerate(_reaction_columns(result))
    }


def to_xarray(result: Result) -> Any:
    """See :meth:`lcpflex.results.result.Result.to_xarray`. Dimensions of length 0 are none: netCDF 3 has no such."""
    try:
        xarray = libs.xarray
    except ImportError as error:
        raise ModelError("to_xarray() needs xarray, which is not installed: pip install 'lcpflex[tables]'") from error
    variables = {**_motion(result), **_contacts(result), **_joint_variables(result), **_touches(result)}
    variables |= _events(result)
    variables |= _error(result)
    sensed, at = _sensors(result)
    variables |= sensed
    variables |= {
        f"energy_{name}": _variable(getattr(result.energies, name), "J", "time")
        for name in Energies.__dataclass_fields__
    }
    units, rates = _units(result)
    names = {"coordinate": result.coordinate_names(), "contact": result.contact_names, "joint": _joints(result)}
    if _of_space(result):
        names[_of_u(result)] = _rates(result)
    coordinates = {
        "time": _variable(result.times, "s", "time"),
        **{name: ((name,), _texts(labels)) for name, labels in names.items()},
        "q_units": (("coordinate",), _texts(units)),
        "u_units": ((_of_u(result),), _texts(rates)),
        "component": (("component",), _texts(_components(result))),
        "axis": (("axis",), _texts(_axes(result))),
        **at,
    }
    if result.error is not None:
        coordinates["error_time"] = _variable(result.error.times, "s", "error_time")
        coordinates["error_body"] = (("error_body",), _texts(result.error.bodies))
    there = {name: one for name, one in variables.items() if np.size(one[1]) or one[0] == ("time",)}
    dimensions = {name for one in there.values() for name in one[0]}
    used = {name: one for name, one in coordinates.items() if set(one[0]) <= dimensions}
    return xarray.Dataset(there, used, facts(result))


def _motion(result: Result) -> dict[str, Variable]:
    of_each = {name: unit for name, unit in OF_EACH_INSTANT.items() if getattr(result, name) is not None}
    return {
        "q": _variable(result.q, "see q_units", "time", "coordinate"),
        "u": _variable(result.u, "see u_units", "time", _of_u(result)),
        **{name: _variable(getattr(result, name), unit, "time") for name, unit in of_each.items()},
    }


def _contacts(result: Result) -> dict[str, Variable]:
    by_law = np.isin(_texts(result.contact_names), _texts(result.compliant))
    found = {
        "force": _variable(result.force, "N", "time", "contact", "component"),
        "impulse": _variable(result.impulse, "N s", "time", "contact", "component"),
        "state": _states(result.state, "time", "contact"),
        "gap": _variable(result.gap, "m", "time", "contact", about="NaN: farther than gaps are measured"),
        "compliant": _variable(by_law, "1", "contact"),
    }
    return found | ({"crept": _variable(np.array(result.crept), "m", "contact")} if result.crept else {})


def _of_space(result: Result) -> bool:
    return result.compiled is not None and result.compiled.spatial


def _axes(result: Result) -> tuple[str, ...]:
    """Names of the axes of the world."""
    return AXES if _of_space(result) else AXES[:2]


def _components(result: Result) -> tuple[str, ...]:
    """Names of the components of contact forces."""
    return IN_SPACE if result.force.shape[2] == len(IN_SPACE) else COMPONENTS


def _of_u(result: Result) -> str:
    """Name of the dimension of u: in space its numbers are not the rates of those of q."""
    return "velocity" if _of_space(result) else "coordinate"


def _rates(result: Result) -> tuple[str, ...]:
    """Name of each entry of u."""
    if result.compiled is None:
        return tuple(f"{name}'" for name in result.coordinate_names())
    return rate_labels(result.compiled.model.bodies, result.compiled.layout)


def _reaction_columns(result: Result) -> list[tuple[str, str]]:
    """Name and unit of each component of a reaction."""
    forces = [(f"force {axis}", "N") for axis in _axes(result)]
    return forces + ([(f"moment {axis}", "N m") for axis in AXES] if _of_space(result) else [("moment", "N m")])


def _joint_variables(result: Result) -> dict[str, Variable]:
    """Of results that recorded reactions."""
    force, peak, impulse, unique = result.joint_force, result.joint_peak, result.joint_impulse, result.joint_unique
    if force is None or peak is None or impulse is None or unique is None:
        return {}
    own, d = ("time", "joint"), len(_axes(result))
    turns, about = (slice(d, None), (*own, "axis")) if _of_space(result) else (d, own)
    return {
        "joint_force": _variable(force[..., :d], "N", *own, "axis"),
        "joint_moment": _variable(force[..., turns], "N m", *about),
        "joint_largest_force": _variable(peak[..., 0], "N", *own),
        "joint_largest_moment": _variable(peak[..., 1], "N m", *own),
        "joint_impulse": _variable(impulse[..., :d], "N s", *own, "axis"),
        "joint_angular_impulse": _variable(impulse[..., turns], "N m s", *about),
        "joint_unique": _variable(unique == 1, "1", *own),
    }


def _touches(result: Result) -> dict[str, Variable]:
    """Touching points of all instants, one behind the other: their number changes."""
    points = result.contact_points
    return {
        "touch_time_index": _variable(points.record, "1", "touch", about="index along time"),
        "touch_contact_index": _variable(points.contact, "1", "touch", about="index along contact"),
        "touch_place": _variable(points.place, "m", "touch", "axis"),
        "touch_normal": _variable(points.normal, "1", "touch", "axis"),
        "touch_force": _variable(points.force, "N", "touch", "component"),
        "touch_state": _states(points.state, "touch"),
    } | ({"touch_area": _variable(points.area, "m^2", "touch", about=NO_PRESSURE)} if _of_space(result) else {})


def _error(result: Result) -> dict[str, Variable]:
    """By how much places, rotations and velocities of bodies may be off; of a verified run."""
    error = result.error
    if error is None:
        return {}
    axes, share = ("error_time", "error_body"), result.compiled is None
    found = {
        f"error_{name}_curve": _variable(values, "1" if share else unit, *axes, about="the largest so far")
        for name, values, unit in (
            ("place", error.place_curve, "m"),
            ("turn", error.turn_curve, "m"),
            ("speed", error.speed_curve, "m/s"),
        )
    }
    return found | {
        "error_force": _variable(_by_contact(result, error.force), "N", "contact", about="where no impact is near"),
        "error_impulse": _variable(_by_contact(result, error.impulse), "N s", "contact"),
    }


def _by_contact(result: Result, values: Mapping[str, float]) -> NDArray[Any]:
    return np.array([values.get(name, 0.0) for name in result.contact_names])


def _events(result: Result) -> dict[str, Variable]:
    events = result.events
    return {
        "event_time": _variable(np.array([event.time for event in events], dtype=float), "s", "event"),
        "event_kind": _variable(_texts([event.kind for event in events]), "", "event"),
        "event_contact": _variable(_texts([event.contact for event in events]), "", "event"),
        "event_energy_change": _variable(np.array([one.energy_change for one in events], dtype=float), "J", "event"),
    }


def _sensors(result: Result) -> tuple[dict[str, Variable], dict[str, Any]]:
    """Of each sensor its measurements, a variable with dimensions of its own; and their coordinates."""
    variables: dict[str, Variable] = {}
    coordinates: dict[str, Any] = {}
    for sensor in result.sensors:
        label = "sensor_" + sensor.name.replace("/", "_")  # which parts groups of netCDF
        while {label, *(own := [f"{label}_{what}" for what in OF_SENSORS])} & {*variables, *coordinates}:
            label += "_"
        time, column, units = own
        told = [unit or "1" for unit in sensor.units]
        unit = told[0] if len(set(told)) == 1 else f"see {units}"
        variables[label] = ((time, column), sensor.values, {"units": unit, "long_name": sensor.name})
        coordinates[time] = _variable(sensor.times, "s", time)
        coordinates[column] = ((column,), _texts(sensor.columns))
        coordinates[units] = ((column,), _texts(told))
    return variables, coordinates


def _variable(values: NDArray[Any], unit: str, *dimensions: str, about: str = "") -> Variable:
    attributes = {"units": unit} | ({"comment": about} if about else {})
    return dimensions, values, {name: text for name, text in attributes.items() if text}


def _states(values: NDArray[Any], *dimensions: str) -> Variable:
    """By the conventions of CF for flags."""
    flags = {"flag_values": np.array(list(STATES.values()), dtype=np.int8), "flag_meanings": " ".join(STATES)}
    return dimensions, values, flags


def _texts(values: Sequence[str]) -> NDArray[Any]:
    return np.array(values, dtype=np.str_) if values else np.zeros(0, dtype="U1")


def _joints(result: Result) -> tuple[str, ...]:
    """Names of those whose reactions were recorded; rows of a user's own system have none."""
    return result.compiled.layout.joints if result.compiled is not None else ()


def _units(result: Result) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Of q and u; those of a user's own system are not known."""
    if result.compiled is None:
        return ("unknown",) * result.q.shape[1], ("unknown",) * result.u.shape[1]
    bodies = result.compiled.model.bodies
    return coordinate_units(bodies), velocity_units(bodies)
