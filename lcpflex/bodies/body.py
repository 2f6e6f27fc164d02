"""The one kind of body: a floating frame with n >= 0 modal coordinates; n = 0 is a rigid body.

A material point that lies at x in the undeformed body (body frame) is found at

    r = R + A (x + Phi(x) q)       R, A: place and rotation of the frame,  q (n,): modal coordinates

With < . > = integral of rho ( . ) dV and J = [[0, -1], [1, 0]], a body is its inertia integrals

    m = <1>,  s0 = <x>,  I0 = <x.x>,  S = <Phi>,  a = <Phi^T x>,  c = <Phi^T J x>,  D = <Phi^T J^T Phi>

in a basis with <Phi^T Phi> = I and a diagonal stiffness. Inertia terms: Zwoelfer & Gerstmayr (2020).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of, mapping_of as named, whole_number
from lcpflex.basics.options import keep_number
from lcpflex.basics.renamed import renamed_keyword, renamed_property
from lcpflex.basics.restored import restore
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Axis
from lcpflex.model.planar import N_RIGID
from lcpflex.model.recovery import Shapes

if TYPE_CHECKING:
    from lcpflex.bodies.reduction.again import Reduction

__all__ = [
    "Body",
    "Chain",
    "Displacement",
    "Lazily",
    "MaterialPoint",
    "Outline",
    "Reducible",
    "Resolution",
    "Round",
    "FidelityLevel",
    "Shortening",
    "Statics",
    "array_of",
    "named",
    "whole_number",
]

T = TypeVar("T")
Displacement: TypeAlias = Callable[[float, float], tuple[float, float]] | npt.ArrayLike


@dataclass(frozen=True, slots=True, eq=False)
class MaterialPoint:
    """A point of a body that is not placed in a scene yet.

    Attributes
    ----------
    place : (2,) undeformed place x in the body frame [m]
    phi : (n, 2) displacement shape of each mode at the point [kg^-1/2]
    psi : (n,) rotation of the material at the point, of each mode [kg^-1/2 / m]
    """

    place: FloatArray
    phi: FloatArray
    psi: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A piece of outline: straight from point to point, solid on the left, outward normal on the right.

    A ``closed`` chain runs on from its last point to its first; around a solid it is counter-clockwise,
    around a hole clockwise.

    points: material points in their order. closed: whether the last one is joined to the first.
    """

    points: tuple[MaterialPoint, ...]
    closed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """A circular outline about a material point: solid inside, or outside of it if it is a ``hole``.

    center: material point. radius [m].
    """

    center: MaterialPoint
    radius: float
    hole: bool = False


Outline: TypeAlias = Chain | Round


@dataclass(frozen=True, slots=True)
class Resolution:
    """What a mesh can resolve.

    Attributes
    ----------
    wave_speed : of longitudinal waves, sqrt(E / rho) [m/s]
    element_size : longest edge of an element [m]
    """

    wave_speed: float
    element_size: float


class Reducible(Protocol):
    """What is reduced to a body: a beam, a bar, a mesh, matrices."""

    @property
    def reduce(self) -> Callable[..., Any]:
        """Makes the body: ``reduce(modes, damping, interfaces=..., residual_damping=...)``."""
        ...


