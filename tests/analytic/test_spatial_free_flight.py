"""Free flight of spatial bodies by the kernels alone, integrated by the classical method of Runge and Kutta."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

from lcpflex.dynamics import mechanics as leaves
from lcpflex.dynamics.spatial.body_forces import momenta
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.configuration import normalise, rate
from tests.rates import assert_rate
from tests.spatial_bodies import MassBody, any_state, mechanics, random_body, spatial_model

NONE = np.zeros((0, 4, 3))


def plate() -> MassBody:
    """J = diag(1, 2, 3) of four point masses."""
    places = np.array([[math.sqrt(2.0), 0, 0], [-math.sqrt(2.0), 0, 0], [0, 1.0, 0], [0, -1.0, 0]])
    return MassBody(0.5 * np.eye(4), places, NONE, centred=True)


class Flight:
    """q and u of one body, by steps of RK4."""

    def __init__(self, body: MassBody, q: FloatArray, u: FloatArray) -> None:
        made = mechanics(spatial_model([body]), q, u)
        self.model, self.work = made.model, made.work
        self.q, self.u = q.copy(), u.copy()

    def slope(self, q: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        numbers = np.zeros(len(q))
        rate(self.model, q, u, numbers)
        leaves.forces(self.model, 0.0, q, u, self.work)
        leaves.factorise(self.model, q, 0.0, 0.0, self.work)
        acceleration = self.work.free.total.copy()
        leaves.solve_vector(self.model, self.work, acceleration)
        return numbers, acceleration

    def to(self, duration: float, steps: int) -> Flight:
        h = duration / steps
        for _ in range(steps):
            q, u = self.q, self.u
            a, c = self.slope(q, u)
            d, e = self.slope(q + 0.5 * h * a, u + 0.5 * h * c)
            f, g = self.slope(q + 0.5 * h * d, u + 0.5 * h * e)
            i, j = self.slope(q + h * f, u + h * g)
            self.q, self.u = q + h / 6 * (a + 2 * d + 2 * f + i), u + h / 6 * (c + 2 * e + 2 * g + j)
            normalise(self.model, self.q)
        return self

    def kept(self) -> FloatArray:
        """Energy, linear and angular momentum."""
        kinetic, elastic, weight = leaves.energies(self.model, self.q, self.u, self.work)
        out = np.zeros((1, 9))
        momenta(self.model.bodies, self.q, self.u, self.work.rows.arrow, out)
        return np.concatenate([[kinetic + elastic + weight], out[0, :6]])


def dzhanibekov(duration: float, steps: int) -> Flight:
    q, u = np.zeros(7), np.zeros(6)
    q[3], u[3:] = 1.0, (0.01, 5.0, 0.01)
    return Flight(plate(), q, u).to(duration, steps)


def test_middle_axis_turns_over() -> None:
    """Reference values of an independent integration; the period is the elliptic one."""
    errors, drift, steps = [], [], (400, 600, 900)
    for n in steps:
        end = dzhanibekov(8.0, n)
        omega = end.u[3:] - (4.04901407, 2.93352774, 2.33771363)
        p = end.q[3:7] - math.copysign(1.0, end.q[3]) * np.array((0.88663647, -0.36676484, 0.0916551, 0.26638068))
        errors.append(max(np.abs(omega).max(), np.abs(p).max()))
        energy, *_, x, y, z = end.kept()
        L = np.array([0.01, 10.0, 0.03])
        drift.append(max(abs(energy / 25.0002 - 1.0), np.abs((x, y, z) - L).max() / 10.0))
    h = [8.0 / n for n in steps]
    assert_rate(h, errors, 4.0, 0.3)
    assert drift[-1] < 1e-7
    assert math.log(drift[0] / drift[-1]) / math.log(h[0] / h[-1]) > 3.7
    fine = dzhanibekov(8.0, 4000)
    np.testing.assert_allclose(fine.u[3:], (4.04901407, 2.93352774, 2.33771363), rtol=0, atol=2e-8)


def test_period_is_the_elliptic_one() -> None:
    J1, J2, J3 = 1.0, 2.0, 3.0
    omega = np.array((0.01, 5.0, 0.01))
    L2, T2 = float(np.array([J1, J2, J3]) ** 2 @ omega**2), float(np.array([J1, J2, J3]) @ omega**2)
    m = (J2 - J1) * (T2 * J3 - L2) / ((J3 - J2) * (L2 - T2 * J1))
    rate_ = math.sqrt((J3 - J2) * (L2 - T2 * J1) / (J1 * J2 * J3))
    period = 4.0 * float(ellipk(m)) / rate_
    assert period == pytest.approx(10.0518582763, abs=1e-9)
    np.testing.assert_allclose(dzhanibekov(period, 5000).u[3:], omega, rtol=0, atol=1e-8)


@pytest.mark.parametrize("centred", [True, False])
def test_flexible_body_keeps_energy_and_momenta_to_the_order(centred: bool) -> None:
    rng = np.random.default_rng(8)
    body = random_body(rng, 5, centred=centred, second_modes=3)
    body.damping = np.zeros(5)
    q, u = any_state(rng, spatial_model([body]))
    start = Flight(body, q, u).kept()
    errors, steps = [], (40, 80)
    for n in steps:
        errors.append(np.abs(Flight(body, q, u).to(2.0, n).kept() - start))
    size = np.abs(start).max()
    assert errors[0].max() > 1e-9 * size  # not rounding
    assert errors[1].max() < 1e-4 * size
    assert math.log2(errors[0].max() / errors[1].max()) > 3.7
