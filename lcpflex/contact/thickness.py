"""How far two bodies can be inside each other before the nearest way out is on the other side, from undeformed shapes.

A step in which they move by more may take one through the other: at no instant looked at is it seen inside, or it is
seen when it already belongs to the other side. Half-planes have no other side.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.contact.narrow_phase.feature import ARC, VERTEX
from lcpflex.contact.spatial.kinds import CAP, EDGE, POINT
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Contacts, Points

__all__ = ["farthest", "law_thickness", "pass_thickness", "surface_thickness", "thinnest"]


def surface_thickness(contacts: Contacts) -> FloatArray:
    """(surfaces, 2) least radius of its nodes, and least depth of its features [m]; infinite where it has none.

    The sum of the first of one surface and the second of another is how deep nodes of the one can be in the other:
    infinite for half-planes.
    """
    depths = _feature_depths(contacts)
    radii = np.where(contacts.node_radius >= 0.0, contacts.node_radius, math.inf)  # < 0: ends of a bore
    thickness = np.full((len(contacts.surface_body), 2), math.inf)
    for column, start, values in ((0, contacts.node_start, radii), (1, contacts.feature_start, depths)):
        some = np.diff(start) > 0  # of the others, reduceat would take those of the next
        if some.any():
            thickness[some, column] = np.minimum.reduceat(values, start[:-1][some])
    return thickness


def thinnest(contacts: Contacts, thickness: FloatArray) -> float:
    """The least of all passes [m]; ``thickness`` of the surfaces."""
    least = (thickness[contacts.pass_node, 0] + thickness[contacts.pass_feature, 1]).min(initial=math.inf)
    ruled = thickness[: len(contacts.rule_rank)]
    return min(float(least), float(ruled[:, 0].min(initial=math.inf) + ruled[:, 1].min(initial=math.inf)))


def law_thickness(contacts: Contacts) -> FloatArray:
    """(laws,) the least of the passes of each declared contact, and of the extents of its surfaces [m].

    Indented by more, a body comes out on the other side of one that is thin, or has vanished in one that is thick.
    """
    least = pass_thickness(contacts)
    extents = np.where(contacts.surface_extent > 0.0, 2.0 * contacts.surface_extent, math.inf)
    sides = np.minimum(extents[contacts.pass_node], extents[contacts.pass_feature])
    thickness = np.full(len(contacts.friction), math.inf)
    np.minimum.at(thickness, contacts.pass_law, np.minimum(least, sides))
    return thickness


def pass_thickness(contacts: Contacts) -> FloatArray:
    """(passes,) least radius of a node plus least depth of what it touches [m]."""
    thickness = surface_thickness(contacts)
    return np.asarray(thickness[contacts.pass_node, 0] + thickness[contacts.pass_feature, 1])


def farthest(contacts: Contacts, points: Points) -> float:
    """Largest distance of a point of a surface from the frame of its body [m]."""
    if not len(contacts.surface_body):
        return 0.0
    nodes = _lengths(points.place[contacts.node_point]) + np.abs(contacts.node_radius)
    feature_point = contacts.feature_point[_reaching(contacts)]
    features = _lengths(points.place[feature_point].reshape(-1, points.place.shape[1]))
    moving = features[points.body[feature_point].reshape(-1) >= 0]
    radii = np.abs(contacts.feature_radius)
    mobile = nodes[points.body[contacts.node_point] >= 0]
    return float(max(mobile.max(initial=0.0), moving.max(initial=0.0) + radii.max(initial=0.0)))


def _reaching(contacts: Contacts) -> IntArray:
    """Features that are not the flat ends of cylinders, with their chords: nodes tell of these."""
    of_ends = np.zeros(len(contacts.feature_kind), bool)
    if contacts.feature_depth.ndim == 1:  # in space
        flat = contacts.feature_kind == CAP
        first = np.maximum.accumulate(np.where(flat, np.arange(len(flat)), -1))
        surface = np.searchsorted(contacts.feature_start, np.arange(len(flat)), side="right") - 1
        of_ends = (first >= 0) & (first >= contacts.feature_start[surface])
    return np.flatnonzero(~of_ends)


def _lengths(places: FloatArray) -> FloatArray:
    """Of places (k, 2) or (k, 3)."""
    return np.asarray(np.hypot(*places.T) if places.shape[1] == 2 else np.linalg.norm(places, axis=1))


def _feature_depths(contacts: Contacts) -> FloatArray:
    """(features,) how deep below its middle a node belongs to a feature: no bound below corners and sharp edges."""
    if contacts.feature_depth.ndim == 1:  # in space
        depths = contacts.feature_depth.astype(float)
        lines = np.isin(contacts.feature_kind, (EDGE, POINT))
        depths[lines & (contacts.feature_radius == 0.0)] = math.inf
        spheres = lines & (contacts.feature_radius > 0.0)
        depths[spheres] = np.minimum(depths[spheres], contacts.feature_radius[spheres])
        return depths
    depths = contacts.feature_depth[:, 1].astype(float)
    discs = (contacts.feature_kind == ARC) & (contacts.feature_radius > 0.0)
    depths[discs] = np.minimum(depths[discs], contacts.feature_radius[discs])
    depths[contacts.feature_kind == VERTEX] = math.inf
    return depths