class Statics(Protocol):
    """Static compliance of a whole mesh that floats freely: loads are balanced by its inertia."""

    known: dict[Any, Any]  # what was found from it, by place and direction

    def compliance(self, *place: Any) -> FloatArray:
        """(3, 3), in space (6, 6): displacement [m] and rotation [rad] at a place by unit forces and moments there.

        place: x, y in the plane; in space, what tells the point of the mesh.
        """
        ...

    def enough(self, place: tuple[Any, ...], rows: FloatArray, share: float) -> int:
        """How many free modes miss at most ``share`` of the compliance in the rows (3, k); 0 where it is not known."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Shortening:
    """How much shorter a body gets as it bends, by q_b^T G_a q_b / 2 in the coordinate of each axial mode a.

    The potential that follows is that of :mod:`lcpflex.dynamics.shortening`.

    Attributes
    ----------
    axial : (m,) which modes stretch the body
    bending : (k,) which modes bend it
    matrices : (m, k, k) G_a, each symmetric [kg^-1/2 / m]; of a beam
        1/omega_a^2 integral of E A u_a' w_k' w_l' dx
    """

    axial: IntArray
    bending: IntArray
    matrices: FloatArray

    def __post_init__(self) -> None:
        shape = (len(self.axial), len(self.bending), len(self.bending))
        matrices = array_of("shortening: matrices", self.matrices, shape)
        if not np.array_equal(matrices, matrices.transpose(0, 2, 1)):
            raise ModelError("shortening: a matrix that was given is not symmetric, expected G_a = G_a^T")
        object.__setattr__(self, "matrices", matrices)


@dataclass(frozen=True, slots=True, eq=False)
class FidelityLevel:
    """A body at one fidelity, of the plane or of space.

    Attributes
    ----------
    name : "rigid", "4 modes", "boundary nodes", "full mesh"
    modes : number of its modal coordinates
    make : makes it
    """

    name: str
    modes: int
    make: Callable[[], Any]


class Lazily(Mapping[str, T], Generic[T]):
    """A read-only mapping whose values are made when they are first asked for."""

    __slots__ = ("_made", "_makers")

    def __init__(self, makers: Mapping[str, Callable[[], T]]) -> None:
        self._makers = dict(makers)
        self._made: dict[str, T] = {}

    def __getitem__(self, name: str) -> T:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._makers  # the inherited test would make the value

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A planar body in its own orthonormal modal basis; the makers of bodies give one, a user may write one.

    Attributes
    ----------
    mass : m = <1> [kg]
    inertia : I0 = <x.x>, about the origin of the frame [kg m^2]
    moment : (2,) s0 = <x> [kg m]
    S : (n, 2) <Phi> [kg^1/2]
    a : (n,) <Phi^T x> [kg^1/2 m]
    c : (n,) <Phi^T J x> [kg^1/2 m]
    stiffness : (n,) squares of the natural angular frequencies [rad^2/s^2]
    damping : (n,) diagonal of the modal damping matrix, 2 zeta omega [1/s]
    coupling : (n, n) D = <Phi^T J^T Phi>, skew [-]; None where it is zero
    cross_damping : (n, n) off-diagonal part of the modal damping matrix [1/s]; None where it is zero
    geometric : (n, n) G, symmetric: spinning at omega adds the stiffness omega^2 G [-]; None without stiffening
    shortening : of a body whose axial force acts on its bending; None where it does not
    points : named material points
    surfaces : named outlines, each a :class:`Chain` or a :class:`Round`; "outline" is the whole of it
    locate : the material point at a place (x, y) of the body frame; raises :class:`ModelError` off the body
    axisymmetric : whether it stands for a solid of revolution about x, which moves along its axis only
    resolution : what the mesh can resolve; None where it has none
    fidelity_levels : gives the same body at other fidelities, from rigid to the whole mesh; None where only this one is
        known
    residual_modes : how many of the last coordinates are residual modes, the static response at interfaces
    contact_modes : how many of these interfaces of contacts have added; where there are some, ``MasslessBoundary``
        makes residual modes static that joints and springs do not need
    statics : static compliance of the whole mesh, to compare with; None where it is not known
    axis : of a beam: what its axial force is compared with; None for other bodies
    recovery : what its section forces or stresses are recovered from; None where they cannot be
    products : maps a displacement field d to (3 + n,) <[1_x, 1_y, J x, Phi]^T d>; None where the
        distribution of mass is not known (:meth:`project` needs it)
    reduction : by how many modes of its mesh it was made, and what makes it with more; None where that is not known

    Raises
    ------
    ModelError
        For NaN, wrong shapes, or inertia that no distribution of mass can have (m <= 0 or m I0 <= |s0|^2).
    """

    mass: float
    inertia: float
    moment: FloatArray
    S: FloatArray
    a: FloatArray
    c: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    coupling: FloatArray | None
    cross_damping: FloatArray | None
    points: Mapping[str, MaterialPoint]
    surfaces: Mapping[str, Outline]
    locate: Callable[[float, float], MaterialPoint]
    geometric: FloatArray | None = field(default=None, repr=False)
    shortening: Shortening | None = field(default=None, repr=False)
    axisymmetric: bool = False
    resolution: Resolution | None = field(default=None, repr=False)
    fidelity_levels: Callable[[], tuple[FidelityLevel, ...]] | None = field(default=None, repr=False)
    residual_modes: int = 0
    contact_modes: int = 0
    statics: Statics | None = field(default=None, repr=False)
    products: Callable[[Displacement], FloatArray] | None = field(default=None, repr=False)
    axis: Axis | None = field(default=None, repr=False)
    recovery: Shapes | None = field(default=None, repr=False)
    reduction: Reduction[Body] | None = field(default=None, repr=False)

    ladder = renamed_property("ladder", "fidelity_levels")

    def __post_init__(self) -> None:
        n = len(self.stiffness)
        shapes: dict[str, tuple[int, ...]] = {
            "moment": (2,), "S": (n, 2), "a": (n,), "c": (n,), "stiffness": (n,), "damping": (n,),
            "coupling": (n, n), "cross_damping": (n, n), "geometric": (n, n),
        }  # fmt: skip
        keep_number(self, "mass", 0.0, math.inf, open_ends=True)
        keep_number(self, "inertia", 0.0, math.inf, open_ends=True)
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, array_of(name, value, shape))
        if n and (self.stiffness.min() <= 0.0 or self.damping.min() < 0.0):
            raise ModelError("stiffness, damping: a body has elastic modes only, stiffness > 0 and damping >= 0")
        if self.coupling is not None and not np.array_equal(self.coupling, -self.coupling.T):
            raise ModelError("coupling: the matrix that was given is not skew, expected D = -D^T")
        if self.cross_damping is not None and np.abs(np.diag(self.cross_damping)).any():
            raise ModelError("cross_damping: its diagonal belongs into damping, expected zeros there")
        if self.geometric is not None and not np.array_equal(self.geometric, self.geometric.T):
            raise ModelError("geometric: the matrix that was given is not symmetric, expected G = G^T")
        for name, most in (("residual_modes", n), ("contact_modes", self.residual_modes)):
            object.__setattr__(self, name, whole_number(name, getattr(self, name), 0, most))
        least = float(self.moment @ self.moment) / self.mass
        if not self.inertia > least:
            raise ModelError(
                f"inertia: {shown(self.inertia)} was given, expected more than |moment|^2 / mass = {shown(least)}"
            )
        if self.reduction is not None:
            from lcpflex.bodies.reduction.again import sealed_reduction  # which bodies given by hand do without

            object.__setattr__(self, "reduction", sealed_reduction(self.reduction, self))

    def __setstate__(self, state: list[Any]) -> None:
        """Of a copy or what is unpickled, whose arrays are read-only again."""
        restore(self, state)

    @property
    def modes(self) -> int:
        """Number n of modal coordinates; 0 for a rigid body."""
        return len(self.stiffness)

    def holes(self) -> tuple[Chain, ...]:
        """The loops around holes of a mesh, clockwise: its surfaces "hole1", "hole2", ..."""
        named_so = (self.surfaces[name] for name in self.surfaces if name.startswith("hole"))
        return tuple(hole for hole in named_so if isinstance(hole, Chain) and hole.closed)

    def frequencies(self) -> FloatArray:
        """(n,) natural angular frequencies of the free, undamped body [rad/s], ascending as made."""
        return np.asarray(np.sqrt(self.stiffness))

    def project(self, displacement: Displacement) -> tuple[float, float, float, FloatArray]:
        """Split a displacement (or velocity) field into motion of the frame and modal coordinates.

        Minimises <|d - (dx, dy) - dangle J x - Phi q|^2>, the mass-weighted distance; exact when the field is
        a combination of the rigid motions and the modes kept. The angle is taken as small.

        Parameters
        ----------
        displacement : function (x, y) -> (dx, dy) of the place in the body frame [m], or nodal values:
            (nodes, 2) for bars and meshes, (nodes, 3) with the rotation [rad] last for beams

        Returns
        -------
        dx, dy [m], dangle [rad], modal (n,) : the split, body axes

        Raises
        ------
        ModelError
            For a body without a known distribution of mass, a wrong shape, or NaN.
        """
        if self.products is None:
            raise ModelError("project: this body has no known distribution of mass, expected a beam, bar or mesh")
        right = self.products(displacement)
        sx, sy = self.moment
        rigid = np.array([[self.mass, 0.0, -sy], [0.0, self.mass, sx], [-sy, sx, self.inertia]])
        coupled = np.vstack([self.S.T, self.c])  # zero for free-interface modes
        reduced = rigid - coupled @ coupled.T
        frame = np.linalg.solve(reduced, right[:N_RIGID] - coupled @ right[N_RIGID:])
        return float(frame[0]), float(frame[1]), float(frame[2]), right[N_RIGID:] - coupled.T @ frame


Body.__init__ = renamed_keyword(ladder="fidelity_levels")(Body.__init__)  # type: ignore[method-assign]
