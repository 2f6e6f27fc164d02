"""Pairs that close within a step of a scheme with step control and that neither of its two results has met.

Both may pass over a short contact: it is open wherever they look. So pairs whose speeds leave room for it are followed
along the step, on the cubic that has the states and velocities of both ends. What closes there ends the next trial.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import RIGID, ContactTable, detect
from lcpflex.contact.narrow_phase.feature import foot_margin, node_margin, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.rows import gap_rate
from lcpflex.contact.table import entry_of
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.event_driven.gaps import END
from lcpflex.steppers.golden_section import LOOKS, begin_section, narrow, next_place
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.scheme import NEVER

__all__ = ["closed_pairs", "first_unmet", "unmet"]

TURN = 0.25  # [rad] by which a body turns in one part of a step, at most
MOST_PARTS = 32
HALVINGS = 60
ROUNDING = 1e-14  # of the largest coordinate


@in_space("lcpflex.steppers.spatial.unmet")
@kernel
def on_way(model: Model, q: FloatArray, u: FloatArray, h: float, share: float, kept: Backup) -> None:
    """Configuration at a share of the step from what is kept to (q, u), into ``kept.at``."""
    left = 1.0 - share
    part = share * share * (3.0 - 2.0 * share)
    first = h * share * left * left
    last = h * share * share * left
    for i in range(len(q)):
        kept.at[i] = kept.q[i] + part * (q[i] - kept.q[i]) + first * kept.u[i] - last * u[i]


@kernel
def gap_on_way(
    model: Model, q: FloatArray, u: FloatArray, h: float, share: float, kept: Backup, table: ContactTable, k: int,
    tolerance: float,
) -> float:  # fmt: skip
    """Gap of entry k at a share of the step; positive where the node is beside its feature: it comes in from there."""
    on_way(model, q, u, h, share, kept)
    refresh(model, kept.at, table, k)
    gap = table.gap[k]
    if min(foot_margin(model, kept.at, table, k), node_margin(model, kept.at, table, k)) < -SPAN_TOLERANCE:
        return abs(gap) + tolerance
    return gap


@kernel
def lowest(
    model: Model, q: FloatArray, u: FloatArray, h: float, kept: Backup, table: ContactTable, k: int, low: float,
    high: float, sign: float, level: float, tolerance: float,
) -> float:  # fmt: skip
    """Share in (low, high) at which ``sign`` times the gap of entry k is below ``level``, by golden sections.

    The lowest that was found, if it is nowhere.
    """
    section = kept.section
    begin_section(section, low, high)
    for _ in range(LOOKS):
        share = next_place(section)
        f = sign * gap_on_way(model, q, u, h, share, kept, table, k, tolerance)
        if f < level:
            return share
        narrow(section, f)
    return section.c if section.f_c < section.f_d else section.d


@kernel
def closing_share(
    model: Model, q: FloatArray, u: FloatArray, h: float, kept: Backup, table: ContactTable, k: int, low: float,
    high: float, room: float, tolerance: float, dip: float,
) -> float:  # fmt: skip
    """Share in (low, high] just behind which the gap of entry k falls below zero, by more than ``dip`` then; or NEVER.

    ``room`` [m]: by how much both ends of this part of the step may be open together for the pair to close within.
    """
    f_low = gap_on_way(model, q, u, h, low, kept, table, k, tolerance)
    f_high = gap_on_way(model, q, u, h, high, kept, table, k, tolerance)
    if not f_low + f_high < room:
        return NEVER
    step = END * (high - low)
    sign = 1.0
    level = -dip
    if f_low <= tolerance:  # closed at the start: it must open first
        if f_high >= -dip:
            return NEVER
        sign = -1.0
        level = -tolerance
    elif f_high >= -dip:
        late = gap_on_way(model, q, u, h, high - step, kept, table, k, tolerance)
        early = gap_on_way(model, q, u, h, low + step, kept, table, k, tolerance)
        if late >= f_high or early > f_low:
            return NEVER
    if sign < 0.0 or f_high >= -dip:
        share = lowest(model, q, u, h, kept, table, k, low, high, sign, level, tolerance)
        if sign * gap_on_way(model, q, u, h, share, kept, table, k, tolerance) >= level:
            return NEVER
        if sign < 0.0:
            low = share
        else:
            high = share
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        if not low < share < high:
            break
        if gap_on_way(model, q, u, h, share, kept, table, k, tolerance) > 0.0:
            low = share
        else:
            high = share
    return high


@kernel
def met(work: Workspace, table: ContactTable, k: int, gap: float, dip: float) -> bool:
    """Whether the node of entry k carried something no less deep in another feature, or was found as compliant."""
    for i in range(work.rows.n_contacts):
        if work.impulses.p[work.rows.n_joint + i] <= 0.0:
            continue
        same = work.rows.table.law[i] == table.law[k] and work.rows.table.node[i] == table.node[k]
        if same and gap > min(work.rows.table.gap[i], 0.0) - dip:
            return True
    compliant = work.compliant
    if len(compliant.friction) > 0:
        for i in range(compliant.rows.n_contacts):
            if compliant.rows.table.law[i] == table.law[k] and compliant.rows.table.node[i] == table.node[k]:
                return True
    return False


@in_space("lcpflex.steppers.spatial.unmet")
@kernel
def fastest(model: Model, u: FloatArray, recorder: Recorder) -> float:
    """Largest speed of a point of a surface [m/s], at most; infinite where bodies are unknown."""
    largest = math.inf if len(model.bodies.mass) == 0 else 0.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        modal = 0.0
        for m in range(d + N_RIGID, model.bodies.dof[b + 1]):
            modal += abs(u[m])
        speed = math.hypot(u[d], u[d + 1]) + recorder.farthest * abs(u[d + 2]) + recorder.deflection[b] * modal
        largest = max(largest, speed)
    return largest


@in_space("lcpflex.steppers.spatial.unmet")
@kernel
def parts_of(model: Model, h: float, speed: float, u: FloatArray, kept: Backup) -> int:
    """Into how many parts a step is divided: in each, bodies turn little and travel less than the smallest surface."""
    most = 1.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        most = max(most, h * max(abs(u[d + 2]), abs(kept.u[d + 2])) / TURN)
    for extent in model.contacts.surface_extent:
        if extent > 0.0:
            most = max(most, 0.5 * h * speed / extent)
    return math.ceil(min(most, float(MOST_PARTS)))


@kernel
def first_unmet(
    model: Model, h: float, q: FloatArray, u: FloatArray, tolerance: float, work: Workspace, recorder: Recorder,
    kept: Backup,
) -> float:  # fmt: skip
    """Share of the step from what is kept to (q, u) at which a pair first closes that was not met; above 1: none.

    A negative number: the table of the recorder must hold as many entries.
    """
    if len(model.contacts.friction) == 0:
        return NEVER
    table = recorder.table
    speed = max(fastest(model, kept.u, recorder), fastest(model, u, recorder))
    if speed == 0.0:
        return NEVER
    largest = 0.0
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
    dip = max(tolerance, ROUNDING * largest)
    parts = parts_of(model, h, speed, u, kept)
    room = 2.0 * speed * h / parts
    for part in range(parts):
        low = part / parts
        high = (part + 1) / parts
        on_way(model, q, u, h, low, kept)
        n = detect(model, kept.at, room, table)
        if n > len(table.key):
            return -float(n)
        first = NEVER
        last = 0
        for k in range(n):
            present = entry_of(work.rows.table.key, work.rows.n_contacts, table.key[k], last)
            last = present + 1 if present >= 0 else last
            # one that the last problem gave an impulse; one that it had without may have been on the way out
            if present >= 0 and work.impulses.p[work.rows.n_joint + present] > 0.0:
                continue
            now = table.gap[k]
            gap = gap_on_way(model, q, u, h, high, kept, table, k, tolerance)
            if now + gap < room and not met(work, table, k, gap, dip):
                share = closing_share(model, q, u, h, kept, table, k, low, high, room, tolerance, dip)
                first = min(first, share)
        if first <= 1.0:
            return first
    return NEVER


@kernel
def closed_pairs(
    model: Model, q: FloatArray, u: FloatArray, tolerance: float, work: Workspace, recorder: Recorder, kept: Backup
) -> tuple[float, float, float]:
    """Of rigid pairs closed at q: deepest penetration [m], fastest approach of those that the last problem did
    not hold, and by how much the last step changed a gap rate at most [m/s].
    """
    table = recorder.table
    sunk = 0.0
    approach = 0.0
    pull = 0.0
    last = 0
    n = detect(model, q, tolerance, table)
    for k in range(min(n, len(table.key))):
        if len(table.compliant) > 0 and table.compliant[table.law[k]] != RIGID:
            continue
        sunk = max(sunk, -table.gap[k])
        rate = gap_rate(model, q, u, table, k)
        pull = max(pull, abs(rate - gap_rate(model, q, kept.u, table, k)))
        present = entry_of(work.rows.table.key, work.rows.n_contacts, table.key[k], last)
        if present >= 0:
            last = present + 1
        else:
            approach = max(approach, -rate)
    return sunk, approach, pull


@kernel
def unmet(model: Model, q: FloatArray, compliant: CompliantContacts, table: ContactTable) -> float:
    """Deepest indentation at q [m] of compliant pairs that did not touch where forces were last taken."""
    if len(compliant.friction) == 0:
        return 0.0
    touching = 0.0
    count = detect(model, q, touching, table)
    sunk = 0.0
    for k in range(min(count, len(table.key))):
        known = table.compliant[table.law[k]] == RIGID
        for i in range(compliant.rows.n_contacts):
            known = known or (
                compliant.rows.table.law[i] == table.law[k] and compliant.rows.table.node[i] == table.node[k]
            )
        if not known:
            sunk = max(sunk, -table.gap[k])
    return sunk
