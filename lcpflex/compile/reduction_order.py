"""A body that is reduced when its scene is compiled: what was asked for, and the reduction for what acts on it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from inspect import signature
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.bar import Bar
from lcpflex.bodies.beam import Beam
from lcpflex.bodies.body import Body, array_of, whole_number
from lcpflex.bodies.fem.nodal_material import nearest_node
from lcpflex.bodies.reduction.component_modes import undeformed
from lcpflex.bodies.reduction.damping import Damping, check_damping
from lcpflex.bodies.reduction.interface import Interface, NodeMean
from lcpflex.bodies.reduction.mesh_interfaces import MeshStatics
from lcpflex.bodies.reduction.stiffening import Stiffening, check_stiffening
from lcpflex.compile.missing_compliance import LOOKED_AT_ON_FACES, deficits
from lcpflex.compile.surface_interfaces import Acting, acting_on
from lcpflex.errors import ModelError, in_range, shown

if TYPE_CHECKING:
    from lcpflex.bodies.spatial.body import SpatialBody
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.scene.declared import DeclaredContact

__all__ = ["ReductionOrder", "order_of"]

AnyBody: TypeAlias = "Body | SpatialBody"

MOST_MODES = 1_000_000  # far more than any body has that can be reduced
CONTACT_NODES = 3  # of a surface that get residual modes: its ends and its middle
MORE_NODES = (3, 5, 9)  # that are tried, the fewest first, where free modes do not do


@dataclass(frozen=True, slots=True, eq=False)
class ReductionOrder:
    """What ``scene.add(model, modes=...)`` asked for."""

    name: str  # of the body
    model: Any  # Beam, Bar, or a mesh; in space SpatialBeam, Solid, SpatialMatrices
    modes: int
    options: Mapping[str, Any]  # of ``model.reduce`` besides
    contact_nodes: int | None  # None: as few as do, see MORE_NODES
    modal: FloatArray  # (modes,) initial coordinates of the free modes
    modal_velocity: FloatArray
    made: dict[tuple[Interface, ...], AnyBody] = field(default_factory=dict, repr=False)  # so far, by interfaces

    @property
    def is_line(self) -> bool:
        """Whether it is a beam or bar, whose sections do not deform."""
        return isinstance(self.model, Beam | Bar)

    def body(self, interfaces: tuple[Interface, ...]) -> AnyBody:
        """The body with residual modes for the interfaces; made once."""
        if interfaces not in self.made:
            try:
                body = self.model.reduce(self.modes, interfaces=interfaces, **self.options)
            except ModelError as error:
                raise ModelError(f"body {self.name!r}: {error}") from None
            if isinstance(body.statics, MeshStatics):
                body.statics.of_surfaces = True
            self.made[interfaces] = body
        return self.made[interfaces]

    def interfaces(
        self,
        placed: Any,
        joints: Mapping[str, Any],
        loads: tuple[Any, ...],
        contacts: Mapping[str, DeclaredContact],
        angle: Callable[[int], Any],
        gives_way: bool = False,
    ) -> tuple[tuple[Interface, ...], tuple[str, ...]]:
        """The interfaces of the body, each once, and how many nodes of surfaces were taken, in words.

        ``angle`` of bodies at the start [rad], in space their rotation matrices; ``gives_way``: every contact needs
        modes of its own. A body without free modes is rigid, whatever acts on it.
        """
        if not self.modes:
            return (), ()

        def acts(count: int | None, of_face: int | None = self.contact_nodes) -> list[Acting]:
            if not isinstance(placed.source, Body):
                from lcpflex.compile.spatial.interfaces import spatial_acting_on  # which planar scenes do without

                return spatial_acting_on(placed.body, placed.source, joints, loads, contacts, count, angle, of_face)
            return acting_on(
                placed.body, joints, loads, contacts, count, self._snap, self.is_line, angle, gives_way,
                placed.frame_point,
            )  # fmt: skip

        if self.contact_nodes is not None:
            acting = acts(self.contact_nodes)
        else:
            acting = acts(CONTACT_NODES) if gives_way else self._needed(acts)
        taken = Counter((_noun(one), f"{one.surface!r} ({one.name})") for one in acting if one.surface)
        said = tuple(f"{k} {noun if k == 1 else _PLURAL[noun]} of {name}" for (noun, name), k in taken.items())
        interfaces = tuple(dict.fromkeys(one.interface for one in acting))
        if self.contact_nodes is None and any(one.named for one in acting):
            body = self.body(interfaces)
            for one in acts(None, LOOKED_AT_ON_FACES):
                if one.named and body.statics is not None:  # what it has residual modes for need not be solved again
                    body.statics.known[one] = (body.stiffness, ())
        return interfaces, said

    def _needed(self, acts: Callable[[int | None], list[Acting]]) -> list[Acting]:
        """With the fewest nodes of surfaces with which the body gives way as its mesh does, to a hundredth.

        Along a line and across it are needed apart. Where no number of nodes does, CONTACT_NODES in the plane, and none
        in space, where a few of the nodes of a face would make it lean; the scene warns.
        """
        looked_at = [one for one in acts(None) if _may_do_without(one)]

        def tried(count: int, kinds: set[tuple[str, bool]]) -> tuple[list[Acting], set[tuple[str, bool]]]:
            """What acts with so many nodes of the kinds, and which of these give way too little then."""
            acting = [one for one in acts(count) if not _may_do_without(one) or _kind(one) in kinds]
            body = self.body(tuple(dict.fromkeys(one.interface for one in acting)))
            return acting, {_kind(one) for one in looked_at if _kind(one) in kinds and deficits(body, one)}

        acting, kinds = tried(0, {_kind(one) for one in looked_at})
        if not kinds:
            return acting
        # in space the nodes of more are also those of fewer: where the most do not do, no other number does
        if len(looked_at[0].at) == 3 and tried(MORE_NODES[-1], kinds)[1]:
            return acts(0)
        for count in MORE_NODES:
            acting, left = tried(count, kinds)
            if not left:
                return acting
        return [one for one in acts(CONTACT_NODES) if not _may_do_without(one) or _kind(one) in kinds]

    def start(self, placed: tuple[FloatArray, FloatArray], body: AnyBody) -> tuple[FloatArray, FloatArray]:
        """Initial configuration and velocity of the reduced body: its residual modes begin at rest.

        ``placed``: of the undeformed one, which are those of the frame.
        """
        still = np.zeros(body.modes - self.modes)
        q, u = placed
        return np.concatenate([q, self.modal, still]), np.concatenate([u, self.modal_velocity, still])

    def _snap(self, x: float, y: float) -> tuple[tuple[float, float], bool]:
        """The material nearest to a place, and whether the place is off it."""
        if self.is_line:
            model = self.model
            high = model.thickness if isinstance(model, Beam) else model.height or math.sqrt(model.area)
            near = (min(max(x, 0.0), model.length), min(max(y, -0.5 * high), 0.5 * high))
            return near, math.dist(near, (x, y)) > 1e-9 * model.length
        mesh = self.model.finite_elements()
        nearest, at_node = nearest_node(mesh, x, y)
        if not at_node and mesh.locate is not None:
            try:
                mesh.locate(x, y)
            except ModelError:
                pass
            else:
                return (x, y), False
        found_x, found_y = mesh.places[nearest]
        return (float(found_x), float(found_y)), not at_node


def _equal(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether options are the same values; arrays are, where they are one."""
    return a.keys() == b.keys() and all(
        a[name] is b[name] or (not np.ndim(a[name]) and not np.ndim(b[name]) and a[name] == b[name]) for name in a
    )


