"""How deep bodies are in each other, and how far joints have drifted: where, when, and whether that is too much.

Time stepping at velocity level closes a contact at the end of the step in which it meets, up to h |v| deep, and keeps
it there: what no pair could pass in one step is an error of something else. The step is compared at its own instant, so
that a run that goes on with another has the verdict of its parts; what it began with is not its own. Under error
control an impact takes the shortest step, but a contact that goes on may drift by the tolerance in each of the others.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.alarm import FINER, Alarm
from lcpflex.contact.thickness import law_thickness
from lcpflex.jit.struct import pack
from lcpflex.results.motion_units import Units
from lcpflex.results.stored_instants import CONTINUED
from lcpflex.results.words import with_unit
from lcpflex.steppers.scales import SUNK

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["worst_drift", "worst_penetration"]

STEPPED = 0.05  # of the size: a penetration that no step is allowed to leave, whatever it states of its error
CLIPPED = 0.1  # of the thinnest body, and of that
ACCEPTED = 5e-3  # of the size: the most that what error control accepts of its steps may add up to
NOISE = 1e-6  # of the size: what is deeper by no more is as deep as before
TIGHTER = "take tighter tolerances"
SEEN = 0.5  # of a penetration or drift: what has so much of it at a stored instant is what had all of it


def worst_penetration(result: Result, size: float) -> Alarm | None:
    """The deepest penetration that is large for bodies of ``size`` [m] and no step's approach; None without any."""
    depth, allowed = result.penetration, SUNK * size
    if result.all_compliant or not len(depth) or depth.max() <= allowed:
        return None
    step = result.impact_step
    assert result.compiled is not None
    most = min(STEPPED * size, CLIPPED * float(law_thickness(result.compiled.model.contacts).min(initial=np.inf)))
    reach = np.minimum(step * _speeds(result), most) if step > 0.0 else np.zeros(len(depth))
    # each step may put both bodies wrong by its tolerance, and nothing takes that back
    allowed = max(allowed, min(2.0 * result.steps * result.step_tolerance, ACCEPTED * size))
    # what it began with, or a step has left, stays
    worst, level = -1, float(depth[0]) if any(note.startswith(CONTINUED) for note in result.notes) else 0.0
    for k in range(len(depth)):
        if depth[k] <= level + NOISE * size:
            continue
        if depth[k] <= reach[k] and _pushed(result, k):
            level = float(depth[k])
        elif not depth[k] <= allowed and not (worst >= 0 and depth[k] <= depth[worst]):
            worst = k
    if worst < 0:
        return None
    law = _deepest(result, worst)
    where = f"contact {result.contact_names[law]!r}" if law >= 0 else ""
    fixed = step > 0.0 and not result.step_tolerance > 0.0
    shorter = f"take steps of {step * SUNK * size / depth[worst]:.2g} s, which leave a thousandth" if fixed else TIGHTER
    clause = f"{where or 'a contact'} penetrates by {_told(depth[worst], size, result.times[worst])}"
    return Alarm(clause, "penetration", where, float(result.times[worst]), float(depth[worst]), shorter)


def _told(value: float, size: float, time: float) -> str:
    """How much, and when."""
    return f"{with_unit(float(value), 'm')} at t = {time:.6g} s, which is large for a scene of {with_unit(size, 'm')}"


def _speeds(result: Result) -> FloatArray:
    """(m,) largest speed of a point of a body [m/s] at each stored instant and the one before."""
    assert result.compiled is not None
    with np.errstate(all="ignore"):  # a run that went astray is judged by that
        speeds = Units(result.compiled.model, result.u.shape[1]).of(result.u).max(axis=1, initial=0.0)
    # two bodies may approach each other
    return np.asarray(2.0 * np.maximum(speeds, np.concatenate([speeds[:1], speeds[:-1]])))


def _pushed(result: Result, k: int) -> bool:
    """Whether what was deepest about stored instant k was held: what is pushed out without an impulse was missed."""
    law = _deepest(result, k)
    before, after = max(k - 1, 0), min(k + 1, len(result.times) - 1)
    return law >= 0 and bool(result.impulse[after, law, 0] > result.impulse[before, law, 0])


def _deepest(result: Result, k: int) -> int:
    """The contact that was deepest at stored instant k, or took most impulse before it; -1 where none was."""
    rigid = ~np.isin(result.contact_names, result.compliant)
    depth = np.where(rigid & np.isfinite(result.gap[k]), -result.gap[k], -np.inf)
    if depth.size and depth.max() >= SEEN * result.penetration[k]:
        return int(depth.argmax())
    taken = np.where(rigid, result.impulse[k, :, 0] - result.impulse[max(k - 1, 0), :, 0], 0.0)
    return int(taken.argmax()) if taken.max(initial=0.0) > 0.0 else -1


def worst_drift(result: Result, size: float) -> Alarm | None:
    """The largest drift of joints that is large for bodies of ``size`` [m]; None without any."""
    drift = result.joint_drift
    if not len(drift) or drift.max() <= SUNK * size:
        return None
    k = int(drift.argmax())
    name = _off(result, k)
    where = f"joint {name!r}" if name else ""
    clause = f"{where or 'a joint'} has drifted by {_told(drift[k], size, result.times[k])}"
    return Alarm(
        clause,
        "joint drift",
        where,
        float(result.times[k]),
        float(drift[k]),
        FINER,
    )


def _off(result: Result, k: int) -> str:
    """The joint that is violated most at stored instant k; empty where it is no longer."""
    from lcpflex.kinematics.joint_rows import joint_residual  # kernels that few results need

    compiled = result.compiled
    if compiled is None or not compiled.layout.joints or not np.isfinite(result.q[k]).all():
        return ""
    if compiled.n_external and not compiled.callbacks:  # of a file, which holds no functions
        return ""
    model: Any = pack(compiled.model)
    t, q, external = float(result.times[k]), result.q[k].copy(), np.zeros((compiled.n_external, 3))
    try:
        state = compiled.state(t, q, result.u[k].copy())
        for callback in compiled.callbacks:
            callback.fill(t, state, external)
    except Exception:  # what is wrong with a function of the user is told by the run
        return ""
    off = np.zeros(int(model.joints.row[-1]))
    joint_residual(model, t, q, external, off)
    own = int(np.abs(off).argmax())
    if not abs(off[own]) >= SEEN * float(result.joint_drift[k]):
        return ""
    return compiled.layout.joints[int(np.searchsorted(model.joints.row, own, side="right")) - 1]
