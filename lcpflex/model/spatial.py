"""The compiled form of a spatial scene: the groups of :mod:`lcpflex.model.arrays` that differ from those of the plane.

Configuration q and velocity u have layouts of their own. Body b owns the entries ``place[b]:place[b+1]`` of q,

    [R (3), p (4), eta (n)]      R: origin of its frame, world axes [m]; p: unit quaternion, scalar first; eta: modal

and the entries ``dof[b]:dof[b+1]`` of u,

    [v (3), omega (3), etadot (n)]      v = Rdot, world axes [m/s]; omega: angular velocity, body axes [rad/s].

A material point that lies at x in the undeformed body is found at r = R + A(p) s, s = x + Phi eta, and the material
there is turned by A(p) exp(psi eta). Rows of W and of joint Jacobians act on u.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Signals, empty, frozen

__all__ = [
    "N_PLACE",
    "N_RIGID",
    "SpatialBodies",
    "SpatialContacts",
    "SpatialJoints",
    "SpatialLoads",
    "SpatialModel",
    "SpatialPointTable",
    "SpatialPoints",
    "bodiless_spatial_model",
    "material_points",
    "no_spatial_contacts",
]

NO_OFFSETS, NO_NUMBERS = frozen([0], np.int64), frozen([], np.int64)  # of what there is nothing of
NO_VALUES = frozen([])
N_PLACE = 7  # numbers that place a body as a rigid one, R and p; its modal coordinates come behind them
N_RIGID = 6  # its velocities, v and omega; the modal ones come behind them


class SpatialBodies(NamedTuple):
    """Inertia, stiffness and damping of all bodies, each in its own orthonormal modal basis (M_ff = I).

    Mode k of body b has the global index ``dof[b] - 6 b + k``. With < . > the integral of rho ( . ) dV:
    moment = <x>, second = <x x^T>, S_k = <Phi_k>, first_k = <x Phi_k^T>, products_lk = <Phi_l Phi_k^T>. What spin
    stiffens has G besides: its inertia is less by eta^T G_ij eta (:mod:`lcpflex.dynamics.spatial.inertia`). Bodies of
    older files have none.
    """

    dof: IntArray  # (nb + 1,) offsets into u
    place: IntArray  # (nb + 1,) offsets into q
    centred: IntArray  # (nb,) 1 where moment = 0, S = 0 and <x x Phi_k> = 0: a mean frame about the mass centre
    mass: FloatArray  # (nb,) m
    moment: FloatArray  # (nb, 3) s0 [kg m]
    second: FloatArray  # (nb, 3, 3) P0 [kg m^2]; the inertia is J0 = tr(P0) I - P0
    S: FloatArray  # (modes, 3) [kg^1/2]
    first: FloatArray  # (modes, 9) P1_k = <x Phi_k^T>, row-major: entry 3 i + j is <x_i Phi_k,j> [kg^1/2 m]
    stiffness: FloatArray  # (modes,) omega_k^2
    damping: FloatArray  # (modes,) 2 zeta_k omega_k
    cross_damping_start: IntArray  # (nb + 1,)
    cross_damping: FloatArray  # flat n x n off-diagonal part of the modal damping, row-major
    second_modes: IntArray  # (nb,) n2: products are kept between the first n2 modes of a body, else taken as 0
    products_start: IntArray  # (nb + 1,) offsets into products
    products: FloatArray  # flat (n2, n2, 9): entry [l, k, 3 i + j] is <Phi_l,i Phi_k,j>
    geometric_start: IntArray = NO_OFFSETS  # (nb + 1,) offsets into geometric; equal where G = 0
    geometric: FloatArray = NO_VALUES  # flat (n, n, 6): [l, k] of G_xx, G_yy, G_zz, G_yz, G_zx, G_xy, symmetric


class SpatialPoints(NamedTuple):
    """Material points: undeformed place in the body frame and the mode shapes there."""

    body: IntArray  # (np,) -1 for the ground
    place: FloatArray  # (np, 3) x, undeformed, body frame
    start: IntArray  # (np + 1,) offsets into phi and psi
    phi: FloatArray  # (total, 3) displacement of each mode of the body
    psi: FloatArray  # (total, 3) small rotation of the material at the point, of each mode


def material_points(
    body: npt.ArrayLike, place: npt.ArrayLike, start: npt.ArrayLike, phi: npt.ArrayLike, psi: npt.ArrayLike
) -> SpatialPoints:
    """Points of these arrays, copied where they have other types.

    They can be written to, and so be points that a kernel makes: of one type for all that take points. Nobody writes to
    those of a model.
    """
    return SpatialPoints(
        body=np.array(body, np.int64),
        place=np.array(place, np.float64).reshape(-1, 3),
        start=np.array(start, np.int64),
        phi=np.array(phi, np.float64).reshape(-1, 3),
        psi=np.array(psi, np.float64).reshape(-1, 3),
    )


class SpatialJoints(NamedTuple):
    """Bilateral constraints phi(q, t) = 0, each of a relative coordinate: see :mod:`lcpflex.kinematics.spatial`."""

    point: IntArray  # (nj, 2) material points P on body i and Q on body j
    row: IntArray  # (nj + 1,) offsets of the rows of each joint
    kind: IntArray  # (rows,) relative coordinate
    axis: FloatArray  # (rows, 3) its direction, fixed in the material at Q (of a component: in the world)
    on_p: FloatArray  # (rows, 3) what is fixed in the material at P: see the relative coordinates
    on_q: FloatArray  # (rows, 3) and a second direction at Q
    rest: FloatArray  # (rows,) value without a motion [m] or [rad]
    signal: IntArray  # (rows,) prescribed motion, -1: none


class SpatialLoads(NamedTuple):
    """Gravity, spring-dampers, forces and torques."""

    gravity: FloatArray  # (3,)
    spring_kind: IntArray  # (nk,) relative coordinate that resists
    spring_point: IntArray  # (nk, 2) P, Q
    spring_axis: FloatArray  # (nk, 3) as of joints
    spring_on_p: FloatArray  # (nk, 3)
    spring_on_q: FloatArray  # (nk, 3)
    spring_value: FloatArray  # (nk, 3) stiffness, damping, value without force
    force_kind: IntArray  # (nf,) force in world axes or in those of the material, torque in world axes or these
    force_point: IntArray  # (nf,)
    force_signal: IntArray  # (nf, 3) signals of the components


class SpatialContacts(NamedTuple):
    """Surfaces, their pairing, and the law of each declared contact. See :mod:`lcpflex.contact.spatial`.

    A surface holds *nodes* (material points with a radius >= 0) and *features* (what touches: facets, edges, vertices
    and spheres, planes, rims; the kinds are in :mod:`lcpflex.contact.spatial.kinds`).
    """

    # surfaces
    surface_kind: IntArray  # (ns,)
    surface_body: IntArray  # (ns,) -1: ground
    surface_center: FloatArray  # (ns, 3) centre of the bounding sphere, body frame
    surface_extent: FloatArray  # (ns,) its radius [m]; infinite for planes
    surface_deflection: FloatArray  # (ns, largest mode count) greatest |Phi_k| over the surface
    node_start: IntArray  # (ns + 1,) offsets into the nodes
    node_point: IntArray  # (nodes,) material point
    node_radius: FloatArray  # (nodes,) [m]
    node_normal: FloatArray  # (nodes, 3) mean outward normal, undeformed, body frame; 0 of round and single ones
    feature_start: IntArray  # (ns + 1,) offsets into the features
    feature_kind: IntArray  # (features,)
    feature_point: IntArray  # (features, 3) material points; those that a kind does not have repeat the first
    feature_radius: FloatArray  # (features,) of edges and spheres; < 0: touched from inside [m]
    feature_depth: FloatArray  # (features,) how deep below it a node belongs to it [m]; infinite for planes
    feature_neighbour: IntArray  # (features, 3) facets: across the hollow sides opposite a, b, c; of edges; -1: none
    # of a polygon: its number first; of edges of meshes the third one is no facet, but tells whether they are sharp
    fan_start: IntArray  # (features + 1,) offsets into the fans
    fan: IntArray  # material points at the other ends of all edges of a vertex
    # boxes about the features of each surface, undeformed, in the order of a search; see compile.spatial.feature_tree
    box_start: IntArray  # (ns + 1,) offsets into the boxes
    box: FloatArray  # (boxes, 6) [m]
    box_skip: IntArray  # (boxes,) where the search goes on behind a box that is missed
    box_leaf: IntArray  # (boxes, 2) range of box_feature
    box_feature: IntArray  # (features but polygons,)
    # passes: nodes of one surface, or its rims or edges, against features of another
    pass_mode: IntArray  # (passes,) see bodies.spatial.surface.Pass
    pass_node: IntArray  # (passes,) surface
    pass_feature: IntArray  # (passes,) surface
    pass_law: IntArray  # (passes,) declared contact
    # declared contacts
    friction: FloatArray  # (laws,) mu
    restitution: FloatArray  # (laws,) e_N
    tangential_restitution: FloatArray  # (laws,) e_T
    # the first surfaces, between which a rule holds, as in the plane; empty where none does
    rule_rank: IntArray  # (surfaces of the rule,)
    rule_law: IntArray  # (1,)
    rule_pass: IntArray  # (1,)
    barred_start: IntArray  # (surfaces of the rule + 1,)
    barred: IntArray
    # (declared contacts, 2) their surfaces as they were declared: forces are those on the body of the first
    law_surface: IntArray = frozen([], np.int64, columns=2)
    # (nodes,) least cosine between node_normal and the reversed normal of what it touches, in passes of two sides
    node_facing: FloatArray = frozen([])
    # faces of convex polyhedra, undeformed, in the frame of their body; see compile.spatial.polygons
    polygon_start: IntArray = NO_OFFSETS  # (ns + 1,) offsets into the polygons
    polygon_feature: IntArray = NO_NUMBERS  # (polygons,)
    polygon_plane: FloatArray = frozen([], columns=4)  # (polygons, 4) outward normal n, and c [m] of n.x = c
    side_start: IntArray = NO_OFFSETS  # (polygons + 1,) offsets into the sides
    side_node: IntArray = NO_NUMBERS  # (sides,) node where it begins; counter-clockwise, seen from outside
    side_edge: IntArray = NO_NUMBERS  # (sides,) feature
    side_beside: IntArray = NO_NUMBERS  # (sides,) polygon behind it
    side_across: IntArray = NO_NUMBERS  # (sides,) material point of its polygon that is farthest from it
    corner_start: IntArray = NO_OFFSETS  # (nodes + 1,) offsets into the next
    corner_polygon: IntArray = NO_NUMBERS  # polygons about each node
    ridge_start: IntArray = NO_OFFSETS  # (ns + 1,) offsets into the edges between two polygons
    ridge_edge: IntArray = NO_NUMBERS  # (ridges,) feature
    ridge_polygon: IntArray = frozen([], np.int64, columns=2)  # (ridges, 2) beside it
    # open faces of solids; see compile.spatial.face_areas
    cell_start: IntArray = NO_OFFSETS  # (cells + 1,) offsets into the next
    cell_point: IntArray = NO_NUMBERS  # material points of each face of an element
    feature_cell: IntArray = NO_NUMBERS  # (features,) the one that a facet is a part of; -1: it is one itself
    # (nodes,) area that the force on a node is shared out over [m^2]; 0 where it makes no pressure
    node_area: FloatArray = NO_VALUES
    # (nodes, 6) V of the samples that a node is the mean of [m^2]: xx, yy, zz, yz, xz, xy, undeformed, body frame
    node_spread: FloatArray = frozen([], columns=6)
    node_share: FloatArray = NO_VALUES  # (nodes,) part of a face that is about a node, 1 of those of other surfaces
    area_start: IntArray = NO_OFFSETS  # (nodes + 1,) offsets into the next two
    area_sample: IntArray = NO_NUMBERS  # samples that a node is the mean of
    area_share: FloatArray = NO_VALUES  # [m^2] of them in it
    sample_start: IntArray = NO_OFFSETS  # (samples + 1,) offsets into the next two
    sample_point: IntArray = NO_NUMBERS  # material points that make a sample
    sample_weight: FloatArray = NO_VALUES
    sample_normal: FloatArray = frozen([], columns=3)  # (samples, 3) outward, undeformed, body frame
    # Phi of the nodes of surfaces that have several, each [mode, x y z, node]; see contact.spatial.node_shapes
    shape_start: IntArray = NO_OFFSETS  # (ns + 1,) offsets into the next
    node_shape: FloatArray = NO_VALUES


def no_spatial_contacts() -> SpatialContacts:
    """Of a scene without contacts."""
    none, few = frozen([], np.int64), frozen([0], np.int64)
    real, three, threes = frozen([]), frozen([], columns=3), frozen([], np.int64, columns=3)
    return SpatialContacts(
        surface_kind=none,
        surface_body=none,
        surface_center=three,
        surface_extent=real,
        surface_deflection=frozen([], columns=1),
        node_start=few,
        node_point=none,
        node_radius=real,
        node_normal=three,
        feature_start=few,
        feature_kind=none,
        feature_point=threes,
        feature_radius=real,
        feature_depth=real,
        feature_neighbour=threes,
        fan_start=few,
        fan=none,
        box_start=few,
        box=frozen([], columns=6),
        box_skip=none,
        box_leaf=frozen([], np.int64, columns=2),
        box_feature=none,
        pass_mode=none,
        pass_node=none,
        pass_feature=none,
        pass_law=none,
        friction=real,
        restitution=real,
        tangential_restitution=real,
        rule_rank=none,
        rule_law=none,
        rule_pass=none,
        barred_start=few,
        barred=none,
    )


class SpatialModel(NamedTuple):
    """A compiled spatial scene."""

    bodies: SpatialBodies
    points: SpatialPoints
    signals: Signals
    joints: SpatialJoints
    loads: SpatialLoads
    contacts: SpatialContacts


def bodiless_spatial_model(
    n: int,
    nq: int,
    n_joint: int,
    friction: npt.ArrayLike,
    restitution: npt.ArrayLike,
    tangential_restitution: npt.ArrayLike,
) -> SpatialModel:
    """A model of n velocities and nq coordinates in one block, n_joint joint rows and the given contact laws.

    Without any geometry; its array types are those of every other one.
    """
    none, few, real = frozen([], np.int64), frozen([0], np.int64), frozen([])
    pairs, three = frozen([], np.int64, columns=2), frozen([], columns=3)
    body = SpatialBodies(
        dof=frozen([0, n], np.int64),
        place=frozen([0, nq], np.int64),
        centred=none,
        mass=real,
        moment=three,
        second=np.reshape(real, (0, 3, 3)),
        S=three,
        first=frozen([], columns=9),
        stiffness=real,
        damping=real,
        cross_damping_start=frozen([0, 0], np.int64),
        cross_damping=real,
        second_modes=none,
        products_start=frozen([0, 0], np.int64),
        products=real,
        geometric_start=frozen([0, 0], np.int64),
    )
    return SpatialModel(
        bodies=body,
        points=material_points(none, three, few, three, three),
        signals=empty(Signals),
        joints=SpatialJoints(pairs, frozen([0, n_joint], np.int64), none, three, three, three, real, none),
        loads=SpatialLoads(
            frozen([0.0, 0.0, 0.0]), none, pairs, three, three, three, three, none, none,
            frozen([], np.int64, columns=3),
        ),
        contacts=no_spatial_contacts()._replace(
            friction=frozen(friction),
            restitution=frozen(restitution),
            tangential_restitution=frozen(tangential_restitution),
        ),
    )  # fmt: skip


class SpatialPointTable:
    """Collects material points while a scene is compiled; hands out their indices."""

    def __init__(self) -> None:
        self._body: list[int] = []
        self._place: list[FloatArray] = []
        self._start: list[int] = [0]
        self._phi: list[FloatArray] = []
        self._psi: list[FloatArray] = []

    def add(self, body: int, place: npt.ArrayLike, phi: npt.ArrayLike, psi: npt.ArrayLike) -> int:
        """Register a point of ``body``; phi (n, 3) and psi (n, 3) are its mode shapes."""
        self._body.append(body)
        self._place.append(np.asarray(place, dtype=float))
        self._phi.append(np.asarray(phi, dtype=float).reshape(-1, 3))
        self._psi.append(np.asarray(psi, dtype=float).reshape(-1, 3))
        self._start.append(self._start[-1] + len(self._phi[-1]))
        return len(self._body) - 1

    def compile(self) -> SpatialPoints:
        """All points so far."""
        return material_points(
            self._body,
            np.reshape(self._place, (-1, 3)),
            self._start,
            np.concatenate([np.zeros((0, 3)), *self._phi]),
            np.concatenate([np.zeros((0, 3)), *self._psi]),
        )
