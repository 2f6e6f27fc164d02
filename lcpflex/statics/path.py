"""The quasi-static path: how a scene comes to rest when nothing but damping resists its motion.

Of M alpha dq = h + J^T mu + W lambda, an overdamped motion, each step is implicit: with the tangent stiffness K

    (alpha M + K) dq = h + J^T mu + W_N lambda_N + W_T lambda_T,    J dq = -phi,
    0 <= g + W_N^T dq  _|_  lambda_N >= 0,    -lambda_T in mu lambda_N Sign(W_T^T dq)

the contact problem of a step of Moreau and Jean at position level, without velocities. Steps are short against the
bodies, so that no surface is stepped over; 1/alpha grows as the forces come into balance, and the step becomes that of
Newton's method. Which of several places of rest is found follows from the start. Contacts that stick stay where they
are in each step.

Sources: Moreau 1988 (the step); Josephy 1979 (Newton's method for inclusions); Kelley & Keyes 1998 (pseudo-transient
continuation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lcpflex.basics.progress import look
from lcpflex.basics.stopwatch import Budget
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Balance, Configuration
from lcpflex.statics.damping import Damping
from lcpflex.statics.resistance import Factor, Resistance
from lcpflex.statics.scales import Scales, acting, softest
from lcpflex.statics.slip import Slip
from lcpflex.statics.step_contacts import StepContacts, is_many
from lcpflex.statics.tangent import tangent_stiffness

__all__ = ["Multipliers", "Path", "Station"]

Multipliers: TypeAlias = Mapping[tuple[int, int], float]

SHORT = 0.2  # of the extent of the smallest body: longest step
LEAST_DAMPING = 1e-6  # of (largest force) / (mass size): what neutral directions are held by
SLOWLY = 0.01  # of the first alpha of a path: that of one from a place of rest, from which on all changes slowly
WRONG = 0.3  # of the change of the forces: what the linearisation of a step may leave out
SUNK = 0.05  # of the length of a step: by how much more than before bodies may overlap at its end
ROUNDING = 1e-12  # of the size
NOTHING = 1e-9  # of the size: a gap that counts as closed where a place of rest is refined
TINY = 1e-3  # of the longest step: a shorter one is made whatever it leaves out
KEPT = 1e-3  # of the largest force on the path so far: where forces come to nothing, it is what is compared with
STIFF = 0.9  # of the length before: a step that more damping leaves longer is one that overlaps ask for
ROUGH, FREELY = 1e-2, 0.1  # residual and step, of the longest: above them damping is what holds many contacts
UNTOLD = 1e-16  # of the size: displacement of the softest spring or mode whose force is none
INDEPENDENT = 1e-12  # of the largest eigenvalue: redundant joint rows


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A configuration on the path with the multipliers found on the way to it."""

    at: Configuration
    p: FloatArray  # multipliers of the rows of ``at``
    scale: float  # largest force that acts [N]
    residual: float  # largest force that is not balanced, relative to it, or overlap, relative to the size
    travelled: float  # [m]
    step: FloatArray  # (ndof,) the last one


