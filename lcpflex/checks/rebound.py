"""What a coefficient of restitution has come to on bodies with modes: the rebound comes from the modes, not from it.

Restitution acts on the velocities of the contact, and so on the mass next to it. A body with many modes has little
mass there: e returns the vibration, and the body rebounds as its modes have it, in several impacts. A collision is all
that a contact takes until it is left alone for the slowest vibration of its bodies; with m_r and m_c, the masses that
the contact meets in rigid bodies and in these ones, 1/m = w_N^T M^-1 w_N with the joints held,

    apparent restitution = sum of impulses / (m_r approach velocity) - 1,      share of the mass = m_c / m_r

A closing takes m_c of the energy m_r v^2 / 2 (1/(2 N + 1) for the end of a bar with N modes).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near, normal_row
from lcpflex.dynamics.mass_matrix import held_inverse, mass_matrix, slowest_vibrations
from lcpflex.dynamics.start import violation
from lcpflex.jit.struct import pack
from lcpflex.model.layout import dimension
from lcpflex.results.result import Result

__all__ = ["rebounds"]

LIGHT = 0.9  # m_c / m_r from which down modes decide
LOOKED_AT = 3  # contacts, those that were struck hardest
ALONE = 0.05  # of the impulse of a collision that other contacts may take meanwhile, if it is to tell anything


class Masses(NamedTuple):
    """What a contact meets [kg], in these bodies and in rigid ones, and its approach velocity [m/s]."""

    met: float
    rigid: float
    approach: float


class Collision(NamedTuple):
    """Stored instants before and after, the normal impulse [N s] in between, and when it is over at the latest."""

    first: int
    last: int
    impulse: float
    over: float  # [s]


def rebounds(result: Result) -> tuple[str, ...]:
    """A warning where contacts with e > 0 of bodies with modes have struck: of the hardest struck, what came out."""
    compiled = result.compiled
    if compiled is None or not np.isfinite(result.q).all():
        return ()
    restitution, compliant, struck = compiled.model.contacts.restitution, set(result.compliant), []
    pressed = np.asarray(result.impulse[-1:, :, 0].any(axis=0))
    for law in np.flatnonzero(pressed & (restitution[: len(pressed)] > 0.0)).tolist():
        if result.contact_names[law] not in compliant:
            collision = _hardest(result, compiled, law)
            if collision is not None:
                struck.append((law, collision))
    struck.sort(key=lambda one: -one[1].impulse)
    for law, collision in struck[:LOOKED_AT]:
        masses = _masses(result, compiled, law, collision)
        if masses is None or masses.met >= LIGHT * masses.rigid:
            continue
        name = result.contact_names[law]
        others = f" (one of {len(struck)} such)" if len(struck) > 1 else ""
        share = f"{100.0 * masses.met / masses.rigid:.2g} %"
        return (
            f"contact {name!r}{others}: restitution {restitution[law]:g} acts on the mass next to it, {share} of what "
            "it meets in rigid bodies (so much of the energy is all that a closing takes), and does not set the "
            f"rebound, which comes from the modes{_came(result, law, collision, masses)}",
        )
    return ()


def _came(result: Result, law: int, collision: Collision, masses: Masses) -> str:
    """What the rebound was, in words; empty where it is not over, or other contacts had a part in it."""
    if collision.over > result.times[-1]:
        return ""
    others = np.delete(result.impulse[[collision.first, collision.last], :, 0], law, axis=1)
    if not masses.approach > 0.0 or np.diff(others, axis=0).sum() > ALONE * collision.impulse:
        return ""
    apparent = collision.impulse / (masses.rigid * masses.approach) - 1.0
    return f"; its hardest collision ({collision.impulse:.3g} N s) was that of rigid bodies with e = {apparent:.2g}"


def _hardest(result: Result, compiled: CompiledScene, law: int) -> Collision | None:
    """The collision of a contact with most impulse; None between rigid bodies, and before the first instant."""
    c = compiled.model.contacts
    own = c.pass_law == law
    pair = c.surface_body[np.concatenate([c.pass_node[own], c.pass_feature[own]])]
    lasts = float(slowest_vibrations(compiled.model.bodies)[pair[pair >= 0]].max(initial=0.0))
    if lasts == 0.0:
        return None
    taken = np.diff(result.impulse[:, law, 0])
    found: list[Collision] = []
    for k in np.flatnonzero(taken > 0.0).tolist():
        first, impulse, over = k, float(taken[k]), float(result.times[k + 1]) + lasts
        if found and result.times[k] <= found[-1].over:
            before = found.pop()
            first, impulse = before.first, before.impulse + impulse
        found.append(Collision(first, k + 1, impulse, over))
    return max(found, key=lambda one: one.impulse, default=None)  # none of a run that begins with its impact


def _masses(result: Result, compiled: CompiledScene, law: int, collision: Collision) -> Masses | None:
    """At the begin of a collision; None where nothing is near."""
    q, u = result.q[collision.first].copy(), result.u[collision.first]
    model = pack(compiled.model)
    table, count = near(model, q, compiled.size)
    own = np.flatnonzero(table.law[:count] == law)
    if not len(own):
        return None
    row = normal_row(model, q, table, int(own[np.argmin(table.gap[own])]))
    M = mass_matrix(compiled.model, q)
    J = violation(compiled.model, q, np.zeros_like(u), np.zeros((compiled.n_external, 3))).jacobian
    rigid = (compiled.model.bodies.dof[:-1, None] + np.arange(dimension(compiled.model.bodies).rigid)).ravel()
    soft = float(row @ held_inverse(M, J) @ row)
    stiff = float(row[rigid] @ held_inverse(M[np.ix_(rigid, rigid)], J[:, rigid]) @ row[rigid])
    if not (soft > 0.0 and stiff > 0.0):
        return None
    return Masses(1.0 / soft, 1.0 / stiff, -float(row @ u))
