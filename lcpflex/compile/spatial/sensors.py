"""Sensors of a spatial scene as data: what refers to the scene becomes names, numbers and arrays."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.compile.coordinates import coordinate_names, coordinate_units, rate_labels, velocity_names, velocity_units
from lcpflex.errors import ModelError
from lcpflex.model.arrays import frozen
from lcpflex.scene.sensors.forces import (
    Contact,
    Reaction,
    Section,
    SpatialContact,
    SpatialReaction,
    SpatialSection,
    Stress,
)
from lcpflex.scene.sensors.motions import Body, Coordinates, MaterialPoint, Point, SpatialFrame, StateNumbers
from lcpflex.scene.sensors.sensor import Sensor, body_name

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import Layout
    from lcpflex.model.spatial import SpatialBodies

__all__ = ["compiled_spatial_sensor"]


def compiled_spatial_sensor(name: str, sensor: Sensor, bodies: SpatialBodies, layout: Layout) -> Sensor:
    """The sensor of that name. Raises ModelError for unknown bodies and names."""
    if isinstance(sensor, Point):
        material = sensor.P.material
        return MaterialPoint(sensor.P.body, frozen(material.place), frozen(material.phi), sensor.every, name)
    if isinstance(sensor, Body):
        called = body_name(sensor)
        if called not in layout.bodies:
            raise ModelError(f"sensor {name!r}: body: no body {absent(called, layout.bodies)}")
        return SpatialFrame(layout.bodies.index(called), sensor.every, name)
    if isinstance(sensor, Coordinates):
        return _numbers(name, sensor, bodies, layout)
    if isinstance(sensor, Reaction):
        if sensor.joint not in layout.joints:
            raise ModelError(f"sensor {name!r}: joint: no joint {absent(sensor.joint, layout.joints)}")
        return SpatialReaction(sensor.joint, sensor.axes, sensor.every, name)
    if isinstance(sensor, Contact):
        return SpatialContact(sensor.contact, sensor.every, name)
    if isinstance(sensor, Section):
        return SpatialSection(body_name(sensor), sensor.x, sensor.every, name, sensor.normal)
    if isinstance(sensor, Stress):
        return replace(sensor, body=body_name(sensor), name=name)
    named: Any = sensor
    return replace(named, name=name)  # type: ignore[no-any-return]


def _numbers(name: str, sensor: Coordinates, bodies: SpatialBodies, layout: Layout) -> StateNumbers:
    """Of q, of u, or of a mode both."""
    names = (*coordinate_names(bodies, layout), *velocity_names(bodies, layout))
    labels = (*coordinate_names(bodies, layout), *rate_labels(bodies, layout))
    units = (*coordinate_units(bodies), *velocity_units(bodies))
    chosen: list[int] = []
    for one in sensor.names:
        if one not in names:
            raise ModelError(f"sensor {name!r}: names: no coordinate or velocity {absent(one, dict.fromkeys(names))}")
        chosen += np.flatnonzero(np.array(names) == one).tolist()
    chosen.sort(key=lambda k: k >= int(bodies.place[-1]))  # coordinates first, in the order asked for
    return StateNumbers(
        tuple(labels[k] for k in chosen), tuple(units[k] for k in chosen), tuple(chosen), sensor.every, name
    )
