"""Springs of a spatial scene that ended a run because they were twisted too far."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.jit.struct import pack
from lcpflex.model.layout import is_spatial

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["wound_spring"]

NEAR = 150.0  # [deg]: a step before 170, where springs have no force any more


def wound_spring(result: Result) -> str:
    """Words on the spring that is twisted most in the last state of a run; empty where none is by 150 degrees."""
    if result.compiled is None:
        return ""
    model, bodies = result.compiled.model, result.compiled.layout.bodies
    if not is_spatial(model) or not len(model.loads.spring_kind) or not np.isfinite(result.q[-1:]).all():
        return ""
    from lcpflex.dynamics.spatial.applied_forces import WOUND, spring_twist  # kernels that planar runs do without

    packed, state = pack(model), result.q[-1].copy()
    twists = np.degrees([spring_twist(packed, state, k) for k in range(len(model.loads.spring_kind))])
    worst = int(np.argmax(twists))
    if not twists[worst] >= NEAR:
        return ""
    ends = [bodies[b] if b >= 0 else "the ground" for b in model.points.body[model.loads.spring_point[worst]]]
    return (
        f". The torsion spring or bushing between {' and '.join(ends)} is twisted by {twists[worst]:.4g} degrees: it "
        f"has no force beyond {np.degrees(WOUND):.4g}, for a state in space does not tell whole turns"
    )
