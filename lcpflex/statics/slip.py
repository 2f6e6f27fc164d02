"""How far contacts have slipped since a place of rest: what Coulomb's law looks at when a load or drive goes slowly.

    -lambda_T in mu lambda_N Sign(s + W_T^T dq)

s is the slip of the steps so far, in space a vector in the plane of contact, kept in world axes. The steps that correct
what linearisation left out are small, and may go either way; without s a contact that slides would stick in the last of
them, with a force a few per cent below its limit. That is the implicit Euler rule of rate-independent friction, one
increment from rest to rest.

Source: Simo & Hughes 1998 (return mapping).
"""

from __future__ import annotations

import numpy as np

from lcpflex.contact.rows import contact_point
from lcpflex.jit.kernel import FloatArray
from lcpflex.statics.balance import Balance, Configuration

__all__ = ["Slip"]

NEAR = 1.5  # of the length of a step: a contact point that is no farther from one that was pressed is the same


class Slip:
    """The slip of each contact; nothing is added up where it is not ``counted``: then each step is a motion anew."""

    def __init__(self, balance: Balance, counted: bool) -> None:
        self._balance, self._counted = balance, counted
        self._by_key: dict[int, FloatArray] = {}  # (1,) along the tangent, in space (3,) world axes [m]
        self._pressed: list[tuple[int, FloatArray, FloatArray]] = []  # contact as declared, place, slip
        self._near = 0.0

    def so_far(self, at: Configuration) -> FloatArray:
        """(m,) s of the tangents of ``at``, which was looked at last [m]."""
        found = np.zeros(len(at.tangent))
        if not self._by_key:
            return found
        table = self._balance.work.rows.table
        for j in range(0, len(at.tangent), at.d):
            k = int(at.tangent[j])
            key = int(table.key[k])
            slip = self._by_key[key] if key in self._by_key else self._of_neighbour(at, k)
            found[j : j + at.d] = self._balance.tangents(k) @ slip
        return found

    def there(self, at: Configuration, dq: FloatArray) -> FloatArray:
        """(m,) s of the tangents of ``at``, which was looked at last, behind a last small step dq (ndof,) [m]."""
        if not self._counted:
            return np.zeros(len(at.tangent))
        return self.so_far(at) + at.rows[at.n_joint + at.n_contacts :] @ dq

    def add(self, at: Configuration, dq: FloatArray, p: FloatArray, moved: float) -> None:
        """A step dq (ndof,) from ``at``, which was looked at last, with the multipliers p and the length ``moved`` [m].

        A contact that lets go forgets.
        """
        if not self._counted:
            return
        table, r, n = self._balance.work.rows.table, at.n_joint, at.n_contacts
        slip = self.so_far(at) + at.rows[r + n :] @ dq
        self._by_key, self._pressed, self._near = {}, [], NEAR * moved
        for j in range(0, len(at.tangent), at.d):
            k = int(at.tangent[j])
            if p[r + k] > 0.0:
                vector = slip[j : j + at.d] @ self._balance.tangents(k)
                self._by_key[int(table.key[k])] = vector
                place = np.array(contact_point(self._balance.model, at.q, table, k))
                self._pressed.append((int(table.law[k]), place, vector))

    def _of_neighbour(self, at: Configuration, k: int) -> FloatArray:
        """Of the pressed contact that went on as contact k, on the next piece of its surface; 0 where there is none."""
        table = self._balance.work.rows.table
        place = np.array(contact_point(self._balance.model, at.q, table, k))
        near = [
            (float(np.hypot.reduce(place - there)), slip)
            for law, there, slip in self._pressed
            if law == int(table.law[k])
        ]
        distance, slip = min(near, key=lambda one: one[0], default=(np.inf, self._still))
        return slip if distance <= self._near else self._still

    @property
    def _still(self) -> FloatArray:
        """No slip."""
        return np.zeros(self._balance.tangents(0).shape[1])