def _check_kind(model: Any, made: Any, kind: type[AnyBody]) -> None:
    """Refuse what becomes a body of the other dimension, or none; ``made``: the kind that it becomes."""
    if made is not kind:
        words = "planar ones belong into a Scene" if made is Body else "of space belong into a SpatialScene"
        told = words if isinstance(made, type) and hasattr(made, "modes") else f"its reduce() gave {shown(made)}"
        raise ModelError(f"body: {type(model).__name__} was given, which is not of this kind of scene: {told}")


_PLURAL = {"node": "nodes", "patch": "patches"}


def _noun(acting: Acting) -> str:
    """What of a surface an interface is at."""
    return "patch" if isinstance(acting.interface.place, NodeMean) else "node"


def _may_do_without(acting: Acting) -> bool:
    """Whether it is one of the nodes of a surface, of which as few are taken as will do."""
    return bool(acting.surface) and not acting.named


def _kind(acting: Acting) -> tuple[str, bool]:
    """The surface of a node, and whether it is struck along the axis of a line."""
    return acting.surface, acting.interface.along == (1.0, 0.0)


def order_of(
    name: str,
    model: Any,
    modes: int | None,
    damping: Damping | None,
    stiffening: Stiffening | None,
    residual_damping: float | None,
    contact_nodes: int | None,
    modal: npt.ArrayLike | None,
    modal_velocity: npt.ArrayLike | None,
    others: Iterable[ReductionOrder],
    kind: type[AnyBody],
) -> tuple[ReductionOrder, Any]:
    """The order of a scene, and the body without deformation that answers for points and surfaces until then.

    ``others`` of the scene: of those that ask for the same, each reduction is made once. ``kind`` of its bodies.

    Raises
    ------
    ModelError
        For a model that cannot be reduced, and numbers that cannot be.
    """
    _check_kind(model, getattr(model, "reduces_to", Body if isinstance(model, Beam | Bar) else kind), kind)
    if modes is None:
        raise ModelError(f"modes: none were given for {type(model).__name__}, expected a number of free modes, modes=8")
    n = whole_number("modes", modes, 0, MOST_MODES)
    check_stiffening(stiffening)
    if damping is not None:
        check_damping(damping, n)
    if residual_damping is not None:
        in_range("residual_damping", residual_damping, 0.0, math.inf)
    given = {"damping": damping, "stiffening": stiffening, "residual_damping": residual_damping}
    zeros = np.zeros(n)
    if stiffening is not None and "stiffening" not in signature(model.reduce).parameters:
        raise ModelError(f"stiffening: {shown(stiffening)} was given for {type(model).__name__}, which takes none")
    options = {option: value for option, value in given.items() if value is not None}
    alike = (one.made for one in others if one.model is model and one.modes == n and _equal(one.options, options))
    order = ReductionOrder(
        name=name,
        model=model,
        modes=n,
        options=options,
        contact_nodes=None if contact_nodes is None else whole_number("contact_nodes", contact_nodes, 0),
        modal=zeros if modal is None else array_of("modal", modal, (n,)),
        modal_velocity=zeros if modal_velocity is None else array_of("modal_velocity", modal_velocity, (n,)),
        made=next(alike, {}),
    )
    body: Any = undeformed(model) if hasattr(model, "finite_elements") else model.reduce(0)
    _check_kind(model, type(body), kind)
    return order, body
