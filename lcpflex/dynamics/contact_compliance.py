"""Contacts that give way by themselves: an elastic law between two surfaces, in the problem at position level.

    0 <= lambda_N  _|_  g + F lambda + delta(lambda_N) >= 0,   delta: inverse of the elastic law F(delta)

Newton's method, one LCP a pass: the law is replaced by its tangent at the indentation d = -g of the configuration of
the last pass, that is by the compliance 1/k(d) and an indentation of d - F(d)/k(d) without force. Indentations are what
goes from pass to pass, not forces: seen as functions of them, gaps are convex, so that a pass never falls short of the
solution by more than it is away from it, and a contact with d > 0 that a tangent opens is found closed by the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.laws.elastic_kernels import elastic_force, elastic_stiffness, stored_energy
from lcpflex.contact.laws.layout import END, LIMIT, PARAMETERS, LawRow
from lcpflex.dynamics.workspace import Workspace
from lcpflex.packed import pack

__all__ = ["ContactCompliance", "compliance_energy", "contact_compliance", "misfit", "note_depths", "soften"]

ACCURATE = 1e-9  # error of a force, relative to the largest of those that laws give, that ends the passes
ROUNDING = 2e-15  # of an indentation, relative to coordinates
SHALLOW = 1e-3  # of the largest gap or indentation near: where the law of an open contact is linearised


class ContactCompliance(NamedTuple):
    """Elastic laws of the declared contacts that have one."""

    some: IntArray  # (1,) whether any has
    soft: IntArray  # (laws,) whether it has one
    kinds: IntArray  # (laws, 4), see lcpflex.contact.laws.layout
    parameters: FloatArray  # (laws, PARAMETERS)
    stop: FloatArray  # (laws,) indentation beyond which a run must not go on [m]
    worst: FloatArray  # (laws,) largest indentation of the steps so far [m]


def contact_compliance(rows: Sequence[LawRow | None]) -> ContactCompliance:
    """The laws ``rows`` of all declared contacts, None for those without, as kernels take them."""
    n = len(rows)
    arrays = ContactCompliance(
        some=np.zeros(1, dtype=np.int64),
        soft=np.zeros(n, dtype=np.int64),
        kinds=np.zeros((n, 4), dtype=np.int64),
        parameters=np.zeros((n, PARAMETERS)),
        stop=np.full(n, np.inf),
        worst=np.zeros(n),
    )
    for law, row in enumerate(rows):
        if row is not None:
            arrays.some[0] = arrays.soft[law] = 1
            arrays.kinds[law] = row.kinds
            arrays.parameters[law] = row.parameters
            arrays.stop[law] = row.parameters[END if row.lenient else LIMIT]
    return pack(arrays)


@kernel
def extent_of(q: FloatArray) -> float:
    """What the rounding of a gap is relative to [m]."""
    largest = 1.0
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
    return largest


@kernel
def soften(compliance: ContactCompliance, work: Workspace, n: int) -> None:
    """Add the laws, linearised about the present gaps of the first n contacts, to their Gc and bc [m/N, m]."""
    if compliance.some[0] == 0:
        return
    shallow = ROUNDING * extent_of(work.middle)
    largest = 0.0
    for k in range(n):
        largest = max(largest, abs(work.table.gap[k]))
    for k in range(n):
        law = work.table.law[k]
        if compliance.soft[law] == 1:
            depth = -work.table.gap[k]
            if depth <= shallow:
                depth = max(shallow, SHALLOW * largest)
            stiffness = elastic_stiffness(compliance.kinds[law], compliance.parameters[law], depth)
            force = elastic_force(compliance.kinds[law], compliance.parameters[law], depth)
            work.Gc[k, k] += 1.0 / stiffness
            work.bc[k] += depth - force / stiffness


@kernel
def misfit(compliance: ContactCompliance, unit: FloatArray, work: Workspace) -> float:
    """How far the forces of the present solution are from those of the laws; up to 1: equal as far as can be."""
    if compliance.some[0] == 0:
        return 0.0
    largest = 0.0
    for k in range(work.step_size[1]):
        if compliance.soft[work.table.law[k]] == 1:
            largest = max(largest, work.normal[k])
    allowed = ACCURATE * largest + work.certificate[0] * unit[0]
    rounding = ROUNDING * extent_of(work.middle)
    worst = 0.0
    for k in range(work.step_size[1]):
        law = work.table.law[k]
        if compliance.soft[law] == 1:
            depth = -work.table.gap[k]
            force = 0.0
            stiffness = elastic_stiffness(compliance.kinds[law], compliance.parameters[law], max(depth, rounding))
            if depth > 0.0:
                force = elastic_force(compliance.kinds[law], compliance.parameters[law], depth)
            worst = max(worst, abs(work.normal[k] - force) / (allowed + rounding * stiffness))
    return worst


@kernel
def note_depths(compliance: ContactCompliance, work: Workspace) -> int:
    """Keep the largest indentation of each law; returns the first that has left its range, or -1."""
    if compliance.some[0] == 1:
        for k in range(work.step_size[1]):
            law = work.table.law[k]
            if compliance.soft[law] == 1 and -work.table.gap[k] > compliance.worst[law]:
                compliance.worst[law] = -work.table.gap[k]
                if compliance.worst[law] > compliance.stop[law]:
                    return law
    return -1


@kernel
def compliance_energy(compliance: ContactCompliance, work: Workspace) -> float:
    """Energy that the laws store at the present gaps [J]."""
    total = 0.0
    if compliance.some[0] == 1:
        for k in range(work.step_size[1]):
            law = work.table.law[k]
            if compliance.soft[law] == 1 and work.table.gap[k] < 0.0:
                total += stored_energy(compliance.kinds[law], compliance.parameters[law], -work.table.gap[k])
    return total
