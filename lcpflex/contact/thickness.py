"""How far two bodies can be inside each other before the nearest way out is on the other side, from undeformed shapes.

A step in which they move by more may take one through the other: at no instant looked at is it seen inside, or it is
seen when it already belongs to the other side. Half-planes have no other side.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.contact.narrow_phase.feature import ARC, VERTEX
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Contacts, Points

__all__ = ["farthest", "law_thickness", "pass_thickness"]


def pass_thickness(contacts: Contacts) -> FloatArray:
    """(passes,) least radius of a node plus least depth of what it touches [m]; infinite for half-planes."""
    depths = _feature_depths(contacts)
    thickness = np.full(len(contacts.pass_law), math.inf)
    for w, (a, b) in enumerate(zip(contacts.pass_node, contacts.pass_feature, strict=True)):
        radii = contacts.node_radius[contacts.node_start[a] : contacts.node_start[a + 1]]
        below = depths[contacts.feature_start[b] : contacts.feature_start[b + 1]]
        if radii.size and below.size:
            thickness[w] = float(radii.min()) + float(below.min())
    return thickness


def law_thickness(contacts: Contacts) -> FloatArray:
    """(laws,) the least of the passes of each declared contact, and of the extents of its surfaces [m].

    Indented by more, a body comes out on the other side of one that is thin, or has vanished in one that is thick.
    """
    thickness = np.full(len(contacts.friction), math.inf)
    extents = np.where(contacts.surface_extent > 0.0, 2.0 * contacts.surface_extent, math.inf)
    sides = zip(contacts.pass_law, contacts.pass_node, contacts.pass_feature, pass_thickness(contacts), strict=True)
    for law, a, b, least in sides:
        thickness[law] = min(thickness[law], least, extents[a], extents[b])
    return thickness


def farthest(contacts: Contacts, points: Points) -> float:
    """Largest distance of a point of a surface from the frame of its body [m]."""
    nodes = np.hypot(*points.place[contacts.node_point].T) + contacts.node_radius
    features = np.hypot(*points.place[contacts.feature_point].reshape(-1, 2).T)
    moving = features[points.body[contacts.feature_point].reshape(-1) >= 0]
    radii = np.abs(contacts.feature_radius)
    mobile = nodes[points.body[contacts.node_point] >= 0]
    return float(max(mobile.max(initial=0.0), moving.max(initial=0.0) + radii.max(initial=0.0)))


def _feature_depths(contacts: Contacts) -> FloatArray:
    """(features,) how deep below its middle a node belongs to a feature: no bound below vertices of chains."""
    depths = contacts.feature_depth[:, 1].astype(float)
    discs = (contacts.feature_kind == ARC) & (contacts.feature_radius > 0.0)
    depths[discs] = np.minimum(depths[discs], contacts.feature_radius[discs])
    depths[contacts.feature_kind == VERTEX] = math.inf
    return depths
