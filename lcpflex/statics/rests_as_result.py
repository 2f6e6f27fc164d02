"""Places of rest as stored instants of a result, so that what is told of results is told of them: pictures, stresses.

Velocities, impulses and energies of that result are zeros, which nobody asks for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.model.arrays import OPEN, SLIP, STICK
from lcpflex.model.layout import dimension
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.energy_balance import Energies
from lcpflex.results.plot import draw
from lcpflex.results.result import Result
from lcpflex.results.stored_instants import AT_REST
from lcpflex.results.stress_history import Stress, stress_history

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.statics.rest import ContactAtRest, Rest

__all__ = ["draw_rest", "rests_as_result", "stress_at_rest"]

STATES = {"open": OPEN, "touch": STICK, "stick": STICK, "slip": SLIP}  # what touches without a force stays, too


def draw_rest(rest: Rest, axes: Axes | None, view: Any, frames: bool, scale: float) -> Figure:
    """See :meth:`lcpflex.statics.rest.Rest.draw`."""
    figure = draw(rests_as_result([rest]), rest.time, axes, view, frames, scale)
    axes = figure.axes[0] if axes is None else axes
    _, _, deformed = axes.get_title(loc="left").partition(",")  # behind the time
    words = "at rest" if rest.stable else "at rest, unstable"
    axes.set_title(f"{words},{deformed}" if deformed else words, fontsize="medium", loc="left")
    return figure


def stress_at_rest(rest: Rest, body: str, static: bool) -> Stress:
    """See :meth:`lcpflex.statics.rest.Rest.stress`."""
    return stress_history(rests_as_result([rest]), body, static).of(0)


def rests_as_result(rests: Sequence[Rest]) -> Result:
    """Places of rest, one or more, of one scene in their order: a single one at its time, several at 0, 1, 2, ..."""
    compiled, m = rests[0].compiled, len(rests)
    d = dimension(compiled.model.bodies).components
    times = np.array([rests[0].time]) if m == 1 else np.arange(float(m))
    points = _points(rests, d)
    force = np.zeros((m, len(compiled.layout.contacts), points.force.shape[1]))
    np.add.at(force, (points.record, points.contact), points.force)
    none = np.zeros(m)
    return Result(
        times=times,
        q=np.array([rest.q for rest in rests]),
        u=np.zeros((m, len(compiled.u))),
        force=force,
        impulse=np.zeros_like(force),
        state=_table([[STATES[one.state] for one in rest.contacts] for rest in rests], np.int8),
        gap=np.full(force.shape[:2], np.nan),
        contact_points=points,
        energies=Energies(**dict.fromkeys(Energies.__dataclass_fields__, none)),
        residual=np.array([rest.residual for rest in rests]),
        penetration=none,
        joint_drift=none,
        size=np.zeros(m, dtype=np.int64),
        events=(),
        warnings=(),
        complete=True,
        message="",
        steps=m,
        wall_time=0.0,
        compile_time=0.0,
        stepper=AT_REST,
        duration=float(times[-1]),
        compiled=compiled,
        **_reactions(rests, d),
    )


def _table(values: Sequence[Sequence[Any]], kind: Any) -> Any:
    """(m, k), where k may be 0."""
    return np.array(values, dtype=kind).reshape(len(values), -1 if values[0] else 0)


def _reactions(rests: Sequence[Rest], d: int) -> dict[str, Any]:
    """What a result holds of joints."""
    force = np.array([[(*one.force, *np.atleast_1d(one.moment)) for one in rest.joints] for rest in rests])
    force = force.reshape(len(rests), len(rests[0].joints), 3 if d == 2 else 6)
    sizes = np.linalg.norm(force[..., :d], axis=2), np.linalg.norm(force[..., d:], axis=2)
    return {
        "joint_force": force,
        "joint_peak": np.stack(sizes, axis=2),
        "joint_impulse": np.zeros_like(force),
        "joint_unique": _table([[one.unique for one in rest.joints] for rest in rests], np.int64),
    }


def _points(rests: Sequence[Rest], d: int) -> ContactPoints:
    """All places where contacts are closed, rest by rest; d: components of a place."""
    found = [(k, law, one) for k, rest in enumerate(rests) for law, one in enumerate(rest.contacts) if one.states]
    counts = [len(one.states) for _, _, one in found]
    sides = [_sides(rests[0].compiled, law, one)[:, None] for _, law, one in found]
    forces = [
        np.column_stack([one.normal, one.tangential if d == 2 else side * one.tangential])
        for side, (_, _, one) in zip(sides, found, strict=True)
    ]
    normals = [side * one.direction for side, (_, _, one) in zip(sides, found, strict=True)]
    return ContactPoints(
        record=np.repeat(np.array([k for k, _, _ in found], np.int64), counts),
        contact=np.repeat(np.array([law for _, law, _ in found], np.int64), counts),
        place=np.concatenate([np.zeros((0, d)), *(one.place for _, _, one in found)]),
        normal=np.concatenate([np.zeros((0, d)), *normals]),
        force=np.concatenate([np.zeros((0, 2 if d == 2 else 4)), *forces]),
        state=np.array([STATES[state] for _, _, one in found for state in one.states], np.int8),
    )


def _sides(compiled: CompiledScene, law: int, contact: ContactAtRest) -> FloatArray:
    """(k,) in space: 1 where forces at rest are those on the body of the first surface of the contact, else -1.

    In the plane a result tells the forces on the body of the node, as a place of rest does.
    """
    if not compiled.spatial:
        return np.ones(len(contact.states))
    contacts = compiled.model.contacts
    body = int(contacts.surface_body[int(contacts.law_surface[law, 0])])
    first = "ground" if body < 0 else compiled.layout.bodies[body]
    return np.array([1.0 if pair[0] == first else -1.0 for pair in contact.bodies])
