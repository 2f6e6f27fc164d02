"""What a scene asks of one of its bodies: the interfaces at which joints, loads and contacts act on it.

A surface of many nodes contributes some of them, evenly spread: with all of them a body would have as many coordinates
as its mesh has on its boundary. Between them, the free modes are what gives way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from numbers import Real
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.surface import Kind
from lcpflex.model.coordinates import is_angular
from lcpflex.scene.joints.joint import Joint
from lcpflex.scene.loads.load import Effort, Load

if TYPE_CHECKING:
    from lcpflex.bodies.body import MaterialPoint
    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.bodies.surface import Surface
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.declared import DeclaredContact

__all__ = ["Acting", "acting_on", "chosen_nodes_of", "normals_of"]

LOOKED_AT = (0.0, 0.09, 0.21, 0.33, 0.42, 0.5, 0.59, 0.71, 0.83, 0.92, 1.0)
CORNER = 0.9  # cosine of the turn from where on a node of a chain is a corner, which is touched in any direction


class Acting(NamedTuple):
    """Something that acts on a body at an interface."""

    interface: Interface
    name: str  # of the joint, load or contact, for texts
    arm: float = math.inf  # of the forces that make a moment there [m]; infinite: it is one of its own
    surface: str = ""  # label of the surface of several nodes that it is one of
    at: tuple[float, ...] = ()  # in space, where the interface is in the body frame [m], for texts
    named: bool = False  # whether the surface is a named face: where it touches, it gives way as the mesh does


Snap = Callable[[float, float], tuple[tuple[float, float], bool]]  # nearest material, and whether the place is off it


def acting_on(
    body: int,
    joints: Mapping[str, Joint],
    loads: tuple[Load, ...],
    contacts: Mapping[str, DeclaredContact],
    contact_nodes: int | None,
    snap: Snap,
    on_axis: bool,
    angle: Callable[[int], float],
    any_way: bool = False,
    frame: MaterialPoint | None = None,
) -> list[Acting]:
    """What acts on a body; of a surface with more nodes, at ``contact_nodes`` of them, or where None looks at it.

    ``on_axis``: it is a line, whose sections do not deform; ``angle`` of each body at the start [rad]; ``any_way``:
    with friction, a surface gives way along itself as well; ``frame``: a point that rides with the frame of the body,
    where nothing gives way.
    """
    found = [*_of_joints(body, joints, angle, frame), *_of_loads(body, loads)]
    for name, contact in contacts.items():
        for surface in contact.pair:
            if surface.body == body:
                rubs = contact.friction > 0.0
                arm = math.inf if surface.shape.kind is Kind.HALF_PLANE else surface.shape.radius
                several = surface.label if len(surface.shape.points) > 1 and surface.shape.kind is Kind.CHAIN else ""
                found += [
                    Acting(interface, f"contact {name!r}", arm, several)
                    for interface in _of_surface(surface.shape, rubs, contact_nodes, snap, on_axis, any_way)
                ]
    return found


def _of_joints(
    body: int, joints: Mapping[str, Joint], angle: Callable[[int], float], frame: MaterialPoint | None
) -> Iterator[Acting]:
    for name, joint in joints.items():
        for point in (joint.P, joint.Q):
            if point.body == body and point.material is not frame:
                along, turns = _of_joint(joint, point is joint.Q, angle)
                forces = not all(is_angular(row.kind) for row in joint.rows())
                yield Acting(_at(point, turns, forces, along), f"joint {name!r}")


def _of_joint(joint: Joint, guides: bool, angle: Callable[[int], float]) -> tuple[tuple[float, float] | None, bool]:
    """Direction of the force of a joint on one of its bodies, None for any; and whether it has a moment there.

    ``guides``: it is the body of Q, which carries the line that the joint keeps, and what is pushed on it has a lever.
    """
    rows = joint.rows()
    turns = any(is_angular(row.kind) for row in rows)
    forces = [row for row in rows if not is_angular(row.kind)]
    slides = any(row.kind == "along" for row in forces)
    if len(forces) != 1 or not slides or not (guides or turns):
        return None, turns or (slides and guides)
    x, y = forces[0].axis
    turn = 0.0 if guides else angle(joint.Q.body) - angle(joint.P.body)  # which a prismatic joint keeps
    cos, sin = math.cos(turn), math.sin(turn)
    return (cos * x - sin * y, sin * x + cos * y), True


def _of_loads(body: int, loads: tuple[Load, ...]) -> Iterator[Acting]:
    for load in loads:
        form = load.form()
        turns = form.kind == "torque" if isinstance(form, Effort) else is_angular(form.coordinate.kind)
        along = _direction(form) if isinstance(form, Effort) else None
        for point in (load.P, getattr(load, "Q", None)):
            if point is not None and point.body == body:
                name = f"{type(load).__name__.lower()} at {point.label}"
                yield Acting(_at(point, moment=turns, forces=not turns, along=along), name)


def _at(point: PlacedPoint, moment: bool, forces: bool, along: tuple[float, float] | None = None) -> Interface:
    x, y = (float(value) for value in point.material.place)
    return Interface((x, y), along, moment, contact=False, forces=forces)


def _direction(form: Effort) -> tuple[float, float] | None:
    """Of a force that always has the same one in the body."""
    if form.kind != "follower" or callable(form.value):
        return None
    x, y = (isinstance(part, Real) and part == 0.0 for part in form.value)
    return None if x == y else (0.0, 1.0) if x else (1.0, 0.0)


def _of_surface(
    surface: Surface, rubs: bool, count: int | None, snap: Snap, on_axis: bool, any_way: bool
) -> list[Interface]:
    """The interfaces of a contact surface; ``rubs``: it has friction.

    At a node, a disc or an arc forces have any direction. On a chain they are normal, which is where it gives way; the
    nodes of it are few, and forces along them would ask for as many more modes of much higher frequency.
    """
    if surface.kind is not Kind.CHAIN:  # forces on a radius or a half-plane reach the material with a lever
        lever = surface.kind is Kind.HALF_PLANE or (rubs and surface.kind is not Kind.NODE)
        return [_on_material(surface.points[0], snap, None, lever)]
    chosen = chosen_nodes_of(surface, count, on_axis)
    normals = normals_of(surface)
    found = []
    for k in chosen:
        x = float(surface.points[k].place[0])
        if on_axis and not (normals[k].any() or (rubs and any_way)) and not snap(x, 0.0)[1]:
            # at the end of a line it is its axis that gives way, along it and across
            found += [Interface((x, 0.0), way, moment=False) for way in ((1.0, 0.0), (0.0, 1.0))]
            continue
        normal = normals[k].any() and not (rubs and any_way)
        along = (float(normals[k][0]), float(normals[k][1])) if normal else None
        found.append(_on_material(surface.points[k], snap, along, False))
    return found


def _on_material(point: MaterialPoint, snap: Snap, along: tuple[float, float] | None, lever: bool) -> Interface:
    """The interface of a point, or of the material that carries one beside the body."""
    place, off = snap(*(float(value) for value in point.place))
    return Interface(place, None if off else along, moment=lever or off)


def chosen_nodes_of(surface: Surface, count: int | None, on_axis: bool) -> list[int]:
    """``count`` nodes of a chain at most, evenly spread along it: along the axis of a line, where faces share it.

    None: at the uneven parts LOOKED_AT, which lie between those of any number of even ones.
    """
    if count == 0:
        return []
    places = np.array([point.place for point in surface.points])
    if on_axis and np.ptp(places[:, 0]) > 0.0:
        along = places[:, 0]
    else:
        step = np.hypot(*np.diff(places, axis=0).T)
        along = np.concatenate([[0.0], np.cumsum(step)])
    end = float(along.max())
    if count is None:
        wanted = along.min() + (end - along.min()) * np.array(LOOKED_AT)
    elif surface.closed and not on_axis:
        end += float(np.hypot(*(places[0] - places[-1])))
        wanted = along.min() + (end - along.min()) * np.arange(count) / count
    else:
        wanted = np.linspace(along.min(), end, count) if count > 1 else np.array([0.5 * (along.min() + end)])
    return sorted({int(np.abs(along - place).argmin()) for place in wanted})


def normals_of(surface: Surface) -> FloatArray:
    """(k, 2) outward unit normal at each node of a chain; 0 at corners, which are touched in any direction."""
    places = np.array([point.place for point in surface.points])
    after = np.roll(places, -1, axis=0) - places
    before = np.roll(after, 1, axis=0)
    if not surface.closed:
        after[-1], before[0] = before[-1], after[0]
    units = [step / np.hypot(*step.T)[:, None] for step in (before, after)]
    turn = np.sum(units[0] * units[1], axis=1)
    mean = units[0] + units[1]
    normal = np.column_stack([mean[:, 1], -mean[:, 0]]) / np.maximum(np.hypot(*mean.T), 1e-12)[:, None]
    normal[turn < CORNER] = 0.0
    return np.asarray(normal)
