"""What sensors of all kinds have: a name, and the time between the instants at which they measure."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar, Protocol, runtime_checkable

from lcpflex.basics.arguments import sequence_of
from lcpflex.basics.options import keep_number_or_none
from lcpflex.errors import ModelError, shown
from lcpflex.scene.placed_body import PlacedBody
from lcpflex.scene.placed_surface import check_own

__all__ = ["Sensor", "body_name", "check_placed_sensor", "check_sensor", "keep_body", "keep_text", "named_sensors"]


@runtime_checkable
class Sensor(Protocol):
    """A sensor: a frozen dataclass of a kind that :mod:`lcpflex.results.measures` knows."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def every(self) -> float | None: ...
    @property
    def name(self) -> str: ...


def check_sensor(sensor: Any) -> None:
    """Keep the interval as a float or None; raise ModelError where it or the name cannot be."""
    owner = type(sensor).__name__
    keep_number_or_none(sensor, "every", 0.0, math.inf, label=f"{owner}: every")
    if not isinstance(sensor.name, str):
        raise ModelError(f"{owner}: name: {shown(sensor.name)} was given, expected a text")


def keep_text(sensor: Any, field: str, expected: str) -> None:
    """Raise ModelError unless a field is a text that is not empty."""
    value = getattr(sensor, field)
    if not isinstance(value, str) or not value:
        raise ModelError(f"{type(sensor).__name__}: {field}: {shown(value)} was given, expected {expected}")


def keep_body(sensor: Any) -> None:
    """Raise ModelError unless the field ``body`` is a handle of one, or a name."""
    body = sensor.body
    if isinstance(body, PlacedBody) and body.body >= 0:
        return
    keep_text(sensor, "body", "a body of the scene, or its name")


def body_name(sensor: Any) -> str:
    """Name of the body of a sensor."""
    return str(sensor.body.name if isinstance(sensor.body, PlacedBody) else sensor.body)


def named_sensors(given: Any) -> tuple[Sensor, ...]:
    """The sensors of a user's own system, those without a name with one. Raises ModelError for what are none."""
    sensors = sequence_of("sensors", given, "a sequence of sensors such as lf.sensors.Coordinates(('q 1',))")
    for sensor in sensors:
        if isinstance(sensor, type) or not isinstance(sensor, Sensor):
            raise ModelError(f"sensors: {shown(sensor)} was given, expected sensors such as lf.sensors.Contact(name)")
    names = [sensor.name for sensor in sensors if sensor.name]
    if len(set(names)) != len(names):
        raise ModelError(f"sensors: {shown(names)} was given, expected different names")
    free = (name for k in range(1, 1 + len(sensors) + len(names)) if (name := f"sensor{k}") not in names)
    called: list[Any] = [sensor if sensor.name else replace(sensor, name=next(free)) for sensor in sensors]
    return tuple(called)


def check_placed_sensor(scene: object, sensor: object) -> None:
    """Raise ModelError for what is no sensor, and for one of a point or body of another scene."""
    if isinstance(sensor, type) or not isinstance(sensor, Sensor):
        raise ModelError(f"sensor: {shown(sensor)} was given, expected a sensor such as lf.sensors.Point(P)")
    for field in ("P", "body"):
        if getattr(getattr(sensor, field, None), "scene", None) is not None:
            check_own(scene, "sensor", getattr(sensor, field))
