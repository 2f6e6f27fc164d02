"""Central impacts of spheres in space by Hertz's law: closed forms, orders of fixed steps, and Zener's equation.

With the reduced mass m, the speed v and F = K d^(3/2): largest indentation d = (5 m v^2 / (4 K))^(2/5), largest force
K d^(3/2), duration 2 sqrt(pi) Gamma(7/5) / Gamma(9/10) d / v = 2.9433 d / v, restitution 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.rates import assert_rate

laws = lf.laws
NORMAL = Rotation.from_rotvec([0.3, -0.5, 0.7]).apply([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Impact:
    """A sphere on another one, or on a half-space of the ground where that has no radius."""

    radii: tuple[float, float]  # [m]
    masses: tuple[float, float]  # [kg]
    modulus: float  # [Pa]
    speed: float  # [m/s]

    @property
    def plane(self) -> bool:
        return self.radii[1] == 0.0

    @property
    def law(self) -> Any:
        material = laws.Material(self.modulus, 0.3)
        return laws.Hertz.sphere_on_plane(self.radii[0], material) if self.plane else laws.Hertz.spheres(
            *self.radii, material
        )  # fmt: skip

    @property
    def mass(self) -> float:
        """Reduced mass."""
        a, b = self.masses
        return a if self.plane else a * b / (a + b)

    @property
    def stiffness(self) -> float:
        return float(self.law.parameters[0])

    @property
    def deepest(self) -> float:
        return float((1.25 * self.mass * self.speed**2 / self.stiffness) ** 0.4)

    @property
    def force(self) -> float:
        return self.stiffness * self.deepest**1.5

    @property
    def duration(self) -> float:
        return 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * self.deepest / self.speed

    @property
    def unit(self) -> float:
        """T0 = (m / (K v^(1/2)))^(2/5) [s]."""
        return float((self.mass / (self.stiffness * math.sqrt(self.speed))) ** 0.4)

    def run(self, stepper: Any, law: Any = None, instants: int = 200, long: float = 1.3) -> lf.Result:
        """From the touch on."""
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        share = np.array([1.0, 0.0]) if self.plane else self.mass / np.array(self.masses)
        ball = scene.add(
            lf.Sphere(self.radii[0], mass=self.masses[0]),
            position=self.radii[0] * NORMAL,
            velocity=-share[0] * self.speed * NORMAL,
        )
        if self.plane:
            other = scene.ground.plane((0.0, 0.0, 0.0), NORMAL)
        else:
            other = scene.add(
                lf.Sphere(self.radii[1], mass=self.masses[1]),
                position=-self.radii[1] * NORMAL,
                velocity=share[1] * self.speed * NORMAL,
            ).surface()
        scene.contact(ball.surface(), other, friction=0.0, law=lf.ContactLaw(law or self.law), name="pair")
        return lf.simulate(scene, long * self.duration, stepper, record=self.duration / instants)

    def gap(self, result: lf.Result) -> Any:
        """(m,) distance of the surfaces [m]."""
        apart = result.q[:, :3] if self.plane else result.q[:, :3] - result.q[:, 7:10]
        return apart @ NORMAL - sum(self.radii)

    def rate(self, result: lf.Result) -> Any:
        """(m,) its rate [m/s]."""
        return (result.u[:, :3] if self.plane else result.u[:, :3] - result.u[:, 6:9]) @ NORMAL

    def errors(self, result: lf.Result) -> Any:
        """(4,) of duration, restitution, largest force and indentation, relative; parted, surfaces fly freely."""
        gap, rate = self.gap(result), self.rate(result)
        end = result.times[-1] - gap[-1] / rate[-1]
        return np.array([
            end / self.duration - 1.0,
            rate[-1] / self.speed - 1.0,
            result.contact("pair").force[:, 0].max() / self.force - 1.0,
            -gap.min() / self.deepest - 1.0,
        ])  # fmt: skip


BALLS = Impact((0.02, 0.03), (0.1, 0.25), 2.1e9, 1.5)
PLANE = Impact((0.02, 0.0), (0.1, 0.0), 2.1e9, 1.0)
IMPACTS = {
    "balls": BALLS,
    "grains": Impact((1e-4, 1e-4), (1.1e-8, 1.1e-8), 7e10, 0.05),
    "boulders": Impact((5.0, 8.0), (1e6, 4e6), 1e9, 0.3),
    "plane": PLANE,
    "large ball on plane": Impact((5.0, 0.0), (3e4, 0.0), 1e9, 1.0),
}


@pytest.mark.parametrize("impact", IMPACTS.values(), ids=IMPACTS)
@pytest.mark.parametrize(
    ("stepper", "error", "given_back"),
    [
        (lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-10)), 1e-10, 2e-8),
        (lf.Smooth(integrator=lf.Stiff(rtol=1e-8)), 3e-8, 1e-6),
        (lf.EventDriven(rtol=1e-9), 1e-8, 1e-6),
    ],
    ids=["explicit", "stiff", "events"],
)
def test_an_impact_has_the_duration_the_depth_and_the_force_of_the_closed_form(
    impact: Impact, stepper: Any, error: float, given_back: float
) -> None:
    result = impact.run(stepper)
    lasts, restitution, force, depth = np.abs(impact.errors(result))
    assert max(lasts, force, depth) < error
    assert restitution < given_back
    pair = result.contact("pair")
    assert pair.impulse[-1, 0] == pytest.approx(2.0 * impact.mass * impact.speed, rel=given_back)
    assert not np.abs(pair.impulse[-1, 1:]).any()
    assert not result.warnings


@pytest.mark.parametrize("impact", [BALLS, PLANE], ids=["balls", "plane"])
@pytest.mark.parametrize(
    "stepper", [lambda h: lf.Smooth(integrator=lf.Verlet(h)), lambda h: lf.MoreauJean(step=h)], ids=["Verlet", "theta"]
)
def test_steps_of_order_two_keep_it_through_an_impact(impact: Impact, stepper: Any) -> None:
    """The force begins as t^(3/2): what an impact gives back is of order 7/2, as these schemes are symmetric."""
    steps = np.array([100, 200, 400])
    found = np.abs([impact.errors(impact.run(stepper(impact.duration / n), instants=n)) for n in steps])
    assert_rate(1.0 / steps, found[:, [0, 2, 3]], 2.0, 0.05)
    assert_rate(1.0 / steps, found[:, 1], 3.5, 0.05)
    assert found[1].max() < 4e-5


def test_theta_above_one_half_is_of_order_one() -> None:
    steps = np.array([800, 1600, 3200])
    found = np.abs([
        BALLS.errors(BALLS.run(lf.MoreauJean(step=BALLS.duration / n, theta=0.55), instants=n)) for n in steps
    ])  # fmt: skip
    assert_rate(1.0 / steps, found, 1.0, 0.05)
    assert found[0, 1] < 7e-4


def zener(loss: float) -> tuple[float, float]:
    """Speed and time at which s'' + (1 + loss d/dt) s^(3/2) = 0, s(0) = 0, s'(0) = 1, comes to s'' = 0."""

    def slope(t: float, y: Any) -> Any:
        depth = max(y[0], 0.0)
        return y[1], -(depth**1.5) - 1.5 * loss * math.sqrt(depth) * y[1]

    def pull(t: float, y: Any) -> Any:
        return y[0] + 1.5 * loss * y[1]

    pull.terminal, pull.direction = True, -1.0  # type: ignore[attr-defined]
    found = solve_ivp(slope, (0.0, 10.0), (0.0, 1.0), "DOP853", rtol=1e-12, atol=1e-14, events=pull, max_step=0.05)
    return -float(found.y_events[0][0][1]), float(found.t_events[0][0])


def damped(indentation: float, rate: float, impact_speed: float, p: Any) -> float:
    """K (d^(3/2) + c d/dt d^(3/2))."""
    return float(p[0] * indentation**1.5 + 1.5 * p[0] * p[1] * indentation**0.5 * rate)


@pytest.mark.parametrize("impact", [BALLS, PLANE], ids=["balls", "plane"])
def test_a_users_law_of_zener_that_does_not_pull_meets_its_equation(impact: Impact) -> None:
    """Restitution .845144 and 3.128358 T0 for a loss of .1: there the force ends, before the surfaces part."""
    law = laws.UserLaw(damped, (impact.stiffness, 0.1 * impact.unit))
    result = impact.run(lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-9)), law, instants=1000)
    speed, time = zener(0.1)
    assert (speed, time) == pytest.approx((0.845144, 3.128358), abs=6e-7)
    assert impact.rate(result)[-1] / impact.speed == pytest.approx(speed, rel=1e-6)
    force = result.contact("pair").force[:, 0]
    last = np.flatnonzero(force > 0.0)[-1]
    step = result.times[last] - result.times[last - 1]
    end = result.times[last] + step * force[last] / (force[last - 1] - force[last])
    assert end / impact.unit == pytest.approx(time, abs=1e-5)
