"""Results of the first format: joints and springs as they were numbered before they named relative coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.model.coordinates import ALONG, ANGLE, COMPONENT, DISTANCE

__all__ = ["CHANGED"]

NO_AXIS = (1.0, 0.0)
REST_ANGLE, AXIS, REST_LENGTH = 0, slice(1, 3), 3  # columns of the values of a joint
REVOLUTE, WELD, PRISMATIC, POINT_ON_LINE, DISTANCE_JOINT, DRIVEN_ANGLE, DRIVEN_DISPLACEMENT = range(7)


def _rows(kind: int, value: Any, signal: int) -> list[tuple[int, tuple[float, float], float, int]]:
    """(relative coordinate, axis, rest, signal) of each row of a joint."""
    x, y = (float(part) for part in value[AXIS])
    angle, length, across = float(value[REST_ANGLE]), float(value[REST_LENGTH]), (-y, x)
    place = [(COMPONENT, (1.0, 0.0), 0.0, -1), (COMPONENT, (0.0, 1.0), 0.0, -1)]
    return {
        REVOLUTE: place,
        WELD: [*place, (ANGLE, NO_AXIS, angle, -1)],
        PRISMATIC: [(ALONG, across, 0.0, -1), (ANGLE, NO_AXIS, angle, -1)],
        POINT_ON_LINE: [(ALONG, across, 0.0, -1)],
        DISTANCE_JOINT: [(DISTANCE, NO_AXIS, length, signal)],
        DRIVEN_ANGLE: [(ANGLE, NO_AXIS, angle, signal)],
        DRIVEN_DISPLACEMENT: [(ALONG, (x, y), 0.0, signal)],
    }[kind]


def _joints(fields: dict[str, Any]) -> dict[str, Any]:
    each = zip(fields["kind"].tolist(), fields["value"], fields["signal"].tolist(), strict=True)
    rows = [row for joint in each for row in _rows(*joint)]
    return {
        "point": fields["point"],
        "row": fields["row"],
        "kind": _fixed([kind for kind, _, _, _ in rows], np.int64),
        "axis": _fixed([axis for _, axis, _, _ in rows], np.float64, 2),
        "rest": _fixed([rest for _, _, rest, _ in rows], np.float64),
        "signal": _fixed([signal for _, _, _, signal in rows], np.int64),
    }


def _loads(fields: dict[str, Any]) -> dict[str, Any]:
    kinds = [(DISTANCE, ANGLE)[kind] for kind in fields["spring_kind"].tolist()]
    axes = _fixed([NO_AXIS for _ in kinds], np.float64, 2)
    return {**fields, "spring_kind": _fixed(kinds, np.int64), "spring_axis": axes}


def _fixed(values: list[Any], dtype: type, columns: int = 0) -> Any:
    array: Any = np.array(values, dtype=dtype).reshape((len(values), columns) if columns else (len(values),))
    array.setflags(write=False)
    return array


CHANGED: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {"model.Joints": _joints, "model.Loads": _loads}
