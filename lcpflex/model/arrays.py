"""The compiled form of a scene: read-only flat arrays that every kernel shares.

``Scene.compile()`` makes a :class:`Model`; nothing below it ever sees a builder object. Configuration
q and velocity u of a planar scene have one layout: body b owns the entries ``dof[b]:dof[b+1]``, which are
``[x, y, angle, q_1 ... q_n]``. The ground is body -1 and owns none.

Generalised forces, and each row of W or of a joint Jacobian, are stored by body block, because a
contact or joint touches two bodies at most: a row r is ``rows[r, 0, :]`` for body ``row_body[r, 0]``
and ``rows[r, 1, :]`` for body ``row_body[r, 1]`` (-1: no block), each padded to the width of the largest body.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack, with_parts

__all__ = [
    "Axis",
    "Bodies",
    "Contacts",
    "Joints",
    "Loads",
    "Model",
    "Points",
    "PointTable",
    "Signals",
    "OPEN",
    "SLIP",
    "STICK",
    "bodiless_model",
    "changed",
    "empty",
    "frozen",
    "refrozen",
    "replaced",
]

T = TypeVar("T")
N = TypeVar("N", bound=tuple[Any, ...])

# what arrays hold, row by row; :func:`empty` makes one of no rows
Offsets: TypeAlias = IntArray  # of each thing's entries among those of all, one more than there are things
IndexPairs: TypeAlias = IntArray
Rows: TypeAlias = FloatArray  # of any length
Pairs: TypeAlias = FloatArray
Triples: TypeAlias = FloatArray
Quadruples: TypeAlias = FloatArray

GROUND = -1
OPEN, STICK, SLIP = 0, 1, 2  # states of a contact


def frozen(values: npt.ArrayLike, dtype: npt.DTypeLike = np.float64, columns: int = 0) -> npt.NDArray[Any]:
    """A read-only C-contiguous copy; ``columns`` shapes an empty list as (0, columns)."""
    array = np.array(values, dtype=dtype, order="C")
    if columns:
        array = array.reshape(-1, columns)
    array.setflags(write=False)
    return array


class Bodies(NamedTuple):
    """Inertia, stiffness and damping of all bodies, each in its own orthonormal modal basis (M_ff = I).

    Mode k of body b has the global index ``dof[b] - 3 b + k``. With < . > the integral of rho ( . ) dV:
    moment = <x> [kg m], S = <Phi> [kg^1/2], a = <Phi^T x>, c = <Phi^T J x>, coupling D = <Phi^T J^T Phi> (skew).
    """

    dof: IntArray  # (nb + 1,) offsets into q and u
    mass: FloatArray  # (nb,) m
    inertia: FloatArray  # (nb,) I0 = <x.x> about the frame's origin
    moment: Pairs  # (nb, 2) s0
    S: Pairs  # (modes, 2)
    a: FloatArray  # (modes,)
    c: FloatArray  # (modes,)
    stiffness: FloatArray  # (modes,) omega_k^2
    damping: FloatArray  # (modes,) 2 zeta_k omega_k, the diagonal of the modal damping matrix
    coupling_start: IntArray  # (nb + 1,) offsets into coupling; equal where D = 0
    coupling: FloatArray  # flat n x n matrices D, row-major
    cross_damping_start: IntArray  # (nb + 1,)
    cross_damping: FloatArray  # flat n x n off-diagonal part of the modal damping, row-major
    geometric_start: IntArray  # (nb + 1,) offsets into geometric; equal where G = 0
    geometric: FloatArray  # flat n x n matrices G of stiffening by rotation, symmetric, row-major
    # of bodies that get shorter as they bend (see dynamics.shortening), which of their own modes are which; else none
    axial_start: IntArray  # (nb + 1,) offsets into axial_mode
    axial_mode: IntArray
    bending_start: IntArray  # (nb + 1,) offsets into bending_mode
    bending_mode: IntArray
    shortening_start: IntArray  # (nb + 1,) offsets into shortening
    shortening: FloatArray  # flat k x k matrices G_a, one for each axial mode, symmetric, row-major


class Axis(NamedTuple):
    """The axis of a beam: what its axial force is compared with, at stations along it. No kernel takes it."""

    length: float  # [m]
    euler: float  # pi^2 E I / L^2, the buckling load of the beam with pinned ends [N]
    station: FloatArray  # (k,) [m], ascending from 0 to the length
    slope: FloatArray  # (k, n) w' of each mode [kg^-1/2]
    spin: FloatArray  # (k,) tension that its stiffness counts with at 1 rad/s [N s^2]
    given: FloatArray  # (k,) constant tension that its stiffness counts with [N]
    actual: bool  # whether its stiffness counts with the axial force of the simulation


class Points(NamedTuple):
    """Material points: undeformed place in the body frame and the mode shapes there."""

    body: IntArray  # (np,) -1 for the ground
    place: Pairs  # (np, 2) x, undeformed, body frame
    start: Offsets  # (np + 1,) offsets into phi and psi
    phi: Pairs  # (total, 2) displacement shape of each mode of the body
    psi: FloatArray  # (total,) rotation of the material at the point, of each mode


class Signals(NamedTuple):
    """Scalar functions of time: cubic pieces, harmonics, values from outside, or compiled functions of a user's.

    kind 0: pieces ``breaks[first:last]`` with the coefficients of powers 3, 2, 1, 0 of (t - break), constant outside;
    the last row holds the end value;
    kind 1: mean + amplitude sin(omega t + phase), the four in coefficients[first];
    kind 2: external: value, first and second derivative are read from ``external[slot]``, slot = first;
    kind 3: function at ``address[first]``: its component ``last``, or value, rate and acceleration where last = -1.
    """

    kind: IntArray  # (ns,)
    first: IntArray  # (ns,)
    last: IntArray  # (ns,)
    breaks: FloatArray
    coefficients: Quadruples  # (total, 4)
    address: IntArray = frozen([], np.int64)  # of compiled functions
    stops: FloatArray = frozen([])  # increasing instants [s] at which steps with error control end
    longest: FloatArray = frozen([])  # (0,) or (1,) longest step [s] that looks at all of them often enough


class Joints(NamedTuple):
    """Bilateral constraints phi(q, t) = 0, each of a relative coordinate: see :mod:`lcpflex.kinematics.relative`."""

    point: IndexPairs  # (nj, 2) material points P on body i and Q on body j
    row: IntArray  # (nj + 1,) offsets of the rows of each joint
    kind: IntArray  # (rows,) relative coordinate
    axis: Pairs  # (rows, 2) its direction
    rest: FloatArray  # (rows,) value without a motion [m] or [rad]
    signal: IntArray  # (rows,) prescribed motion, -1: none


class Loads(NamedTuple):
    """Gravity, spring-dampers, forces and torques. See :mod:`lcpflex.dynamics.applied_forces`."""

    gravity: FloatArray  # (2,)
    spring_kind: IntArray  # (nk,) relative coordinate that resists
    spring_point: IndexPairs  # (nk, 2) P, Q
    spring_axis: Pairs  # (nk, 2) direction of the coordinate
    spring_value: Triples  # (nk, 3) stiffness, damping, value without force
    force_kind: IntArray  # (nf,) force in world axes or in those of the material, or torque
    force_point: IntArray  # (nf,)
    force_signal: IndexPairs  # (nf, 2) signals of the components (torque: first only)


class Contacts(NamedTuple):
    """Surfaces, their pairing, and the law of each declared contact. See :mod:`lcpflex.contact`.

    A surface holds *nodes* (material points with a radius >= 0) and *features* (what nodes touch).
    The kinds of features, segments, arcs and vertices of chains, are in :mod:`lcpflex.contact.narrow_phase`.
    """

    # surfaces
    node_start: Offsets  # (ns + 1,)
    node_point: IntArray  # (nodes,)
    node_radius: FloatArray  # (nodes,)
    node_normal: Pairs  # (nodes, 2) mean outward normal, body frame; zero: any direction may touch
    node_span: Pairs  # (nodes, 2) start angle and extent of the part of its circle that may touch, body frame
    feature_start: Offsets  # (ns + 1,)
    feature_kind: IntArray  # (features,)
    feature_point: IndexPairs  # (features, 2) material points a, b (b = a for arcs)
    feature_radius: FloatArray  # (features,) signed
    feature_sense: FloatArray  # (features,) +1 convex, -1 hole
    feature_depth: Triples  # (features, 3) how deep below s = 0, 1/2, 1 a node belongs to it, linear between [m]
    feature_span: Pairs  # (features, 2) range of s, endless at hollow corners; arcs: start angle and extent
    feature_neighbour: IndexPairs  # (features, 2) segments before and behind on the chain, -1: none
    surface_block: Offsets  # (ns + 1,) offsets of the blocks of features of each surface
    block_start: Offsets  # (blocks + 1,) offsets of the features of each block
    block_circle: Quadruples  # (blocks, 4) centre, radius of a circle about them, and of one about what is below, too
    block_height: Triples  # (blocks, 3) n and greatest n.x, where all look about the way n; else 0
    surface_body: IntArray  # (ns,)
    surface_center: Pairs  # (ns, 2) centre of the bounding circle, body frame
    surface_extent: FloatArray  # (ns,) its radius; infinite for half-planes
    surface_deflection: Rows  # (ns, largest mode count) greatest |Phi_k| over the surface, to bound its deformation
    # passes: nodes of one surface against features of another
    pass_node: IntArray  # (passes,) surface
    pass_feature: IntArray  # (passes,) surface
    pass_law: IntArray  # (passes,) declared contact
    # declared contacts
    friction: FloatArray  # (laws,) mu
    restitution: FloatArray  # (laws,) e_N
    tangential_restitution: FloatArray  # (laws,) e_T
    # the first surfaces, between which a rule holds; see :mod:`lcpflex.contact.rule_pairs`; empty where none does
    rule_rank: IntArray = frozen([], np.int64)  # (surfaces of the rule,) by their kinds: the lower is the node side
    rule_law: IntArray = frozen([], np.int64)  # (1,) law of the rule, behind those of declared contacts
    rule_pass: IntArray = frozen([], np.int64)  # (1,) pass before which those of the rule come
    barred_start: IntArray = frozen([0], np.int64)  # (surfaces of the rule + 1,) offsets into barred
    barred: IntArray = frozen([], np.int64)  # later surfaces without a contact by the rule, ascending for each


class Model(NamedTuple):
    """A compiled scene."""

    bodies: Bodies
    points: Points
    signals: Signals
    joints: Joints
    loads: Loads
    contacts: Contacts


def refrozen(values: T) -> T:
    """A named tuple of arrays, and of such tuples, made read-only again: copies and what is unpickled are not."""
    for value in values if isinstance(values, tuple) else ():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        else:
            refrozen(value)
    return values


def changed(kind: type[N], values: N, **changes: Any) -> N:
    """Named arrays of a kind, packed or not, some of them replaced."""
    fields: Any = kind
    taken = {name: changes.get(name, getattr(values, name)) for name in fields._fields}
    return kind(**{
        name: frozen(value, value.dtype) if name in changes and isinstance(value, np.ndarray) else value
        for name, value in taken.items()
    })  # fmt: skip


def replaced(values: N, **changes: Any) -> N:
    """Named arrays, packed, some of them replaced: of the plane or of space, read-only where they were."""
    parts = {}
    for name, value in changes.items():
        if isinstance(value, np.ndarray):
            part = frozen(value, value.dtype)
            part.setflags(write=getattr(values, name).flags.writeable)
            parts[name] = part
        else:
            parts[name] = pack(value)
    return with_parts(pack(values), parts)


class PointTable:
    """Collects material points while a scene is compiled; hands out their indices."""

    def __init__(self) -> None:
        self._body: list[int] = []
        self._place: list[tuple[float, float]] = []
        self._start: list[int] = [0]
        self._phi: list[FloatArray] = []
        self._psi: list[FloatArray] = []

    def add(self, body: int, place: npt.ArrayLike, phi: FloatArray, psi: FloatArray) -> int:
        """Register a point of ``body``; phi (n, 2) and psi (n,) are its mode shapes."""
        x, y = np.asarray(place, dtype=float)
        self._body.append(body)
        self._place.append((float(x), float(y)))
        self._phi.append(np.asarray(phi, dtype=float).reshape(-1, 2))
        self._psi.append(np.asarray(psi, dtype=float).reshape(-1))
        self._start.append(self._start[-1] + len(self._psi[-1]))
        return len(self._body) - 1

    def compile(self) -> Points:
        """All points so far as read-only arrays."""
        phi = np.concatenate([np.zeros((0, 2)), *self._phi])
        psi = np.concatenate([np.zeros(0), *self._psi])
        return Points(
            body=frozen(self._body, np.int64),
            place=frozen(self._place, columns=2),
            start=frozen(self._start, np.int64),
            phi=frozen(phi, columns=2),
            psi=frozen(psi),
        )


EMPTY = {
    "IntArray": frozen([], np.int64),
    "FloatArray": frozen([]),
    "Offsets": frozen([0], np.int64),
    "IndexPairs": frozen([], np.int64, columns=2),
    "Rows": frozen([], columns=1),
    "Pairs": frozen([], columns=2),
    "Triples": frozen([], columns=3),
    "Quadruples": frozen([], columns=4),
}


def empty(group: type[N], **given: npt.NDArray[Any]) -> N:
    """A group of the arrays of a model, of no things at all but for the ``given`` arrays."""
    declared = {name: hint.__forward_arg__ for name, hint in group.__annotations__.items()}
    return group(**{name: EMPTY[kind] for name, kind in declared.items()} | given)


def bodiless_model(
    n: int, n_joint: int, friction: npt.ArrayLike, restitution: npt.ArrayLike, tangential_restitution: npt.ArrayLike
) -> Model:
    """A model of n coordinates in one block, n_joint joint rows and the given contact laws, without any geometry.

    Its array types are those of every other model, so that the same compiled kernels serve it.
    """
    parts = ("coupling", "cross_damping", "geometric", "axial", "bending", "shortening")
    nowhere = dict.fromkeys((f"{part}_start" for part in parts), frozen([0, 0], np.int64))
    return Model(
        bodies=empty(Bodies, dof=frozen([0, n], np.int64), **nowhere),
        points=empty(Points),
        signals=empty(Signals),
        joints=empty(Joints, row=frozen([0, n_joint], np.int64)),
        loads=empty(Loads, gravity=frozen([0.0, 0.0])),
        contacts=empty(
            Contacts,
            friction=frozen(friction),
            restitution=frozen(restitution),
            tangential_restitution=frozen(tangential_restitution),
        ),
    )
