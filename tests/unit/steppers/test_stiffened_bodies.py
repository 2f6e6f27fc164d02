"""Free flight of a spinning stiffened beam: what it keeps, and the order of the steppers that do not know its G."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import Beam, EventDriven, GeneralizedAlpha, MoreauJean, Result, Scene, simulate
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.dynamics.mass_matrix import mass_matrix
from tests.rates import assert_rate

BEAM = Beam(1.0, 0.02, 0.01, 2700.0, 6.9e8, elements=8)
SPIN = 20.0


def flight(stepper: object, duration: float = 0.5, stiffened: bool = True) -> Result:
    body = BEAM.reduce(4, stiffening=Stiffening() if stiffened else None)
    scene = Scene(gravity=(0, 0))
    modal = 0.02 * math.sqrt(body.mass) * np.array([1.0, -0.5, 0.2, 0.05])
    scene.add(body, "beam", velocity=(1.0, -0.5 * SPIN), angular_velocity=SPIN, modal=modal)
    return simulate(scene, duration, stepper, record=0.05)  # type: ignore[arg-type]


def conserved(result: Result) -> np.ndarray:
    """(k, 4) energy, momentum along x and y, and angular momentum about the origin of the world."""
    model = result.compiled.model
    out = []
    for q, u in zip(result.q, result.u, strict=True):
        M = mass_matrix(model, q)
        spun = np.zeros_like(q)
        spun[:3] = -q[1], q[0], 1.0  # a rotation about the origin moves the body so
        momentum = M @ u
        elastic = 0.5 * model.bodies.stiffness @ q[3:] ** 2
        out.append([0.5 * u @ momentum + elastic, momentum[0], momentum[1], spun @ momentum])
    return np.array(out)


def test_free_flight_keeps_energy_and_momenta():
    result = flight(EventDriven())
    kept = conserved(result)
    size = np.abs(kept[0]).max()
    assert np.ptp(kept, axis=0) == pytest.approx(np.zeros(4), abs=1e-8 * size)
    spin = result.u[:, 2]
    assert np.ptp(spin) > 0.01 * SPIN  # it spins up and down as it bends
    assert np.abs(result.q[-1] - flight(EventDriven(), stiffened=False).q[-1]).max() > 0.05


def test_a_ringing_beam_does_not_spin_itself_up_by_the_steps_of_moreau_jean():
    """With the torque of q + h qdot / 2, one joule in the sixth mode drove 10 J to 10.7 J within this time."""
    body = BEAM.reduce(8, stiffening=Stiffening())
    scene = Scene(gravity=(0, 0))
    rates = math.sqrt(2.0) * np.eye(8)[5]
    scene.add(body, "beam", velocity=(0.0, -0.5 * SPIN), angular_velocity=SPIN, modal_velocity=rates)
    energies = simulate(scene, 0.5, MoreauJean(step=1e-4), record=0.05).energies
    total = energies.kinetic + energies.elastic
    assert total == pytest.approx(total[0], rel=4e-3)


@pytest.mark.parametrize(("stepper", "order"), [(MoreauJean, 1.0), (GeneralizedAlpha, 2.0)])
def test_order_of_steps(stepper, order):
    """Spin enters their matrices as a force, so that the order is to be seen, not taken for granted."""
    exact = flight(EventDriven()).q[-1]
    steps = np.array([5e-4, 2.5e-4, 1.25e-4, 6.25e-5])
    errors = [np.abs(flight(stepper(step=h)).q[-1] - exact).max() for h in steps]
    assert_rate(steps, errors, order, within=0.1)
