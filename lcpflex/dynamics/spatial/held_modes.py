"""What joints and springs hold of spatial bodies: see :mod:`lcpflex.dynamics.held_modes`."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from lcpflex.dynamics.held_modes import Way
from lcpflex.dynamics.spatial.mass_matrix import body_mass_matrix
from lcpflex.dynamics.spatial.static_modes import at_rest, frame_axes
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.rotations import axes_at, compose, exponential, unit
from lcpflex.model.coordinates import ALONG, ANGULAR, PERPENDICULAR
from lcpflex.model.spatial import N_RIGID, SpatialBodies, SpatialModel, SpatialPoints

__all__ = ["joint_ways", "mass_at_rest", "motions_of", "move_frame", "ways_of_point"]


def move_frame(bodies: SpatialBodies, frame: FloatArray, sign: float, T: FloatArray, modal: FloatArray) -> None:
    """The frame (7,), in place, along with modal coordinates, or back: its axes are those of ``modal``'s own model."""
    shift = T[:N_RIGID] @ modal
    w, x, y, z = frame[3:].tolist()
    turned = unit(compose((w, x, y, z), exponential(*(sign * shift[3:]).tolist())))
    before = axes_at(frame, 0)
    frame[3:] = turned
    frame[:3] += sign * (before if sign > 0.0 else axes_at(frame, 0)) @ shift[:3]


def joint_ways(model: SpatialModel, q: FloatArray, b: int) -> list[Way]:
    """How body b moves at its joints in the ways in which these may push it.

    Two axes that stay parallel push about those across them alone, and what is led along or across axes of a body that
    keeps its orientation about them, along these alone; else along and about all.
    """
    joints = model.joints
    found: list[Way] = []
    for ends, (first, last) in zip(joints.point.tolist(), pairwise(joints.row.tolist()), strict=True):
        kinds = joints.kind[first:last]
        turning, along = np.flatnonzero(ANGULAR[kinds]) + first, np.flatnonzero(~ANGULAR[kinds]) + first
        for point in ends:
            if model.points.body[point] != b:
                continue
            guides = point == ends[1]
            push, twist = motions_of(model.points, point)
            if len(along) and (joints.kind[along] == ALONG).all() and (guides or len(turning) > 1):
                own = _seen_from(model, q, ends[1], point)
                found += [(push.T @ (own @ axis), False) for axis in joints.axis[along]]
            elif len(along):
                found += [(way, False) for way in push]
            if len(turning) == 2 and (joints.kind[turning] == PERPENDICULAR).all() and not (guides and len(along)):
                hinge = np.cross(*joints.axis[turning]) if guides else joints.on_p[turning[0]]
                found += [(twist.T @ axis, True) for axis in np.linalg.svd(hinge[None])[2][1:]]
            elif len(turning) or (guides and (joints.kind[along] == ALONG).any()):
                found += [(way, True) for way in twist]
    return found


def _seen_from(model: SpatialModel, q: FloatArray, a: int, b: int) -> FloatArray:
    """(3, 3) what turns axes of the body of point a into those of the body of point b, standing at q."""
    of_a, of_b = (frame_axes(model, q, int(model.points.body[p])) for p in (a, b))
    return of_b.T @ of_a


def motions_of(points: SpatialPoints, p: int) -> tuple[FloatArray, FloatArray]:
    """(3, 6 + n) displacement of point p along the axes of its body, and rotation about them, of frame and modes."""
    own = slice(points.start[p], points.start[p + 1])
    x, y, z = points.place[p].tolist()
    arm = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # of rotations about the frame
    push = np.hstack([np.eye(3), arm, points.phi[own].T])
    return push, np.hstack([np.zeros((3, 3)), np.eye(3), points.psi[own].T])


def ways_of_point(points: SpatialPoints, p: int, kinds: list[int], guides: bool) -> list[Way]:
    """Ways of a point along all axes, if relative coordinates of such kinds push it, and turning, if one turns it.

    ``guides``: it carries the line that a coordinate is measured along, so that what slides on it has a lever.
    """
    push, twist = motions_of(points, p)
    found = [(way, False) for way in push] if any(not ANGULAR[kind] for kind in kinds) else []
    turns = any(ANGULAR[kind] for kind in kinds) or (guides and ALONG in kinds)
    return [*found, *((way, True) for way in twist)] if turns else found


def mass_at_rest(model: SpatialModel, b: int) -> FloatArray:
    """M (6 + n, 6 + n) of body b, unturned and undeformed."""
    return body_mass_matrix(model.bodies, b, at_rest(model))
