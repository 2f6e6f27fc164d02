"""The body of space: a floating frame with n >= 0 modal coordinates; n = 0 is a rigid body.

A material point that lies at x in the undeformed body (body frame) is found at

    r = R + A (x + Phi(x) eta)       R, A: place and rotation of the frame,  eta (n,): modal coordinates

With < . > = integral of rho ( . ) dV a body is its inertia integrals

    m = <1>,  s0 = <x>,  P0 = <x x^T>,  S_k = <Phi_k>,  P1_k = <x Phi_k^T>,  P2_lk = <Phi_l Phi_k^T>

in a basis with <Phi_l . Phi_k> = 1 or 0 and a diagonal stiffness. The inertia about the origin is J = tr(P0) I - P0.
Sources: Shabana, Dynamics of Multibody Systems; Zwoelfer & Gerstmayr (2020), nodal-based floating frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from lcpflex.basics.arguments import absent, array_of, mapping_of, positive, whole_number
from lcpflex.basics.restored import restore
from lcpflex.bodies.body import FidelityLevel, Resolution, Statics
from lcpflex.bodies.spatial.checks import check_inertia, check_products, even
from lcpflex.bodies.spatial.face_nodes import FaceNodes
from lcpflex.bodies.spatial.shapes import SHAPES, Shape
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.recovery import MeshShapes, SpatialLineShapes

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from lcpflex.bodies.reduction.again import Reduction

__all__ = ["MeshModes", "SpatialBody", "SpatialPoint"]

# What may be omitted, and is there once the body is made.
FloatArrayOrNone: TypeAlias = FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class SpatialPoint:
    """A point of a spatial body that is not placed in a scene yet.

    Attributes
    ----------
    place : (3,) undeformed place x in the body frame [m]
    phi : (n, 3) displacement of each mode at the point [kg^-1/2]
    psi : (n, 3) small rotation of the material at the point, of each mode [kg^-1/2 / m]
    turns : whether psi is known; False for nodes on one line, whose displacements tell no rotation about it (psi is
        zeros then): forces act there, and joints that leave all rotations free
    made_at : what tells it of the mesh: a name, a place in its coordinates [m], or nodes; None where nothing does
    spread : numbers and weights of the nodes of a mesh whose mean it is, on which forces at it are spread; None of the
        material at its place
    """

    place: FloatArray
    phi: FloatArray
    psi: FloatArray
    turns: bool = True
    made_at: Any = field(default=None, repr=False)
    spread: tuple[IntArray, FloatArray] | None = field(default=None, repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class MeshModes:
    """The modes of a body on its mesh, by which a deformation is carried over to other modes of the same mesh.

    mass : (f, f) sparse; shapes : (f, n) displacements of the modes, M-orthonormal
    """

    mass: csc_matrix[Any]
    shapes: FloatArray


MappingOrNone: TypeAlias = Mapping[str, SpatialPoint]
FacesOrNone: TypeAlias = Mapping[str, FaceNodes]
CallableOrNone: TypeAlias = Callable[[float, float, float], SpatialPoint]


@dataclass(frozen=True, slots=True, eq=False)
class SpatialBody:
    """A body of space in its own orthonormal modal basis; the makers of bodies give one, a user may write one.

    Attributes
    ----------
    mass : m = <1> [kg]
    second : (3, 3) P0 = <x x^T>, about the origin of the frame [kg m^2]; made of ``inertia`` if omitted
    inertia : (3, 3) J = tr(P0) I - P0, about the origin of the frame [kg m^2]; made of ``second`` if omitted
    moment : (3,) s0 = <x> [kg m]; zero if omitted: the origin is the mass centre
    stiffness : (n,) squares of the natural angular frequencies [rad^2/s^2]; none if omitted: a rigid body
    damping : (n,) diagonal of the modal damping matrix, 2 zeta omega [1/s]; zeros if omitted
    S : (n, 3) <Phi_k> [kg^1/2]; zeros if omitted
    first : (n, 9) P1_k = <x Phi_k^T>, row by row: entry 3 i + j is <x_i Phi_k,j> [kg^1/2 m]; zeros if omitted
    products : (n2, n2, 9) entry [l, k, 3 i + j] is <Phi_l,i Phi_k,j> [-], of the first n2 <= n modes: how the inertia
        depends on their coordinates in second order; taken as zero for the others. None: n2 = 0
    cross_damping : (n, n) off-diagonal part of the modal damping matrix [1/s]; None where it is zero
    geometric : (6, n, n) G_xx, G_yy, G_zz, G_yz, G_zx, G_xy, each symmetric [-]: J is less by eta^T G_ij eta, so that
        spin adds the stiffness sum_ij omega_i omega_j G_ij; None without stiffening
    points : named material points
    locate : the material point at a place (x, y, z) of the body frame; raises :class:`ModelError` off the body. None:
        any place of a rigid body, and the named points alone of a flexible one
    nodes : the material point that stands for some nodes of a mesh, by their numbers and weights; None without a mesh
    shape : what the body looks like, one of :mod:`lcpflex.bodies.spatial.shapes`; None where that is not known
    origin : (3,) place of the frame's origin in the coordinates the body was given in [m]: meshes and hulls are moved
        to their mass centre
    resolution : what the mesh can resolve; None where it has none
    residual_modes : how many of the last coordinates are residual modes, the static response at interfaces
    contact_modes : how many of these interfaces of contacts have added; where there are some, ``MasslessBoundary``
        makes residual modes static that joints and springs do not need
    recovery : what its section forces or stresses are recovered from; None where they cannot be
    reduction : by how many modes of its mesh it was made, and what makes it with more; None where that is not known
    fidelity_levels : gives the same body at other fidelities, from rigid to the whole mesh; None where only this one is
        known
    mesh_modes : its modes on its mesh; None where it has none
    statics : static compliance of its whole mesh, (6, 6) by unit forces and moments; None where that is not known
    faces : named parts of the surface of its mesh, whose facets touch other surfaces

    Raises
    ------
    ModelError
        For NaN, wrong shapes, and inertia that no distribution of mass can have: P0 - s0 s0^T / m must be positive
        semidefinite (the principal moments obey the triangle inequality), to 1e-6 of its trace. And for mass on a
        line or in a point, where nothing resists a rotation: give it a radius.
    """

    mass: float
    second: FloatArrayOrNone = None  # type: ignore[assignment]  # what is omitted is filled in
    inertia: FloatArrayOrNone = None  # type: ignore[assignment]
    moment: FloatArrayOrNone = None  # type: ignore[assignment]
    stiffness: FloatArrayOrNone = None  # type: ignore[assignment]
    damping: FloatArrayOrNone = None  # type: ignore[assignment]
    S: FloatArrayOrNone = field(default=None, repr=False)  # type: ignore[arg-type]
    first: FloatArrayOrNone = field(default=None, repr=False)  # type: ignore[arg-type]
    products: FloatArrayOrNone = field(default=None, repr=False)  # type: ignore[arg-type]
    cross_damping: FloatArray | None = field(default=None, repr=False)
    geometric: FloatArray | None = field(default=None, repr=False)
    points: MappingOrNone = field(default=None, repr=False)  # type: ignore[arg-type]
    locate: CallableOrNone = field(default=None, repr=False)  # type: ignore[assignment]
    nodes: Callable[[Sequence[int] | int, Sequence[float] | None], SpatialPoint] | None = field(
        default=None, repr=False
    )
    shape: Shape | None = field(default=None, repr=False)
    origin: FloatArrayOrNone = None  # type: ignore[assignment]
    resolution: Resolution | None = field(default=None, repr=False)
    residual_modes: int = 0
    contact_modes: int = 0
    recovery: SpatialLineShapes | MeshShapes | None = field(default=None, repr=False)
    reduction: Reduction[SpatialBody] | None = field(default=None, repr=False)
    fidelity_levels: Callable[[], tuple[FidelityLevel, ...]] | None = field(default=None, repr=False)
    mesh_modes: MeshModes | None = field(default=None, repr=False)
    statics: Statics | None = field(default=None, repr=False)
    faces: FacesOrNone = field(default=None, repr=False)  # type: ignore[arg-type]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", positive("mass", self.mass))
        n = 0 if self.stiffness is None else len(array_of("stiffness", self.stiffness, (-1,)))
        omitted = {"stiffness": np.zeros(0), "damping": np.zeros(n), "S": np.zeros((n, 3)), "first": np.zeros((n, 9)),
                   "products": np.zeros((0, 0, 9)), "moment": np.zeros(3), "origin": np.zeros(3),
                   "points": {}, "faces": {}, "locate": _nowhere if n else rigid_point}  # fmt: skip
        for name, value in omitted.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)
        shapes: dict[str, tuple[int, ...]] = {
            "moment": (3,), "origin": (3,), "stiffness": (n,), "damping": (n,), "S": (n, 3), "first": (n, 9),
            "products": (-1, -1, 9), "cross_damping": (n, n), "geometric": (6, n, n),
            "second": (3, 3), "inertia": (3, 3),
        }  # fmt: skip
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, array_of(name, value, shape))
        self._keep_second()
        check_inertia(self.mass, self.moment, self.second, self.S, self.first)
        object.__setattr__(self, "products", check_products(self.products, n))
        if n and (self.stiffness.min() <= 0.0 or self.damping.min() < 0.0):
            raise ModelError("stiffness, damping: expected elastic modes only, stiffness > 0 and damping >= 0")
        if self.cross_damping is not None and np.abs(np.diag(self.cross_damping)).any():
            raise ModelError("cross_damping: its diagonal belongs into damping, expected zeros there")
        if self.geometric is not None and not np.array_equal(self.geometric, self.geometric.transpose(0, 2, 1)):
            raise ModelError("geometric: a matrix that was given is not symmetric, expected G_ij = G_ij^T")
        for name, most in (("residual_modes", n), ("contact_modes", self.residual_modes)):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), 0, most))
        self._check_others(n)
        if not isinstance(self.mesh_modes, MeshModes | None):
            raise ModelError(
                f"mesh_modes: {shown(self.mesh_modes)} was given, expected None, or that of a reduced body"
            )
        if self.statics is not None and not callable(getattr(self.statics, "compliance", None)):
            raise ModelError(f"statics: {shown(self.statics)} was given, expected None, or those of a reduced body")
        if self.reduction is not None:
            from lcpflex.bodies.reduction.again import sealed_reduction  # which bodies given by hand do without

            object.__setattr__(self, "reduction", sealed_reduction(self.reduction, self))

    def _keep_second(self) -> None:
        """P0 and J, of which one at least was given."""
        if self.second is None and self.inertia is None:
            raise ModelError("inertia, second: neither was given, expected one of the two, (3, 3)")
        if self.second is None:
            J = even("inertia", self.inertia)
            found = 0.5 * np.trace(J) * np.eye(3) - J
        else:
            found = even("second", self.second)
            J = np.trace(found) * np.eye(3) - found
            if self.inertia is not None and np.abs(J - self.inertia).max() > 1e-9 * np.abs(J).max():
                raise ModelError(
                    "inertia, second: both were given and differ, expected J = tr(P0) I - P0, or one of them"
                )
        for name, value in (("second", found), ("inertia", J)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def _check_others(self, n: int) -> None:
        """What is no array; and named points that are made already must have one shape a mode."""
        mapping_of("points", self.points)
        self._check_faces(n)
        for name in ("locate", "nodes", "fidelity_levels"):
            if not (callable(getattr(self, name)) or (name != "locate" and getattr(self, name) is None)):
                raise ModelError(f"{name}: {shown(getattr(self, name))} was given, expected a function")
        for name, kinds in (
            ("shape", SHAPES),
            ("resolution", (Resolution,)),
            ("recovery", (SpatialLineShapes, MeshShapes)),
        ):
            value = getattr(self, name)
            if value is not None and not isinstance(value, kinds):
                expected = " or ".join(kind.__name__ for kind in kinds)
                raise ModelError(f"{name}: {shown(value)} was given, expected {expected}, or None")
        if isinstance(self.points, dict):
            for name, point in self.points.items():
                if not isinstance(point, SpatialPoint):
                    raise ModelError(f"points[{name!r}]: {type(point).__name__} was given, expected a SpatialPoint")
                for part, shape in (("place", (3,)), ("phi", (n, 3)), ("psi", (n, 3))):
                    array_of(f"points[{name!r}].{part}", getattr(point, part), shape)

    def _check_faces(self, n: int) -> None:
        mapping_of("faces", self.faces)
        if isinstance(self.faces, dict):
            for name, face in self.faces.items():
                if not isinstance(face, FaceNodes):
                    raise ModelError(f"faces[{name!r}]: {shown(face)} was given, expected that of a reduced body")
                if face.points and face.points[0].phi.shape != (n, 3):
                    raise ModelError(f"faces[{name!r}]: it is of another body, expected points with {n} modes")

    def __setstate__(self, state: list[Any]) -> None:
        """Of a copy or what is unpickled, whose arrays are read-only again."""
        restore(self, state)

    @property
    def modes(self) -> int:
        """Number n of modal coordinates; 0 for a rigid body."""
        return len(self.stiffness)

    @property
    def second_order_modes(self) -> int:
        """Number n2 of the first modes whose products are kept."""
        return len(self.products)

    @property
    def centre(self) -> FloatArray:
        """(3,) place of the undeformed mass centre in the body frame [m]."""
        return np.asarray(self.moment / self.mass)

    @property
    def central_inertia(self) -> FloatArray:
        """(3, 3) inertia of the undeformed body about its mass centre, axes of the body frame [kg m^2]."""
        central = self.second - np.outer(self.moment, self.moment) / self.mass
        return np.asarray(np.trace(central) * np.eye(3) - central)

    def frequencies(self) -> FloatArray:
        """(n,) natural angular frequencies of the undamped body [rad/s], of its frame as it is held."""
        return np.asarray(np.sqrt(self.stiffness))

    def point(self, name: str) -> SpatialPoint:
        """The material point of that name.

        Raises
        ------
        ModelError
            For a name that the body does not have.
        """
        if not isinstance(name, str) or name not in self.points:
            raise ModelError(f"name: there is no point {absent(name, self.points)}")
        return self.points[name]

    def face(self, name: str) -> FaceNodes:
        """The face of that name.

        Raises
        ------
        ModelError
            For a name that the body does not have, and a set of nodes that are not those of faces of elements.
        """
        if isinstance(name, str) and name in self.faces:
            return self.faces[name]
        if isinstance(name, str) and name in self.points:
            known = ", ".join(map(repr, sorted(self.faces))) or "no face"
            raise ModelError(
                f"name: {shown(name)} was given, whose nodes hold no whole face of an element of the surface, expected "
                f"one of those that do ({known})"
            )
        raise ModelError(f"name: there is no face {absent(name, self.faces)}")

    def at_nodes(self, nodes: Sequence[int] | int, weights: Sequence[float] | None = None) -> SpatialPoint:
        """The point that stands for some nodes of the mesh: weighted means of their places and motion.

        With y_i the place of node i from the mean place, the rotation is psi = G^-1 sum w_i y_i x Phi_i,
        G = sum w_i (|y_i|^2 I - y_i y_i^T): forces and moments at the point are spread over the nodes accordingly.

        Parameters
        ----------
        nodes : their numbers; of a single one the rotation is that of the best linear field around it
        weights : one each, > 0; equal ones if None

        Raises
        ------
        ModelError
            For a body without a mesh, or nodes and weights that it cannot have.
        """
        if self.nodes is None:
            raise ModelError("nodes: this body has no mesh, expected one of SpatialMatrices")
        return self.nodes(nodes, weights)


def rigid_point(x: float, y: float, z: float) -> SpatialPoint:
    """A place of a rigid body: no shapes."""
    return SpatialPoint(array_of("x, y, z", (x, y, z), (3,)), np.zeros((0, 3)), np.zeros((0, 3)))


def _nowhere(x: float, y: float, z: float) -> SpatialPoint:
    """A flexible body of a user, whose modes are known at its named points alone."""
    raise ModelError(f"x, y, z: ({x:.6g}, {y:.6g}, {z:.6g}) was given, but the modes are known at named points alone")
