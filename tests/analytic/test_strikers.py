"""A pendulum strikes a rod, both meshes: balances that hold however coarse they are, and what a fine one must meet."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.body import Body
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.reduction.component_modes import craig_bampton
from lcpflex.bodies.reduction.damping import Rayleigh
from lcpflex.gallery.mechanisms.strikers import (
    pendulum_and_rod,
    pendulum_with_hammer,
    rod_with_crown,
)

STEPPERS = {
    "massless boundary": lf.MasslessBoundary(step=1e-7, dynamic_modes=20),
    "event-driven": lf.EventDriven(rtol=1e-4, atol=1e-7),
    "penalty": lf.Smooth(lf.Penalty(1e9), integrator=lf.Verlet(2e-8)),
}


def scene(fine: float, modes: int) -> lf.Scene:
    def reduce(mesh: Continuum, kept: list[str]) -> Body:
        return craig_bampton(mesh, kept, modes=modes, damping=Rayleigh(0.0, 1e-9))

    return pendulum_and_rod(rod_with_crown(fine), pendulum_with_hammer(fine), reduce)


@pytest.mark.parametrize("stepper", STEPPERS.values(), ids=STEPPERS)
def test_rod_takes_up_the_impulse_and_energy_is_accounted_for(stepper: object) -> None:
    built = scene(2.4e-3, 20)
    result = lf.simulate(built, 1e-4, stepper, record=1e-6)
    rod, pendulum = built.body("rod").source, built.body("pendulum").source
    first = 3 + pendulum.modes
    impulse = result.impulse[:, 0, 0]
    momentum = rod.mass * result.u[:, first] * np.cos(result.q[:, first + 2])  # <Phi> = 0: the frame moves with it
    assert impulse[-1] > 0.1
    np.testing.assert_allclose(momentum, impulse, atol=1e-3 * impulse[-1])
    assert result.energies.relative_remainder < 1e-3


def test_coarse_patch_is_reported() -> None:
    result = lf.simulate(scene(2.4e-3, 20), 2e-4, STEPPERS["massless boundary"], record=1e-6)
    assert any("1 pair of touching points" in warning for warning in result.warnings)


def test_point_behind_the_contact_lies_there_and_moves_with_the_rest_before() -> None:
    mesh = pendulum_with_hammer(2.4e-3).finite_elements()
    (back,), face = mesh.places[mesh.sets["back"]], mesh.places[mesh.sets["face"]].mean(axis=0)
    np.testing.assert_allclose(face - back, (0.012, 0.0), atol=1.3e-3)  # 12 mm before it, within half an element
    result = lf.simulate(scene(2.4e-3, 20), 1e-6, STEPPERS["massless boundary"], record=1e-6)
    lever = result.point("pendulum", "back")[0] - result.point("pendulum", "hinge")[0]
    spin = result.u[0, result.coordinate_names().index("pendulum.angle")]
    np.testing.assert_allclose(result.velocity("pendulum", "back")[0], spin * np.array([-lever[1], lever[0]]))
    assert result.velocity("pendulum", "back")[0, 0] == pytest.approx(1.4, rel=0.01)


def test_nodes_of_either_body_meet_edges_of_the_other() -> None:
    coarse, fine = pendulum_with_hammer(2.4e-3), rod_with_crown(1.2e-3)

    def pairs(side: str) -> int:
        built = pendulum_and_rod(fine, coarse, lambda mesh, kept: craig_bampton(mesh, kept, modes=10), node_side=side)
        result = lf.simulate(built, 1e-5, lf.MasslessBoundary(step=1e-7, dynamic_modes=10))
        return int(result.contact("strike").pairs.max())

    assert 0 < pairs("pendulum") < pairs("rod")


def test_other_node_sides_are_refused() -> None:
    with pytest.raises(lf.ModelError, match='node_side: \'face\' was given, expected "rod" or "pendulum"'):
        pendulum_and_rod(node_side="face")
