"""The same scene with more modes: what it changes tells how far the modes of a run can be trusted.

Of 58 runs of planar flexible scenes with contact, twice the largest change of a place by twice as many modes was
1.8 [1.4, 2.4] times the true error of the modes, and below it in one of ten; of 16 runs in space 1.6 [1.3, 2.0], and
below it once, by four times, where two modes bend a beam in one plane only. Truth had 3 n + 4 modes. To that of the
whole mesh it is 1.7 to 6 times the distance for beams and bars, and .3 to .8 times for a soft meshed block that lands
on a corner: what gives way where bodies touch comes with all modes, not with the next ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lcpflex.bodies.reduction.damping import continued
from lcpflex.dynamics.time_functions import ForceCallback
from lcpflex.errors import ModelError
from lcpflex.scene.substitution import one_with, remade

if TYPE_CHECKING:
    from lcpflex.bodies.reduction.again import Reduction
    from lcpflex.scene.compiling import ReductionOrder
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["richer"]

AnyScene = TypeVar("AnyScene", bound="Scene | SpatialScene")

COORDINATES = frozenset({"q", "u"})
OFFSETS = frozenset({"dof", "bodies"})


def richer(scene: AnyScene, factor: float = 2.0, least: int = 0) -> tuple[AnyScene, tuple[str, ...]]:
    """The scene with ``factor`` times as many modes of each reduced body, at most those of its mesh.

    A factor below 1 makes it poorer, of no body to fewer modes than ``least``.

    Counted are the modes that were chosen: free ones, or those of the mesh with its boundary held. Residual modes
    follow from joints, loads and contacts where the scene reduces its bodies, else from the interfaces that were given.
    Of several damping ratios the last one goes on, as it does for residual modes. Rigid bodies, and bodies with all
    modes of their mesh, stay as they are.

    Returns
    -------
    scene, unknown
        The scene itself where no body has more modes; and the names of flexible bodies of which it is not known how
        they were reduced: written by hand, changed after they were reduced, or of a basis that was given.

    Raises
    ------
    ModelError
        For functions of the user that read coordinates by their numbers, which are others with more modes; and for an
        initial deformation that cannot be carried over.
    """
    made: list[tuple[Any, Any]] = []
    unknown: list[str] = []
    known: dict[int, Any] = {}  # bodies by those they are made of: one that stands in several places is made once
    changed = False
    placed: Any
    for placed in scene.parts().placed:
        order = placed.order
        body = placed.source if order is None or not order.modes else order.body(())
        more = _more(body, known, lambda one, count: one.scaled(factor, count, least))
        if more is None:
            unknown.append(placed.name)
        if more is None or more is body:
            made.append(one_with(placed, None))
        elif order is None:
            made.append(one_with(placed, more))
            changed = True
        else:
            made.append((_richer_order(placed, order, more, known), placed.start))
            changed = True
    if not changed:
        return scene, tuple(unknown)
    _refuse_numbers(scene)
    return remade(scene, made), tuple(unknown)


def _more(body: Any, known: dict[int, Any], count: Callable[[Reduction[Any], int], int]) -> Any:
    """The body with as many modes as ``count`` says; itself where it has them, or all; None: how is not known."""
    if not body.modes:
        return body
    reduction: Reduction[Any] | None = body.reduction
    if reduction is None or not reduction.tells(body):
        return None
    modes = count(reduction, body.modes)
    if reduction.modes in (modes, reduction.most):
        return body
    if id(body) not in known:
        known[id(body)] = reduction.make(modes)
    return known[id(body)]


def _richer_order(placed: Any, order: ReductionOrder, free: Any, known: dict[int, Any]) -> ReductionOrder:
    """The order of more modes; ``free``: the body with these, without residual modes."""
    made = known.setdefault(id(order.made), {})  # orders that are alike share what is made
    made.setdefault((), free)
    before = order.body(())
    start = replace(placed, source=before, start=order.start(placed.start, before), order=None)
    q, u = one_with(start, free)[1]
    options = dict(order.options)
    if "damping" in options:
        options["damping"] = continued(options["damping"], free.modes)
    frame = [len(part) for part in placed.start]
    modal, rate = q[frame[0] :], u[frame[1] :]
    return replace(order, modes=free.modes, options=options, made=made, modal=modal, modal_velocity=rate)


def _refuse_numbers(scene: Any) -> None:
    """Raise ModelError for a function of state that reads coordinates by numbers that it does not take from it."""
    compiled = scene.compiled(project=True)
    external = np.zeros((compiled.n_external, 3))
    for callback in compiled.callbacks:
        if not isinstance(callback, ForceCallback) or not callback.with_state:
            continue
        seen = _Watched(compiled.state(0.0, compiled.q, compiled.u))
        callback.fill(0.0, seen, external)
        if seen.read & COORDINATES and not seen.read & OFFSETS:
            raise ModelError(
                f"{callback.name}: its function reads coordinates by their numbers, which are others with more modes; "
                "expected points: state.position(P), state.velocity(P)"
            )


class _Watched:
    """A state that takes note of what a function reads of it."""

    def __init__(self, state: Any) -> None:
        self._state = state
        self.read: set[str] = set()

    def __getattr__(self, name: str) -> Any:
        self.read.add(name)
        return getattr(self._state, name)
