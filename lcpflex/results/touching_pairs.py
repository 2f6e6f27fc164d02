"""The pair of features that a stored touching point belongs to: what tells the material that its force acts on."""

from __future__ import annotations

from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near
from lcpflex.contact.rows import contact_point
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.results.contact_history import ContactPoints

__all__ = ["TouchingPair", "TouchingPairs"]

NEAR = (1e-3, 1e-2, 1e-1)  # of the size of the scene: pairs among which one that presses is looked for
TURNED = 0.1  # of the size of the scene: as far as a normal that is turned by 1 rad is another pair


class TouchingPair(NamedTuple):
    """An entry of a table of near contacts."""

    table: Any  # ContactTable, or SpatialContactTable
    k: int
    side: float  # 1 where stored normals and forces are those of body i of the entry, -1 where they are those of body j
    margin: float  # up to which gaps are near in that table [m]


class TouchingPairs:
    """Pairs near each other in a packed model at (t, q): one search serves all touching points of an instant."""

    def __init__(self, compiled: CompiledScene, model: Any, t: float, q: FloatArray) -> None:
        self._compiled, self._model, self._t, self._q = compiled, model, t, q
        self._tables: dict[float, tuple[Any, int]] = {}

    def of(self, touching: ContactPoints, c: int) -> TouchingPair:
        """Of the touching point c: the pair of its contact which is nearest, and has its normal.

        Raises
        ------
        ModelError
            Where no pair of that contact is near the point any more.
        """
        size, law = self._compiled.size, int(touching.contact[c])
        for share in NEAR:
            table, found = self._near(share * size)
            own = np.flatnonzero(np.asarray(table.law)[:found] == law)
            if len(own):
                side = self._sides(table, own, law)
                places = np.array([contact_point(self._model, self._q, table, i) for i in own.tolist()])
                away = _sizes(places - touching.place[c])
                turned = _sizes(side[:, None] * np.asarray(table.normal)[own] - touching.normal[c])
                best = int((away + TURNED * size * turned).argmin())
                if away[best] <= share * size:
                    return TouchingPair(table, int(own[best]), float(side[best]), share * size)
        raise ModelError(
            f"result: the contact {self._compiled.layout.contacts[law]!r} carries a force at t = {self._t:.6g} s, "
            "where its surfaces are not near each other any more; expected shorter steps"
        )

    def _near(self, margin: float) -> tuple[Any, int]:
        if margin not in self._tables:
            self._tables[margin] = near(self._model, self._q, margin)
        return self._tables[margin]

    def _sides(self, table: Any, own: IntArray, law: int) -> FloatArray:
        """(k,) sides of entries: in space forces are those on the body of the first surface, whichever that is."""
        contacts = self._compiled.model.contacts
        if not self._compiled.spatial:
            return np.ones(len(own))
        first = int(contacts.surface_body[int(contacts.law_surface[law, 0])])
        return np.where(np.asarray(table.body)[own, 0] == first, 1.0, -1.0)


def _sizes(vectors: FloatArray) -> FloatArray:
    """(k,) of vectors (k, 2) or (k, 3)."""
    found: FloatArray = reduce(np.hypot, vectors.T)
    return found
