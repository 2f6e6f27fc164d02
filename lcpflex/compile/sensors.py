"""Sensors of a scene as data: what refers to the scene becomes names, numbers and arrays."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from lcpflex.model.arrays import frozen
from lcpflex.scene.sensors.motions import MaterialPoint, Point
from lcpflex.scene.sensors.sensor import Sensor, body_name

__all__ = ["compiled_sensor"]


def compiled_sensor(name: str, sensor: Sensor) -> Sensor:
    """The sensor of that name in a scene of reduced bodies, in whose axes its points are."""
    if isinstance(sensor, Point):
        material = sensor.P.material
        return MaterialPoint(sensor.P.body, frozen(material.place), frozen(material.phi), sensor.every, name)
    named: Any = sensor
    parts = {"name": name} | ({"body": body_name(sensor)} if hasattr(sensor, "body") else {})
    return replace(named, **parts)  # type: ignore[no-any-return]
