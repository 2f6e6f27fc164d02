"""Interfaces of bodies of space: unit forces and moments there as loads on the mesh, and the material that is there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lcpflex.bodies.reduction.interface import Interface, NodeMean
from lcpflex.bodies.spatial.elastic import PointOperator, load_columns
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint

__all__ = ["Find", "contact_columns", "interface_columns", "point_at", "unit_loads"]

Find: TypeAlias = Callable[[str, Any], PointOperator]  # argument in messages, place of an interface -> the point there


def interface_columns(find: Find, f: int, interfaces: Sequence[Any]) -> FloatArray:
    """(f, k) unit forces and moments at interfaces, those that tell something; at a numbered node forces alone."""
    columns = [np.zeros((f, 0))]
    for k, one in enumerate(interfaces):
        name = f"interfaces[{k}]"
        if not isinstance(one, Interface):
            columns.append(load_columns([(find(name, one), not isinstance(one, int | np.integer))], f))
            continue
        operator = find(name, one.place)
        if not (one.forces or operator.turns):
            raise ModelError(f"{name}: forces: False was given at nodes on one line, which turn with no moment")
        if one.forces:
            forces = load_columns([(operator, False)], f)
            columns.append(forces if one.along is None else forces @ _along(name, one))
        if one.moment and operator.turns:
            columns.append(_moments(operator, f))
    return np.hstack(columns)


def contact_columns(find: Find, f: int, interfaces: Sequence[Any]) -> int:
    """How many of these are at interfaces that something touches."""
    touched = [one for one in interfaces if not isinstance(one, Interface) or one.contact]
    return interface_columns(find, f, touched).shape[1]


def unit_loads(find: Find, f: int, place: Any) -> FloatArray:
    """(f, 6) three unit forces and three unit moments at the place of an interface; none where no rotation is known."""
    operator = find("place", place)
    return np.hstack([load_columns([(operator, False)], f), _moments(operator, f)])


def point_at(body: SpatialBody, place: Any) -> SpatialPoint:
    """The material of a reduced body at the place of an interface, which is told by the mesh."""
    if isinstance(place, str):
        return body.points[place]
    if isinstance(place, NodeMean):
        return body.at_nodes(place.nodes, place.weights)
    if isinstance(place, int):
        return body.at_nodes(place)
    return body.locate(*(np.array(place) - body.origin).tolist())


def _moments(operator: PointOperator, f: int) -> FloatArray:
    return load_columns([(operator._replace(u=operator.psi), False)], f)


def _along(name: str, interface: Interface) -> FloatArray:
    direction = np.array(interface.along)
    if len(direction) != 3:
        raise ModelError(f"{name}: along {shown(interface.along)} was given, expected a direction (x, y, z)")
    return direction[:, None]
