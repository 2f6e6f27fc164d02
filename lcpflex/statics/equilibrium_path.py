"""Places of rest in a row, with what a drive or a load does along them, as one result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError
from lcpflex.statics import later

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.statics.rest import Rest

__all__ = ["ContactOnPath", "Curve", "EquilibriumPath", "JointOnPath", "Jump"]


@dataclass(frozen=True, slots=True, eq=False)
class Jump:
    """A place of the path where a rest ends: the next one is far, however little the drive moves (snap-through).

    Attributes
    ----------
    after
        Index of the last rest of the path before it.
    values
        (2,) of the drive or load, just before and just behind it.
    rests
        The place that ends, and the one where the scene comes to rest then.
    travel, force
        (2,) as of the path, at both.
    moved
        How far the point moves that moves most [m].
    words
        What moves, and which way.
    """

    after: int
    values: FloatArray
    rests: tuple[Rest, Rest]
    travel: FloatArray
    force: FloatArray
    moved: float
    words: str


@dataclass(frozen=True, slots=True, eq=False)
class ContactOnPath(NamesNearest):
    """A declared contact over the k rests of a path.

    Attributes
    ----------
    name
        Of the contact.
    state
        (k,) "open", or that of the place that holds most: "touch", "slip" or "stick".
    normal
        (k,) sum of the normal forces [N].
    tangential
        (k,) sum of the tangential forces of its places, each along its own tangent [N]; in space (k, 3), friction on
        the body of the first surface of the contact, a vector in world axes.
    """

    name: str
    state: tuple[str, ...]
    normal: FloatArray
    tangential: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class JointOnPath(NamesNearest):
    """What a joint does to the body of its first point P, at P, over the k rests of a path.

    name; ``force`` (k, 2) [N], world axes; ``moment`` (k,) [N m], counter-clockwise; in space (k, 3) both; ``unique``
    (k,): whether balance determines them.
    """

    name: str
    force: FloatArray
    moment: FloatArray
    unique: FloatArray


class Curve(NamedTuple):
    """The rests of a path and both sides of each jump between them, in their order: j in all."""

    values: FloatArray  # (j,)
    travel: FloatArray  # (j,)
    force: FloatArray  # (j,), NaN where scenes were given
    rests: IntArray  # (k,) which of them are the rests
    jumps: NDArray[np.bool_]  # (j - 1,) whether one leads to the next by a jump


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class EquilibriumPath(NamesNearest):
    """Rests in a row, by :func:`lcpflex.path`, each reached from the one before; ``path[k]`` is the k-th.

    Attributes
    ----------
    drive
        Name of the drive or load; "" where scenes were given.
    values
        (k,) its values at the rests that were found: [m] or [rad] of a drive, [N] or [N m] of a load.
    rests
        (k,) the places.
    travel, force
        (k,) how far the drive has gone, and its force: where it is positive it pushes towards larger values. A drive
        goes by its values [m], [rad]; a load by the way of its point along it, or the rotation about it, since the
        first rest. ``force`` is None where scenes were given, and travel is their values.
    units
        Of "values", "travel" and "force".
    asked
        (n,) values that were asked for.
    complete, message
        Whether there is a rest for each of them; else why the path ends where it does.
    jumps
        Where a rest ended between two values, in their order.
    warnings
        Of all rests, and of what the path could not tell.
    """

    drive: str
    values: FloatArray
    rests: tuple[Rest, ...]
    travel: FloatArray
    force: FloatArray | None
    units: Mapping[str, str]
    asked: FloatArray
    complete: bool
    message: str
    jumps: tuple[Jump, ...]
    warnings: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.rests)

    def __iter__(self) -> Iterator[Rest]:
        return iter(self.rests)

    def __getitem__(self, k: int) -> Rest:
        return self.rests[k]

    def __repr__(self) -> str:
        of = f" of {self.drive!r}" if self.drive else ""
        return f"<path{of}: {len(self.rests)} of {len(self.asked)} rests, {len(self.jumps)} jumps>"

    @property
    def q(self) -> FloatArray:
        """(k, nq) configurations."""
        return np.array([rest.q for rest in self.rests])

    @property
    def stable(self) -> FloatArray:
        """(k,) whether each rest is stable."""
        return np.array([rest.stable for rest in self.rests])

    @property
    def work(self) -> FloatArray:
        """(k,) work of the drive since the first rest, the integral of the force over its way [J].

        By trapezoids between the rests, with what lies before and behind each jump. Over a closed way it is what
        friction and jumps have taken. Raises ModelError where scenes were given.
        """
        if self.force is None:
            raise ModelError("work: a path of scenes has no drive, expected one of a drive or load by its name")
        curve = self.curve()
        steps = 0.5 * (curve.force[1:] + curve.force[:-1]) * np.diff(curve.travel)
        return np.asarray(np.concatenate([[0.0], np.cumsum(steps)])[curve.rests])

    def curve(self) -> Curve:
        """What a chart of the path shows: rests, and both sides of each jump."""
        place = [jump.after + 1 for jump in self.jumps for _ in jump.values]
        force = np.full(len(self.rests), np.nan) if self.force is None else self.force
        rests = np.arange(len(self.rests))
        rests += np.searchsorted(place, rests, side="right")
        count = len(rests) + len(place)
        jumps = np.zeros(max(count - 1, 0), bool)
        jumps[np.setdiff1d(np.arange(count), rests)[::2]] = True
        return Curve(
            np.insert(self.values, place, [x for jump in self.jumps for x in jump.values]),
            np.insert(self.travel, place, [x for jump in self.jumps for x in jump.travel]),
            np.insert(force, place, [x for jump in self.jumps for x in jump.force]),
            rests,
            jumps,
        )

    def contact(self, name: str) -> ContactOnPath:
        """The declared contact of that name. Raises ModelError where there is none."""
        known = [one.name for one in self.rests[0].contacts]
        if not isinstance(name, str) or name not in known:
            raise ModelError(f"name: no contact {absent(name, known)}")
        k = known.index(name)
        force = later.rests_as_result(self.rests).force[:, k]
        tangential = force[:, 1] if force.shape[1] == 2 else force[:, 1:]
        return ContactOnPath(name, tuple(rest.contacts[k].state for rest in self.rests), force[:, 0], tangential)

    def joint(self, name: str) -> JointOnPath:
        """The joint of that name. Raises ModelError where there is none."""
        own = [rest.joint(name) for rest in self.rests]
        force, moment = np.array([one.force for one in own]), np.array([one.moment for one in own])
        return JointOnPath(name, force, moment, np.array([one.unique for one in own]))

    def point(self, body: str, point: str) -> FloatArray:
        """(k, 2) or (k, 3) places of a named point of a body [m], world axes. Raises ModelError where there is none."""
        return np.array([rest.point(body, point) for rest in self.rests])

    def to_dataframe(self) -> Any:
        """A pandas DataFrame, one row a rest, indexed by the value of the drive.

        Columns: ``travel``, ``force`` and ``work`` of the drive, ``stable``, ``residual``; of contacts, joints and
        coordinates those of :meth:`lcpflex.results.result.Result.to_dataframe`, without rates, impulses and gaps; a
        state is 0 open, 1 stick (or closed without a force), 2 slip. Units are in ``attrs["units"]`` by column. Raises
        ModelError where pandas is not installed.
        """
        return later.path_to_dataframe(self)

    def plot(self, axes: Axes | None = None) -> Figure:
        """Chart of the force over the way of the drive; where scenes were given, of contact forces over their values.

        Rising values are solid, falling ones dashed, arrows go with the path; jumps are dotted.

        axes: of matplotlib, to draw into; a new figure if omitted.
        """
        return later.plot_path(self, axes)

    def summary(self) -> str:
        """Way, forces, work, contacts, jumps, and where it ended, in lines of text."""
        return later.path_summary(self)

    def __str__(self) -> str:
        return self.summary()
