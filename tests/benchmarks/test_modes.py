"""Cost of a step against the number of modes: linear, but for the inertia coupling D of a general body."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.body import Body
from tests.scenes import floor_of

STEP = 1e-5
MODES = (10, 50, 200, 400)
EXPONENT = 1.25  # of the cost in the number of modes, at the most; 1 without scatter, less with a constant share


def strip(modes: int) -> Body:
    """A strip in pure bending: D = 0."""
    beam = lf.Beam(
        length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10, elements=210, axial=False
    )
    return beam.reduce(modes=modes, damping=0.02)


def membrane(modes: int, across: int = 15) -> Body:
    """A square net of masses and springs: its modes move in both directions, and D is full."""
    place = np.array([(i, j) for j in range(across) for i in range(across)], dtype=float)
    stiffness = np.zeros((place.size, place.size))
    for a, (x, y) in enumerate(place):
        for b in range(a + 1, len(place)):
            apart = place[b] - (x, y)
            if np.max(np.abs(apart)) > 1.0:
                continue
            along = np.outer(apart, apart) / (apart @ apart)
            for i, j, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
                stiffness[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] += sign * 1e4 * along
    body = lf.Matrices(mass=np.eye(place.size), stiffness=stiffness, coordinates=place).reduce(modes=modes)
    assert body.coupling is not None
    assert np.count_nonzero(body.coupling) > 0.5 * modes**2
    return body


def resting(body: Body) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    placed = scene.add(body, name="strip", position=(0.0, 0.0025))
    floor = floor_of(scene)
    for x in (0.0, 0.7):
        scene.contact(placed.node(x, -0.0025), floor, friction=0.5, name=f"at {x}")
    return scene


def spinning(body: Body) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(body, name="net", angular_velocity=1.0, modal_velocity=np.full(body.modes, 1e-3))
    return scene


def seconds_per_step(scene: lf.Scene, steps: int) -> float:
    result = lf.simulate(scene, steps * STEP, lf.MoreauJean(step=STEP), record=steps * STEP, progress=False)
    return result.wall_time / result.steps


def products(matrix: np.ndarray, rounds: int = 300) -> float:
    """Seconds of two products of a matrix with a vector, one with its transpose, in numpy."""
    vector = np.linspace(-1.0, 1.0, len(matrix))
    began = time.perf_counter()
    for _ in range(rounds):
        matrix @ vector
        vector @ matrix
    return (time.perf_counter() - began) / rounds


def test_cost_is_linear_in_the_modes_of_a_bending_beam(
    interleave: Callable[..., Mapping[str, float]], report: Callable[[str], None]
) -> None:
    scenes = {f"resting strip, {n} modes": resting(strip(n)) for n in MODES}
    medians = interleave({name: partial(seconds_per_step, scene, 1000) for name, scene in scenes.items()})
    cost = dict(zip(MODES, medians.values(), strict=True))
    exponent = np.log(cost[400] / cost[50]) / np.log(400 / 50)
    report(f"cost grows from 50 to 400 modes with the power {exponent:.2f}")
    assert exponent <= EXPONENT
    # and a straight line through the ends holds in between
    for n in (50, 200):
        line = cost[10] + (cost[400] - cost[10]) * (n - 10) / 390
        assert 0.6 * line <= cost[n] <= 1.4 * line


@pytest.mark.parametrize("modes", [200, 400])
def test_general_body_costs_two_matrix_products_more(
    interleave: Callable[..., Mapping[str, float]], modes: int
) -> None:
    body = membrane(modes)
    assert body.coupling is not None
    medians = interleave(
        {
            f"net, {modes} modes, without D": partial(seconds_per_step, spinning(replace(body, coupling=None)), 1000),
            f"net, {modes} modes": partial(seconds_per_step, spinning(body), 500),
            f"two products with {modes} x {modes}, numpy": partial(products, body.coupling),
        }
    )
    without, general, two = medians.values()
    assert general - without <= 1.5 * two
