"""How many steps of one length the touches of compliant contacts take: too few of them do not see the force law."""

from __future__ import annotations

from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.force_laws.history import (
    ENOUGH,
    FEWEST,
    OF_ALL,
    OF_COARSE,
    OF_FEWEST,
    OF_LARGEST,
    OF_STEP,
    OF_TOUCH,
    STEPS,
    TIMES_STEPS,
)
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel

__all__ = ["note_touches"]

GRAZING = 0.1  # of the largest impulse: a touch of less tells nothing of how long touches are


@kernel
def note_touches(contacts: CompliantContacts, h: float) -> None:
    """Count a step of h [s] with the forces last found; contacts of one law count together, as of one touch."""
    touches = contacts.history.touches
    if len(touches) > 0 and (contacts.rows.n_contacts > 0 or touches[len(touches) - 1, STEPS] > 0.0):
        count_step(contacts, h, touches)


@late_kernel
def count_step(contacts: CompliantContacts, h: float, touches: FloatArray) -> None:
    """``note_touches`` where something touches, or did in the step before, which the last row tells."""
    last = len(touches) - 1
    for law in range(last):
        touches[law, OF_STEP] = 0.0
    for k in range(contacts.rows.n_contacts):
        touches[contacts.rows.table.law[k], OF_STEP] += h * contacts.p[k, 0]
    touches[last, STEPS] = 0.0
    for law in range(last):
        now = touches[law, OF_STEP]
        if now > 0.0:
            touches[law, STEPS] += 1.0
            touches[law, OF_TOUCH] += now
            touches[law, OF_ALL] += now
            touches[last, STEPS] += 1.0
        elif touches[law, STEPS] > 0.0:
            end_touch(touches[law])


@kernel
def end_touch(touch: FloatArray) -> None:
    """Close the account of a touch."""
    steps, impulse = touch[STEPS], touch[OF_TOUCH]
    if steps < ENOUGH:
        touch[OF_COARSE] += impulse
        touch[TIMES_STEPS] += steps * impulse
        touch[OF_LARGEST] = max(touch[OF_LARGEST], impulse)
        least = GRAZING * touch[OF_LARGEST]
        if touch[OF_FEWEST] < least or (impulse >= least and steps < touch[FEWEST]):
            touch[FEWEST] = steps
            touch[OF_FEWEST] = impulse
    touch[STEPS] = 0.0
    touch[OF_TOUCH] = 0.0
