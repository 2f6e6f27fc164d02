"""The step of the massless boundary: its exact limit, and how it is divided where contacts ask for that."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.bars import LENGTH, MODULUS
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.scenes import beam_struck_by_disc


def closed_frequency(elements: int, dynamic: int) -> float:
    """Largest frequency of the bar with its end held on the wall through the compliance of its static modes."""
    body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=elements).reduce(modes=None)
    phi = body.locate(0.0, 0.0).phi[:, 0]
    compliance = float(np.sum(phi[dynamic:] ** 2 / body.stiffness[dynamic:]))
    row = np.concatenate([[1.0 / math.sqrt(body.mass)], phi[:dynamic]])
    stiffness = np.diag(np.concatenate([[0.0], body.stiffness[:dynamic]])) + np.outer(row, row) / compliance
    return float(np.sqrt(np.linalg.eigvalsh(stiffness)[-1]))


@pytest.mark.parametrize(("elements", "dynamic"), [(40, 20), (100, 99)])
def test_too_long_a_step_is_refused_with_the_exact_limit(elements: int, dynamic: int) -> None:
    scene = gallery.elastic_bar(elements=elements, gap=0.01)
    stiffness = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=elements).reduce(modes=None).stiffness
    step = 0.99 * 2.0 / math.sqrt(stiffness[dynamic - 1])  # admitted by the modes alone
    exact = 2.0 / closed_frequency(elements, dynamic)
    assert exact < 0.9 * step
    with pytest.raises(lf.StepError, match="admits") as caught:
        lf.simulate(scene, 0.1, MasslessBoundary(step, dynamic, substeps=False, safety=1.0))
    found = re.search(r"admits ([\d.e-]+) s", str(caught.value))
    assert found is not None
    assert float(found[1]) == pytest.approx(exact, rel=1e-5)
    assert caught.value.result.times.size > 0
    lf.simulate(scene, 0.1, MasslessBoundary(0.999 * exact, dynamic, substeps=False, safety=1.0))


def test_short_steps_are_not_divided() -> None:
    limit = 2.0 / closed_frequency(40, 20)
    result = lf.simulate(gallery.elastic_bar(elements=40), 0.9, MasslessBoundary(0.29 * limit))
    assert not [warning for warning in result.warnings if "divided" in warning]
    assert result.steps == math.ceil(0.9 / (0.29 * limit))


@pytest.mark.parametrize(("stiffness", "damping"), [(1e6, 0.0), (0.0, 3e4)], ids=["spring", "damper"])
def test_springs_and_dampers_are_in_the_limit(stiffness: float, damping: float) -> None:
    """The modes alone would admit ten times the step that the spring or the damper at the free end does."""
    body = lf.Bar(LENGTH, 1.0, 1.0, MODULUS, elements=20).reduce(modes=None)
    scene = lf.Scene(gravity=(0.0, 0.0))
    bar = scene.add(body, name="bar", position=(0.01, 0.0), velocity=(-10.0, 0.0))
    scene.contact(bar.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)))
    scene.load(lf.Spring(bar.point("right"), scene.ground.at(30.0, 0.0), stiffness=stiffness, damping=damping))
    result = lf.simulate(scene, 0.5, MasslessBoundary(step=4e-3))
    assert [warning for warning in result.warnings if f"of {result.steps} steps were divided" in warning]
    assert result.energies.relative_remainder < 0.02


def test_contact_that_opens_is_not_left_with_a_longer_step_than_it_bears() -> None:
    """1 mg, whose contact is shorter than a step: kicked by its last force over an undivided step, it gained 100 %."""
    result = lf.simulate(beam_struck_by_disc(1e-6, friction=0.2), 3e-4, MasslessBoundary(step=7.5e-8), record=1.5e-7)
    assert result.energies.relative_remainder < 0.01
    assert result.impulse[-1, 0, 0] == pytest.approx(2e-6, rel=0.01)  # 1 mg is thrown back by what does not move


def test_steps_are_whole_again_when_a_contact_has_opened_amid_one() -> None:
    result = lf.simulate(beam_struck_by_disc(1e-3, friction=0.2), 3e-3, MasslessBoundary(step=7.5e-7), record=3e-6)
    divided = [warning for warning in result.warnings if "divided" in warning]
    assert len(divided) == 1
    assert int(divided[0].split()[0]) < 0.01 * result.steps
