"""How far about the predicted configuration contacts are looked for in space.

Predicted static coordinates miss those of the solution by h^2 while contacts stay as they are, and nodes whose gap is
more than that have no part in the problem. How far surfaces have gone from where they were predicted is known behind
the solution: where that is more than what was looked for, contacts are looked for again, farther away.
"""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.position import sway
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["has_strayed", "look_around"]

ROOM = 2.0  # times what was needed: to look again costs a solution
FORGETS = 0.9  # part of the room that is left in the next step, at least


@kernel
def look_around(model: SpatialModel, scheme: Any, work: SpatialWork) -> float:
    """How far the static coordinates of ``work.free.middle`` may be from the solution [m]; these are kept."""
    for i in range(len(scheme.foreseen)):
        scheme.foreseen[i] = work.free.middle[i]
    return float(scheme.reach)


@kernel
def has_strayed(model: SpatialModel, scheme: Any, work: SpatialWork) -> bool:
    """Whether two surfaces have come closer than contacts were looked for; ``scheme.reach`` for the next look."""
    far = approach(model, scheme.flexibility, scheme.foreseen, work.free.middle)
    strayed = far > scheme.reach
    scheme.reach = ROOM * far if strayed else max(ROOM * far, FORGETS * scheme.reach)
    return bool(strayed)


@kernel
def approach(model: Any, flexibility: FloatArray, before: FloatArray, q: FloatArray) -> float:
    """Upper bound of how much nearer two surfaces come by their static coordinates as these go to those of q [m]."""
    first, second = 0.0, 0.0
    for s in range(len(model.contacts.surface_body)):
        way = sway(model, flexibility, s, before, q)
        if way > first:
            first, second = way, first
        elif way > second:
            second = way
    return first + second
