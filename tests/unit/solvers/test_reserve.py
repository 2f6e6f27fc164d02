"""The forces farthest inside Coulomb's law of those that share a load in many ways."""

from __future__ import annotations

import pytest

from lcpflex.solvers.contact.cones.mixed_problem import fill_units, mixed_problem
from lcpflex.solvers.contact.cones.reserve import most_reserve


@pytest.mark.parametrize("contacts", [1, 3])
def test_forces_of_which_none_is_determined(contacts: int) -> None:
    """Contacts of a body that is held altogether: all forces and their reserve are unknown, in memory for just these.

    The reserve is at most all of the force pressed, and found but for half of it.
    """
    p = mixed_problem(contacts)
    p.n, p.m = contacts, 3 * contacts
    for c in range(contacts):
        p.at[c], p.friction[c], p.rests[c], p.r[c] = contacts + 2 * c, 0.5, 1, 1.0
    fill_units(p)
    assert len(p.step) == len(p.jacobian) > p.m
    assert 0.5 <= most_reserve(p, 1.0) <= 1.0
    assert p.x[:contacts] == pytest.approx(1.0, abs=0.5)
    assert p.x[contacts : 3 * contacts] == pytest.approx(0.0, abs=1e-9)
