"""Scenes of many coordinates: what is told without singular values and eigenvalues is what they tell."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.statics import refinement, stability
from lcpflex.statics.balance import Balance
from lcpflex.statics.refinement import LARGE


def strip_on_supports(elements: int, friction: float = 0.3) -> lf.Scene:
    """All coordinates of a steel strip of (elements + 1) x 3 nodes, on two round supports."""
    mesh = lf.meshes.bar(1.0, 0.1, elements, across=2)
    scene = lf.Scene()
    body = scene.add(lf.unreduced(lf.Continuum(mesh, 7800.0, 2.1e11, 0.3, thickness=0.05)), "strip", (0.0, 0.051))
    for x in (0.1, 0.9):
        scene.contact(body.surface(), scene.ground.circle((x, -0.02), 0.02), friction=friction)
    return scene


def test_a_large_mesh_rests_as_it_does_by_singular_values(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = strip_on_supports(32)
    assert len(scene.compile().q) > LARGE
    fast = lf.equilibrium(scene)
    for module in (refinement, stability):
        monkeypatch.setattr(module, "LARGE", 10**6)
    slow = lf.equilibrium(strip_on_supports(32))
    assert (fast.stable, fast.neighbours, fast.unique) == (slow.stable, slow.neighbours, slow.unique)
    assert fast.stable
    size = np.abs(slow.q).max()
    assert np.abs(fast.q - slow.q).max() <= 1e-11 * size
    for one, other in zip(fast.contacts, slow.contacts, strict=True):
        assert one.states == other.states
        assert one.normal == pytest.approx(other.normal, rel=1e-9)


def test_an_unstable_large_scene_is_told() -> None:
    """A strip that stands upright upon a hinge at its lower end falls over."""
    mesh = lf.meshes.bar(1.0, 0.1, 32, across=2)
    scene = lf.Scene()
    strip = lf.unreduced(lf.Continuum(mesh, 7800.0, 2.1e11, 0.3, thickness=0.05))
    body = scene.add(strip, "strip", (0.0, 0.0), angle=0.5 * np.pi)
    scene.join(lf.Revolute(body.at(0.0, 0.0), scene.ground.at(0.0, 0.0)))
    rest = lf.equilibrium(scene)
    assert not rest.stable
    assert any("strip" in words for words in rest.unstable)


class TestSolved:
    def test_a_singular_system_is_solved_by_singular_values(self) -> None:
        rng = np.random.default_rng(0)
        A = rng.standard_normal((LARGE + 50, LARGE + 50))
        A[:, 7] = A[:, 11]
        right = A @ rng.standard_normal(len(A))
        x = refinement._solved(A, right)
        assert np.abs(A @ x - right).max() <= 1e-9
        assert x[7] == pytest.approx(x[11], rel=1e-9)  # of least norm

    def test_one_that_is_nearly_singular_too(self) -> None:
        """A singular value of 1e-11 of the largest is none."""
        rng = np.random.default_rng(1)
        U = np.linalg.qr(rng.standard_normal((LARGE + 1, LARGE + 1)))[0]
        sizes = np.ones(len(U))
        sizes[-1] = 1e-11
        x = refinement._solved((U * sizes) @ U.T, U[:, 0] + U[:, -1])
        assert np.abs(x - U[:, 0]).max() <= 1e-9

    def test_a_good_one_is_solved_to_rounding(self) -> None:
        rng = np.random.default_rng(2)
        A = rng.standard_normal((LARGE + 1, LARGE + 1)) + 20.0 * np.eye(LARGE + 1)
        x = rng.standard_normal(len(A))
        assert np.abs(refinement._solved(A, A @ x) - x).max() <= 1e-13


def test_columns_are_those_of_python() -> None:
    """The compiled loop against forces that are asked for one displacement after the other."""
    from lcpflex import gallery

    for scene in (gallery.heap(discs=6), strip_on_supports(4)):
        compiled = scene.compile()
        balance = Balance(compiled)
        at = balance.look(compiled.q, 0.05)
        assert at.n_contacts > 0
        p = np.random.default_rng(3).uniform(0.0, 10.0, len(at.rows))
        step = np.full(len(compiled.u), 1e-6)
        mine = balance.stiffness(compiled.q, p, step)
        exact = balance._supplied_stiffness(compiled.q, p, step, np.zeros_like(mine))
        assert np.abs(mine - exact).max() <= 1e-8 * np.abs(exact).max()