class Path:
    """A path, advanced step by step.

    Parameters
    ----------
    balance, scales, q
        Forces and rows of a scene, how large they are, and where the path begins (nq,).
    known
        Multipliers of a place of rest that it begins at: damping is less then, which would hold back
        what a drive moves, and friction counts slip from there on.
    """

    def __init__(self, balance: Balance, scales: Scales, q: FloatArray, known: Multipliers | None = None) -> None:
        self.balance, self.scales = balance, scales
        self.longest = SHORT * float(scales.extent.min())
        self.soft = softest(balance.model, scales)
        self.largest = 0.0  # force on the path so far [N]
        self.station = self._station(q, known or {}, 0.0, np.zeros(len(scales.arm)))
        self.told = known is None  # whether contacts stick and slip as on this path, and not as on the way to its start
        self._damping, self._first = Damping(self.longest), 1.0 if known is None else SLOWLY
        self._slip = Slip(balance, known is not None)
        self._contacts = StepContacts(dict(known or {}))

    def advance(self, budget: Budget | None = None) -> bool:
        """One step; False where none can be made, or the budget is spent."""
        here = self.station
        M = mass_matrix(self.balance.model, here.at.q)
        many = is_many(here.at)
        K = self._stiffness(here, many)
        resistance = Resistance(M, K, self.scales.arm)
        masses = self.balance.model.bodies.mass
        off = self.soft * self.scales.size * self.scales.off(here.at)  # what joints and drives are about to load
        most = max(here.scale, self.scales.force(here.at.force), off)
        rate = most / (float(masses.max()) * self.scales.size) or 1.0  # without a force any damping will do
        least = LEAST_DAMPING * rate
        patient = many and here.at.d == 1 and self.balance.push is None  # in space all is tried at once
        alpha = self._damping.begin(self._first * rate, least, patient)
        slid = self._slip.so_far(here.at)
        part, before = 1.0, math.inf  # of overlaps, as much as is closed in the step
        for _ in range(100):
            look()
            if budget is not None and budget.is_spent:
                return False
            found = self._step(here, resistance.factor(alpha), slid, part, not self._damping.is_patient)
            if found is None and self.balance.push is not None:
                return False  # contacts are in the way of the push, whatever the damping
            length = self.scales.moved(found[0]) if found is not None else math.inf
            if self.longest < length < math.inf and length > STIFF * before:  # no damping makes it shorter
                part *= 0.5 * self.longest / length
            before = length
            if found is not None and length <= self.longest and self._good(here, M, K, alpha, *found):
                self._damping.make(alpha, length, least, many)
                self._go(*found)
                return True
            alpha = self._damping.refuse(alpha, length, many)
        return False

    def _stiffness(self, here: Station, many: bool) -> FloatArray:
        """K of a step, symmetric.

        Of many contacts without what their forces do to it where steps are long: that couples bodies through contacts,
        without it their problems are sparse. What a step leaves out is judged as of others.
        """
        p = here.p
        if many and here.residual > ROUGH and self.scales.moved(here.step) > FREELY * self.longest:
            p = np.where(np.arange(len(p)) < here.at.n_joint, p, 0.0)
        K = tangent_stiffness(self.balance, self.scales, here.at.q, p)
        return 0.5 * (K + K.T)

    def scale(self, at: Configuration, p: FloatArray) -> float:
        """The force that residuals at a place on the path are relative to [N]."""
        acts = acting(self.balance, self.scales, at, p)
        self.largest = max(self.largest, acts)
        return max(acts, KEPT * self.largest, UNTOLD * self.soft * self.scales.size)

    def _go(self, dq: FloatArray, p: FloatArray) -> None:
        """To the end of a step."""
        here = self.station
        known, moved = self.multipliers(here.at, p), self.scales.moved(dq)
        self.told = True
        self._slip.add(here.at, dq, p, moved)
        self.station = self._station(self.balance.moved(here.at.q, dq), known, here.travelled + moved, dq)

    def slip(self, at: Configuration) -> FloatArray:
        """(m,) slip of the tangents of ``at`` since the place of rest that the path begins at [m]; 0 of any other path.

        ``at`` was looked at last, and is near the station.
        """
        return self._slip.there(at, self.balance.difference(at.q, self.station.at.q))

    def back(self) -> None:
        """Look at the contacts of the last station again, after others have been looked at."""
        self.balance.look(self.station.at.q, 2.0 * self.longest)

    def _station(self, q: FloatArray, known: Multipliers, travelled: float, dq: FloatArray) -> Station:
        """At q, with the multipliers that are known by their keys, 0 of other contacts."""
        at = self.balance.look(q, 2.0 * self.longest)
        p = np.array([known.get(key, 0.0) for key in self._keys(at)])
        scale = self.scale(at, p)
        left = self.scales.force(at.force + at.rows.T @ p)
        residual = left / scale if scale > 0.0 else 0.0
        violated = max(self.scales.off(at), -float(at.gap.min(initial=0.0)) / self.scales.size)
        return Station(at, p, scale, max(residual, violated), travelled, dq)

    def multipliers(self, at: Configuration, p: FloatArray) -> Multipliers:
        """The multipliers p of the rows of ``at``, which was looked at last, by keys that outlive it."""
        return dict(zip(self._keys(at), p.tolist(), strict=True))

    def _keys(self, at: Configuration) -> list[tuple[int, int]]:
        """Of the rows of joints, normals and tangents, the same from step to step."""
        own = self.balance.work.rows.table.key[: at.n_contacts].tolist()
        joints = [(0, r) for r in range(at.n_joint)]
        return joints + [(1, key) for key in own] + [(2 + j % at.d, own[k]) for j, k in enumerate(at.tangent.tolist())]

    def _step(
        self, here: Station, factor: Factor, slid: FloatArray, part: float, thorough: bool
    ) -> tuple[FloatArray, FloatArray] | None:
        """dq and the multipliers of all rows; None where the contact problem is not solved.

        ``thorough``: whatever it takes.
        """
        at, arm = here.at, self.scales.arm
        white, load = factor.whitened((at.rows / arm).T), factor.whitened(at.force / arm)
        n_joint = at.n_joint
        J, W = white[:, :n_joint], white[:, n_joint:]
        size = np.linalg.norm(J, axis=0)  # rows of rad and m, made alike
        unit = np.diag(1.0 / np.where(size > 0.0, size, 1.0))
        inverse = unit @ np.linalg.pinv(unit @ J.T @ J @ unit, rcond=INDEPENDENT, hermitian=True) @ unit
        phi = self._share(factor.moved(J @ (inverse @ at.phi))) * at.phi
        free = load - J @ (inverse @ (J.T @ load + phi))
        held = (W - J @ (inverse @ (J.T @ W))).T
        target = np.concatenate([np.maximum(np.where(at.gap < 0.0, part, 1.0) * at.gap, -0.5 * self.longest), slid])
        p = np.zeros(len(at.rows))
        if at.n_contacts:
            keys, still = self._keys(at)[n_joint:], W.T @ free
            forces = self._contacts.forces(at, keys, held, still + target, thorough)
            if forces is None and thorough:  # gaps of rounding may ask heavy bodies for more than light ones weigh
                target[: at.n_contacts][np.abs(at.gap) <= NOTHING * self.scales.size] = 0.0
                forces = self._contacts.forces(at, keys, held, still + target, thorough)
            if forces is None:
                return None
            p[n_joint:] = forces
        white_dq = free + held.T @ p[n_joint:]
        p[:n_joint] = -inverse @ (J.T @ (load + W @ p[n_joint:]) + phi)
        return factor.moved(white_dq) / arm, p

    def _share(self, closing: FloatArray) -> float:
        """Of what joints and drives are off, as much as half a step closes; ``closing`` is the motion that closes all.

        It is in metres, (ndof,).
        """
        whole = float(np.abs(closing).max(initial=0.0))
        return min(1.0, 0.5 * self.longest / whole) if whole > 0.0 else 1.0

    def _good(self, here: Station, M: FloatArray, K: FloatArray, alpha: float, dq: FloatArray, p: FloatArray) -> bool:
        """Whether the forces and gaps at the end of a step are those that its linearisation foresaw."""
        moved = self.scales.moved(dq)
        damping = alpha * (M @ dq)
        missed = self.balance.pull(self.balance.moved(here.at.q, dq), p) - damping
        gaps = self.balance.work.rows.table.gap[: here.at.n_contacts]
        sunk = float(np.max(np.minimum(here.at.gap, 0.0) - gaps, initial=0.0))
        if sunk > SUNK * moved + ROUNDING * self.scales.size:
            return False
        change = self.scales.force(damping) + self.scales.force(K @ dq)
        return moved <= TINY * self.longest or self.scales.force(missed) <= WRONG * change + 1e-9 * here.scale
