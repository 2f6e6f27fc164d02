"""A place of rest: where the bodies are, what pushes on what, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lcpflex.basics.arguments import absent
from lcpflex.errors import ModelError
from lcpflex.kinematics.places import world_places
from lcpflex.statics import later

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.stress_history import Stress

__all__ = ["ContactAtRest", "JointAtRest", "Rest", "Trace"]

ORDER = ("open", "touch", "slip", "stick")


@dataclass(frozen=True, slots=True, eq=False)
class ContactAtRest:
    """A declared contact at rest, with the k places where it is closed.

    Attributes
    ----------
    name
        Of the contact.
    states
        (k,) of each place: "stick", its forces can be within the cone of friction; "slip", it is pressed, and friction
        is at its limit, or there is none; "touch", closed without a force.
    bodies
        (k,) names of the two bodies: the first is pushed along ``direction``.
    place, direction
        (k, 2) [m], and (k, 2) the normal n, a unit vector, world axes; in space (k, 3) both.
    normal, tangential
        (k,) lambda_N >= 0 along n = (x, y) and lambda_T along (y, -x), on the first body [N]; in space ``tangential``
        is (k, 3), the vector of friction on the first body, world axes.
    unique
        (k,) whether balance determines both; else they are those of the least norm.
    """

    name: str
    states: tuple[str, ...]
    bodies: tuple[tuple[str, str], ...]
    place: FloatArray
    direction: FloatArray
    normal: FloatArray
    tangential: FloatArray
    unique: NDArray[np.bool_]

    @property
    def state(self) -> str:
        """ "open", or the state of the place that holds most: "touch", "slip" or "stick"."""
        return max(("open", *self.states), key=ORDER.index)

    def on(self, body: str) -> FloatArray:
        """(2,) force on the body of that name [N], world axes; in space (3,).

        Raises ModelError where the contact is none of its.
        """
        known = sorted({name for pair in self.bodies for name in pair})
        if known and (not isinstance(body, str) or body not in known):
            raise ModelError(f"body: no body {absent(body, known)} in the contact {self.name!r}")
        friction = self.tangential
        if friction.ndim == 1:
            across = np.stack([self.direction[:, 1], -self.direction[:, 0]], axis=1)
            friction = friction[:, None] * across
        force = self.normal[:, None] * self.direction + friction
        sign = np.array([float(pair[0] == body) - float(pair[1] == body) for pair in self.bodies])
        return np.asarray((sign[:, None] * force).sum(axis=0)) if len(sign) else np.zeros(force.shape[1])


@dataclass(frozen=True, slots=True, eq=False)
class JointAtRest:
    """What a joint does to the body of its first point P, at P; the body of Q bears the opposite at the same place.

    name; ``force`` (2,) [N], world axes; ``moment`` [N m], counter-clockwise; in space (3,) both, the moment about P;
    ``unique``: whether balance determines them, else they are those of the least norm.
    """

    name: str
    force: FloatArray
    moment: float | FloatArray
    unique: bool


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """What a path that begins at a place of rest, and the comparison of two places, have to know of it.

    multipliers
        Of the rows of joints and near contacts, by keys that outlive them.
    closed
        Keys of the contacts that are closed.
    family
        (k, ndof) directions in which it is one place of many: neutral ones, and those that friction holds.
    """

    multipliers: Mapping[tuple[int, int], float]
    closed: frozenset[int]
    family: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """Where a scene rests, by :func:`lcpflex.equilibrium`; ``simulate(scene, ..., initial=rest)`` starts there.

    Attributes
    ----------
    q
        (nq,) configuration, in the layout of :class:`lcpflex.results.result.Result`.
    contacts, joints
        What each declared contact and joint carries; see :meth:`contact` and :meth:`joint`.
    stable
        Whether no direction is left in which forces push away from this place, to first order: pressed contacts
        hold, sticking ones do not slip, forces of slipping ones keep their size. Grazing contacts are taken for open.
        It is a statement of statics: near the limit of a large friction a jammed place may have a second motion that
        obeys Coulomb's law, too, and a run may leave it; steps that are long for a clearance leave a place as well.
    unstable, neutral
        What moves in such a direction, and in those in which nothing changes, as where a disc may turn. A beam that
        bears more than it buckles under, which its bending does not feel, is told among the first.
    neighbours
        Dimension of the places of rest next to this one, among which friction lets the scene be: 0 where there are
        none, as without friction. Which one is found follows from the start.
    unique
        Whether balance determines all forces; else those of the least norm are told: of all sets of multipliers that
        balance the loads within the cones of friction that with the least sum of squares, moments divided by the
        extent of the largest body.
    residual
        Largest force that is not balanced, relative to the largest that acts.
    travelled
        Length of the path from the start, of the point that moves most in each of its ``steps`` [m].
    time
        At which loads and drives are taken [s].
    warnings
        Of the compiled scene, and of axial loads that the bending of beams does not feel.
    trace
        What a path that begins here, and the comparison with another place, have to know of it.
    """

    q: FloatArray
    contacts: tuple[ContactAtRest, ...]
    joints: tuple[JointAtRest, ...]
    stable: bool
    unstable: tuple[str, ...]
    neutral: tuple[str, ...]
    neighbours: int
    unique: bool
    residual: float
    travelled: float
    steps: int
    time: float
    warnings: tuple[str, ...]
    compiled: CompiledScene = field(repr=False)
    trace: Trace = field(repr=False)

    def contact(self, name: str) -> ContactAtRest:
        """The declared contact of that name. Raises ModelError where there is none."""
        known = {contact.name: contact for contact in self.contacts}
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"name: no contact {absent(name, known)}")
        return known[name]

    def joint(self, name: str) -> JointAtRest:
        """The joint of that name. Raises ModelError where there is none."""
        known = {joint.name: joint for joint in self.joints}
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"name: no joint {absent(name, known)}")
        return known[name]

    def point(self, body: str, point: str) -> FloatArray:
        """(2,) or (3,) place of a named point of a body [m], world axes. Raises ModelError where there is none."""
        known = self.compiled.layout.points
        if not isinstance(body, str) or body not in self.compiled.layout.bodies:
            raise ModelError(f"body: no body {absent(body, self.compiled.layout.bodies)}")
        names = [name for owner, name in known if owner == body]
        if not isinstance(point, str) or point not in names:
            raise ModelError(f"point: {body!r} has no point {absent(point, names)}")
        return np.asarray(world_places(self.compiled.model, self.q, np.array([known[body, point]]))[0])

    def stress(self, body: str, *, static: bool = True) -> Stress:
        """Stresses of a flexible body at its nodes, (p,) each: see :class:`lcpflex.results.stress_history.Stress`.

        body: its name. static: with the static part of what its modes leave out; False for its modes alone. Raises
        ModelError as :meth:`lcpflex.results.result.Result.stress` does.
        """
        return later.stress_at_rest(self, body, static)

    def draw(self, axes: Axes | None = None, *, view: Any = None, frames: bool = False, scale: float = 1.0) -> Figure:
        """Picture of the scene at rest: deformed shapes and an arrow for each contact force.

        axes, view, frames, scale: as of :meth:`lcpflex.results.result.Result.draw`.
        """
        return later.draw_rest(self, axes, view, frames, scale)

    def summary(self) -> str:
        """Contacts, joints and what can be said of the place, in lines of text."""
        lines = [f"at rest after {self.travelled:.4g} m of path, residual {self.residual:.1e}"]
        for contact in self.contacts:
            places = f"{len(contact.states)} place{'s' if len(contact.states) > 1 else ''}"
            force = f", {contact.normal.sum():.6g} N in {places}" if contact.states else ""
            lines.append(f"contact {contact.name!r}: {contact.state}{force}")
        for joint in self.joints:
            lines.append(f"joint {joint.name!r}: {_told(joint.force)} N, {_told(joint.moment)} N m")
        lines.append("stable" if self.stable else f"unstable: {'; '.join(self.unstable)}")
        if self.neutral:
            lines.append(f"nothing changes where {'; '.join(self.neutral)}")
        if self.neighbours:
            lines.append(f"friction also holds it in places next to this one, in {self.neighbours} dimension(s)")
        if not self.unique:
            lines.append("balance does not determine all forces: those of the least norm are told")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.summary()


def _told(value: float | FloatArray) -> str:
    """Six digits of a number, or of each component."""
    if np.ndim(value) == 0:
        return f"{value:.6g}"
    return f"({', '.join(f'{component:.6g}' for component in np.asarray(value))})"
