"""How paths of many contacts choose their damping, and what of the stiffness their steps do without."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.basics.stopwatch import budgeted
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.statics import path as paths, step_contacts
from lcpflex.statics.damping import LEAST, LESS, MORE, MOST, Damping
from lcpflex.statics.equilibrium import stated
from lcpflex.statics.tangent import tangent_stiffness


def test_few_contacts_change_it_by_fixed_factors() -> None:
    damping = Damping(1.0)
    assert damping.begin(8.0, 1.0, False) == 8.0
    assert damping.refuse(8.0, 0.4, False) == damping.refuse(8.0, math.inf, False) == MORE * 8.0
    assert damping.refuse(8.0, 2.0, False) == pytest.approx(1.2 * 2.0 * 8.0)
    for length, expected in ((0.5, LESS * 8.0), (0.51, 8.0)):
        damping.make(8.0, length, 1.0, False)
        assert damping.begin(3.0, 1.0, False) == expected
    assert damping.begin(3.0, 20.0, False) == 20.0


def test_many_contacts_aim_at_steps_that_are_made_at_once() -> None:
    """Where the length of a step is 100 / alpha, and one beyond 0.5 is refused for what it leaves out."""
    damping, tries = Damping(1.0), []
    for _ in range(20):
        alpha, tried = damping.begin(1000.0, 1e-3, True), 1
        while 100.0 / alpha > 0.5:
            alpha, tried = damping.refuse(alpha, 100.0 / alpha, True), tried + 1
        damping.make(alpha, 100.0 / alpha, 1e-3, True)
        tries.append(tried)
    assert sum(tries) <= 1.5 * len(tries)  # the aim is halved, and grows again by half
    assert LEAST <= 100.0 / damping.begin(1.0, 1e-3, True) <= MOST


def test_many_contacts_give_damping_up_near_rest() -> None:
    damping = Damping(1.0)
    damping.make(8.0, 1e-3, 1e-3, True)
    assert damping.begin(1.0, 1e-3, True) == LESS * 8.0
    assert damping.begin(1.0, 1e-3, True) >= 1e-3


def test_what_more_damping_makes_no_easier_is_solved_with_the_first() -> None:
    damping = Damping(1.0)
    alpha = damping.begin(8.0, 1.0, True)
    assert damping.is_patient
    alpha = damping.refuse(alpha, math.inf, True)
    assert alpha == MORE * 8.0
    alpha = damping.refuse(alpha, 2.0, True)  # solved, but too long
    assert damping.is_patient
    assert damping.refuse(alpha, math.inf, True) == 8.0
    assert not damping.is_patient
    assert damping.refuse(8.0, math.inf, True) == MORE * 8.0


def test_stiffness_of_many_contacts_far_from_rest_couples_no_bodies() -> None:
    """All of the stiffness of discs is that of their contacts; near rest, and of few, it counts."""
    with budgeted(60.0) as allowed:
        _, path = stated(gallery.heap(discs=6), None, None, None, allowed)
    for _ in range(40):
        assert path.advance()
    here = path.station
    whole = tangent_stiffness(path.balance, path.scales, here.at.q, here.p)
    whole = 0.5 * (whole + whole.T)
    assert np.abs(whole).max() > 0.0
    far = dataclasses.replace(here, residual=2.0 * paths.ROUGH, step=np.full(len(here.step), path.longest))
    assert not path._stiffness(far, True).any()
    near = dataclasses.replace(far, residual=0.5 * paths.ROUGH)
    short = dataclasses.replace(far, step=1e-3 * far.step)
    for station, many in ((far, False), (near, True), (short, True)):
        assert path._stiffness(station, many) == pytest.approx(whole, abs=0.0)


def test_what_newton_leaves_is_given_up_at_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """The heap comes to rest all the same where no problem is solved from the step before, by Auto in the end."""
    given: list[bool] = []

    def never(problem: ContactProblem, forces: object) -> None:
        given.append(True)

    forces = step_contacts.StepContacts.forces
    asked: list[bool] = []

    def counted(self: step_contacts.StepContacts, *args: object) -> object:
        asked.append(bool(args[-1]))
        return forces(self, *args)  # type: ignore[arg-type]

    monkeypatch.setattr(step_contacts, "_from_near", never)
    monkeypatch.setattr(step_contacts, "PIVOTED", 20)
    monkeypatch.setattr(step_contacts.StepContacts, "forces", counted)
    assert lf.equilibrium(gallery.heap(discs=8), progress=False).residual < 1e-9
    assert given
    assert re.fullmatch("(T|ffT)+", "".join("T" if one else "f" for one in asked))
