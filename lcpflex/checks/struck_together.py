"""Contacts that share a body and touch as one of them is struck: the impact law alone decides what comes of it.

Struck at once by Newton's law, or one after another, they leave with other speeds (the balls of a cradle that touch,
a ball on a box that stands on a floor), and no gap tells which comes first. Contacts that close one after another are
no such case, however near to each other. Looked at are declared contacts at stored instants.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.layout import is_spatial
from lcpflex.results.result import Result

__all__ = ["bodies_of_laws", "neighbours", "strikes", "struck_together"]

CLOSED = 1e-8  # of the size of the scene: gaps of contacts that touch, as places are told
BACK = 2  # instants to look back: that of an event may be stored twice before it
MOST = 400  # strikes that are looked at, the first ones

Mask = np.ndarray[Any, np.dtype[np.bool_]]


def bodies_of_laws(model: Any, laws: int) -> IntArray:
    """(laws, 2) bodies of each declared contact, -1: the ground."""
    contacts, body = model.contacts, np.asarray(model.contacts.surface_body)
    if is_spatial(model):
        return np.asarray(body[np.asarray(contacts.law_surface)])
    pair = np.full((laws, 2), -1)
    pair[contacts.pass_law, 0], pair[contacts.pass_law, 1] = body[contacts.pass_node], body[contacts.pass_feature]
    return pair


def struck_together(result: Result) -> tuple[str, ...]:
    """A note where a contact with restitution is struck while another one of its bodies touches; none else."""
    compiled = result.compiled
    if compiled is None or len(result.times) < 2:
        return ()
    gap, struck, closed = strikes(result)
    rows, cols = (index[:MOST] for index in np.nonzero(struck))
    if not len(rows):
        return ()
    laws = gap.shape[1]
    pushed = np.diff(result.impulse[:, :laws, 0], axis=0) > 0.0
    own = np.where(np.isfinite(gap[rows, cols]), gap[rows, cols], np.nan)[:, None]  # too far off then to be measured
    together = (before(gap)[rows] <= closed) | (pushed[rows] & (np.abs(gap[rows] - own) <= closed))
    rigid = ~np.isin(result.contact_names, result.compliant)
    together &= neighbours(bodies_of_laws(compiled.model, laws))[cols] & rigid
    found = np.flatnonzero(together.any(axis=1))
    if not len(found):
        return ()
    k = int(found[0])
    first, other = (repr(result.contact_names[law]) for law in (int(cols[k]), int(together[k].argmax())))
    taken = "one after another, the fastest first" if "sequential=True" in result.stepper else "at once"
    return (
        f"contacts {first} and {other} share a body and both touched as one was struck, first at t = "
        f"{result.times[rows[k] + 1]:.6g} s: struck at once or one after another they leave at other speeds, which no "
        f"gap decides but the impact law; here they were struck {taken} (EventDriven(impact=Newton(sequential=...)) "
        "takes either; a small gap between the bodies decides, too)",
    )


def before(gap: FloatArray) -> FloatArray:
    """(instants - 1, laws) largest gap of the instants up to each [m]."""
    at = np.arange(len(gap) - 1)
    return np.asarray(np.maximum.reduce([gap[np.maximum(at - back, 0)] for back in range(BACK + 1)]))


def strikes(result: Result) -> tuple[FloatArray, Mask, float]:
    """Gaps at stored instants [m], which contacts were struck from each to the next, and how near ones touch [m].

    Struck are contacts with restitution that were open, and have an impulse then.
    """
    laws = len(result.contact_names)
    gap = np.nan_to_num(result.gap[:, :laws], nan=np.inf)
    closed = CLOSED * _size(result)
    if result.compiled is None or laws < 2:
        return gap, np.zeros((len(gap) - 1, laws), dtype=bool), closed
    rebounds = np.asarray(result.compiled.model.contacts.restitution)[:laws] > 0.0
    rebounds &= ~np.isin(result.contact_names, result.compliant)
    if not rebounds.any():
        return gap, np.zeros((len(gap) - 1, laws), dtype=bool), closed
    pushed = np.diff(result.impulse[:, :laws, 0], axis=0) > 0.0
    return gap, pushed & (before(gap) > closed) & rebounds, closed


def _size(result: Result) -> float:
    """Largest extent of a body [m], or of the places of touching points."""
    if result.compiled is None:
        return 1.0
    extent = np.asarray(result.compiled.model.contacts.surface_extent)
    return float(extent[np.isfinite(extent)].max(initial=0.0)) or 1.0


def neighbours(bodies: IntArray) -> Mask:
    """(laws, laws) whether two contacts share a body that moves."""
    shared = np.zeros((len(bodies), len(bodies)), dtype=bool)
    for i in range(2):
        for j in range(2):
            shared |= (bodies[:, i, None] == bodies[:, j]) & (bodies[:, i, None] >= 0)
    np.fill_diagonal(shared, False)
    return shared
