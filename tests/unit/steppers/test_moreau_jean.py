"""Moreau-Jean time stepping: order, conservation, drift, determinism, and its two drivers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.problem import Lcp, Solution
from tests.rates import assert_rate, assert_rates
from tests.scenes import THREE_BOUNCES, after_three_bounces, floor_of, pendulum_into_stop, three_bounces


@dataclass(frozen=True)
class InPython:
    """Lemke behind a Python call: makes the stepper take its interpreted driver."""

    solver: lf.Lemke

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return self.solver.solve(problem, guess)


def spinning_beam(modes: int = 6) -> lf.Scene:
    """A free beam that spins and swings in several modes, without gravity."""
    body = lf.Beam(1.0, 0.05, 0.02, density=1000.0, youngs_modulus=1e8).reduce(modes=modes)
    rate = np.zeros(modes)
    rate[:3] = (0.3, -0.2, 0.1)
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(body, velocity=(0.4, -0.1), angular_velocity=6.0, modal_velocity=rate)
    return scene


def momenta(scene: lf.Scene, q: FloatArray, u: FloatArray) -> FloatArray:
    """Linear (2) and angular momentum about the world's origin, from M(q) and two rigid motions of the frame."""
    from lcpflex.dynamics.mass_matrix import mass_matrix

    model = scene.compiled().model
    motions = np.zeros((3, len(q)))
    motions[0, 0] = motions[1, 1] = motions[2, 2] = 1.0
    motions[2, :2] = (-q[1], q[0])
    return np.asarray(motions @ mass_matrix(model, q) @ u)


def test_free_flight_conserves_energy_and_momenta_to_the_order_of_the_scheme() -> None:
    scene = spinning_beam()
    steps, errors = (4e-4, 2e-4, 1e-4), []
    for step in steps:
        result = lf.simulate(scene, 0.2, lf.MoreauJean(step))
        first = momenta(scene, result.q[0], result.u[0])
        last = momenta(scene, result.q[-1], result.u[-1])
        energy = result.energies.stored
        errors.append([abs(energy[-1] / energy[0] - 1.0), *(np.abs(last - first) / np.abs(first).max())])
    errors = np.array(errors)
    assert (errors[-1] < (2e-5, 6e-7, 4e-7, 6e-6)).all(), errors  # twice what was measured
    assert (errors > 1e-8).all(), errors  # far above rounding, or there would be no rates to see
    assert_rates(steps, errors, 1.0, within=(0.1, 0.3))


def bouncing(step: float) -> FloatArray:
    """Height and speed after three bounces of a ball, of which the times are no multiples of the step."""
    result = lf.simulate(three_bounces(), THREE_BOUNCES, lf.MoreauJean(step))
    return np.array([result.q[-1, 1] - 0.1, result.u[-1, 1]])


def test_order_one_across_impacts() -> None:
    """The error after impacts jumps with the place of the step in time: a fit over many steps gives the rate."""
    steps = 1e-2 * 2.0 ** -np.arange(0, 8, 0.25)
    errors = [np.abs(bouncing(float(h)) - after_three_bounces()).max() for h in steps]
    assert_rate(steps, errors, 1.0, within=(0.2, 0.3))
    assert errors[-1] < 1e-3


def test_same_input_gives_the_same_bits() -> None:
    first, second = (lf.simulate(pendulum_into_stop(), 0.15, lf.MoreauJean(1e-4)) for _ in range(2))
    for name in ("times", "q", "u", "force", "impulse", "gap"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_compiled_and_interpreted_drivers_agree_to_the_bit() -> None:
    """The same solver, compiled in and called; another one's rounding is all that tells its run apart."""
    compiled = lf.simulate(pendulum_into_stop(), 0.12, lf.MoreauJean(1e-4, solver=lf.Lemke()))
    interpreted = lf.simulate(pendulum_into_stop(), 0.12, lf.MoreauJean(1e-4, solver=InPython(lf.Lemke())))
    other = lf.simulate(pendulum_into_stop(), 0.12, lf.MoreauJean(1e-4))
    assert compiled.impulse[-1, 0, 0] > 0.01
    for name in ("times", "q", "u", "force", "impulse", "gap", "state"):
        np.testing.assert_array_equal(getattr(interpreted, name), getattr(compiled, name))
    for name in ("q", "u", "force", "impulse"):
        largest = np.abs(getattr(compiled, name)).max()
        np.testing.assert_allclose(getattr(other, name), getattr(compiled, name), rtol=0, atol=1e-13 * largest)


def test_quadratic_program_solves_a_frictionless_scene() -> None:
    scene = lf.Scene()
    for k in range(3):
        box = scene.add(lf.Box(1.0, 0.5, mass=1.0), name=f"box{k}", position=(0.1 * k, 0.25 + 0.5 * k))
    del box
    floor_of(scene)
    scene.contact_all()
    by_pivots = lf.simulate(scene, 0.05, lf.MoreauJean(1e-3))
    by_program = lf.simulate(scene, 0.05, lf.MoreauJean(1e-3, solver=lf.QuadraticProgram("clarabel")))
    np.testing.assert_allclose(by_program.q, by_pivots.q, rtol=0, atol=1e-9)
    assert by_program.residual.max() <= 1e-9


def test_a_resting_block_stays_where_it_is() -> None:
    """Stick means stick: 30 degrees, mu = 0.7 > tan 30, 10 s."""
    scene = lf.Scene()
    slope = math.radians(30.0)
    block = scene.add(
        lf.Box(0.2, 0.1, mass=1.0), angle=-slope, position=(0.05 * math.sin(slope), 0.05 * math.cos(slope))
    )
    scene.contact(
        block.surface(), scene.ground.half_plane((0.0, 0.0), (math.sin(slope), math.cos(slope))), friction=0.7
    )
    result = lf.simulate(scene, 10.0, lf.MoreauJean(1e-3))
    assert np.abs(result.q - result.q[0]).max() < 1e-12


@pytest.mark.parametrize(
    ("field", "value"),
    [("step", 0.0), ("step", -1e-3), ("step", float("nan")), ("theta", 0.3), ("activation", 2.0), ("solver", None)],
)
def test_bad_numbers_are_refused_by_name(field: str, value: float) -> None:
    arguments = {"step": 1e-3, field: value}
    with pytest.raises(lf.ModelError, match=field):
        lf.MoreauJean(**arguments)  # type: ignore[arg-type]
