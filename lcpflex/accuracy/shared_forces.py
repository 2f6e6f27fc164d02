"""Whether forces of a run are a choice of its method: contacts that share a load in more ways than one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.checks.struck_together import bodies_of_laws
from lcpflex.compile.touched_pairs import pair_of
from lcpflex.results.words import SHARED

if TYPE_CHECKING:
    from lcpflex.accuracy.trials import Made
    from lcpflex.jit.kernel import IntArray
    from lcpflex.results.result import Result

__all__ = ["shares"]

THREE = 3  # points that carry a body, each its own part


def shares(made: Sequence[Made]) -> bool:
    """Whether forces of a run are not unique: by what it says, in space also by how many points a body stands on."""
    return any(SHARED in note for one in made for note in one.result.notes) or any(
        _stands_on_many(one.result) for one in made
    )


def _stands_on_many(result: Result) -> bool:
    """Whether a rigid body of space is pressed at more points than three by another one, with friction."""
    compiled, points = result.compiled, result.contact_points
    if compiled is None or not compiled.spatial or not len(points.record):
        return False
    pressed = (points.normal_force > 0.0) & (np.abs(points.friction_force).max(axis=1) > 0.0)
    ends = np.sort(_pairs(result)[points.contact[pressed]], axis=1)
    keys = np.column_stack([points.record[pressed], ends])
    count = np.unique(keys, axis=0, return_counts=True)[1]
    return bool((count > THREE).any())


def _pairs(result: Result) -> IntArray:
    """(contacts, 2) bodies of each contact that has touched, those under a rule, too; -1: the ground."""
    compiled = result.compiled
    assert compiled is not None
    declared = bodies_of_laws(compiled.model, len(compiled.layout.contacts))
    surfaces = np.asarray(compiled.model.contacts.surface_body)
    under = [pair_of(compiled, name) for name in result.contact_names[len(declared) :]]
    more = [surfaces[list(pair)] if pair else np.array([-2 - k, -2]) for k, pair in enumerate(under)]
    return np.concatenate([declared.reshape(-1, 2), np.asarray(more, dtype=np.int64).reshape(-1, 2)])
