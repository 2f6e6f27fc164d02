"""A snap-fit hook on its ramp against static finite elements with large displacements; drives that go slowly."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.examples import example

PLACES = (1.5e-3, 2e-3, 2.5e-3, 3e-3, 3.5e-3)  # of the drive: from a twentieth of the ramp to nine tenths


class Elastic:
    """The mesh of the example with scikit-fem alone: St. Venant-Kirchhoff in plane stress, clamped at its root.

    ``large`` False: small displacements, forces on the undeformed body.
    """

    def __init__(self, hook: Any, large: bool) -> None:
        import skfem

        E, nu = hook.PLASTIC["youngs_modulus"], hook.PLASTIC["poissons_ratio"]
        lame, shear, t = E * nu / (1.0 - nu**2), E / (2.0 * (1.0 + nu)), hook.THICKNESS
        one = np.eye(2)[:, :, None, None]

        def product(a: Any, b: Any) -> Any:
            return np.einsum("ij...,jk...->ik...", a, b)

        def stress(strain: Any) -> Any:
            return lame * (strain[0, 0] + strain[1, 1]) * one + 2.0 * shear * strain

        def gradient(w: Any) -> Any:
            return one + (w["u"].grad if large else 0.0 * w["u"].grad)

        def internal(v: Any, w: Any) -> Any:
            F, H = gradient(w), w["u"].grad
            if not large:
                return t * np.einsum("ij...,ij...", stress(0.5 * (H + H.swapaxes(0, 1))), v.grad)
            return t * np.einsum("ij...,ij...", product(F, stress(0.5 * (product(F.swapaxes(0, 1), F) - one))), v.grad)

        def tangent(u: Any, v: Any, w: Any) -> Any:
            F, dF = gradient(w), np.asarray(u.grad)
            half = product(F.swapaxes(0, 1), dF)
            S = stress(0.5 * (product(F.swapaxes(0, 1), F) - one)) if large else 0.0 * F
            change = product(F, stress(0.5 * (half + half.swapaxes(0, 1))))
            return t * np.einsum("ij...,ij...", product(dF, S) + change, v.grad)

        self.basis = skfem.Basis(hook.mesh(), skfem.ElementVector(skfem.ElementQuad2()), intorder=6)
        self._internal, self._tangent = skfem.LinearForm(internal), skfem.BilinearForm(tangent)
        x, y = self.basis.doflocs
        self.free = np.flatnonzero(x > 0.0)
        top = np.flatnonzero(y > np.interp(x, hook.ALONG, hook.ABOVE) - 1e-9)
        self.top = top[np.lexsort((top, np.round(x[top], 9)))].reshape(-1, 2)  # x and y of each node
        self.places = np.stack([x[self.top[:, 0]], y[self.top[:, 0]]], axis=1)

    def solved(self, u: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Newton's step of the free nodes from u without a contact, and the response to f."""
        field = self.basis.interpolate(u)
        K = self._tangent.assemble(self.basis, u=field)[self.free][:, self.free].tocsc()
        lu = scipy.sparse.linalg.splu(K)
        return lu.solve(-self._internal.assemble(self.basis, u=field)[self.free]), lu.solve(f[self.free])


def pushed(elastic: Elastic, friction: float, center: FloatArray, radius: float, u: FloatArray) -> tuple[Any, float]:
    """Displacements, and the force that pushes the hook along x, with the rib at ``center`` in front of it; from u."""
    u = u.copy()
    for _ in range(60):
        at = elastic.places + u[elastic.top]
        a, b = at[:-1], at[1:]
        share = np.clip(((center - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1), 0.0, 1.0)
        near = a + share[:, None] * (b - a)
        away = np.hypot(*(center - near).T)
        k = int(away.argmin())
        n = (center - near[k]) / away[k]
        force = -n - friction * np.array([n[1], -n[0]])  # for a normal force of 1, sliding along
        f, slope = np.zeros(len(u)), np.zeros(len(u))
        for node, part in ((k, 1.0 - share[k]), (k + 1, share[k])):
            f[elastic.top[node]] += part * force
            slope[elastic.top[node]] -= part * n
        alone, by_one = elastic.solved(u, f)
        row = slope[elastic.free]
        pressed = -(away[k] - radius + row @ alone) / (row @ by_one)
        step = alone + pressed * by_one
        u[elastic.free] += step
        if np.abs(step).max() < 1e-12:
            return u, float(-pressed * force[0])
    raise AssertionError("the finite-element solution does not converge")


@cache
def by_finite_elements(friction: float, large: bool = True) -> FloatArray:
    """Force of insertion [N] at ``PLACES``."""
    hook = example("snap_fit")
    elastic = Elastic(hook, large)
    u, forces = np.zeros(elastic.basis.N), []
    for place in PLACES:
        u, force = pushed(elastic, friction, np.array(hook.RIB) - [place, 0.0], hook.RADIUS, u)
        forces.append(force)
    return np.array(forces)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_hook_at_rest(friction: float) -> None:
    """Force of the drive from rest to rest within 2 %; where displacements are small, linear elements say the same."""
    hook = example("snap_fit")
    scene = hook.scene(friction, lf.Function(lambda t: t)).reduced()
    rest, forces = None, []
    for place in (0.0, 1e-3, *PLACES):
        rest = lf.equilibrium(scene, initial=rest, time=place)
        forces.append(rest.joint("drive").force[0])
        if place in PLACES:
            contact = rest.contact("rib")
            assert contact.state == "slip"
            assert contact.tangential == pytest.approx(friction * contact.normal, rel=1e-9)
    assert np.abs(forces[:2]).max() < 1e-9
    assert forces[2:] == pytest.approx(by_finite_elements(friction), rel=0.02)
    assert forces[2] == pytest.approx(by_finite_elements(friction, large=False)[0], rel=0.006)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_hook_in_time(friction: float) -> None:
    """Pushed by 0.1 m/s, the mean over 1 ms (0.1 mm) within 2 %: the vibration since the touch is in it."""
    hook = example("snap_fit")
    scene = hook.scene(friction, lf.Table([0.0, 0.08], [0.0, 8e-3]), 0.1)
    result = lf.simulate(scene, 0.037, lf.GeneralizedAlpha(5e-6), record=2e-5, progress=False)
    force, path = result.reaction("drive").force[:, 0], 0.1 * result.times
    means = [np.nanmean(force[np.abs(path - place) < 5e-5]) for place in PLACES]
    assert means == pytest.approx(by_finite_elements(friction), rel=0.02)


def pulled(time_to_place: Any, length: float = 1.0) -> lf.Scene:
    """A block of 2 kg on a floor, friction 0.4, pulled by a spring of 500 N/m behind a slider that a drive moves.

    With another ``length`` than 1 m all lengths and the stiffness are others, masses and weights are not.
    """
    scene = lf.Scene(gravity=(0.0, -9.81))
    block = scene.add(lf.Box(0.4 * length, 0.2 * length, mass=2.0), "block", position=(0.0, 0.1 * length))
    slider = scene.add(lf.Box(0.1 * length, 0.1 * length, mass=1.0), "slider", position=(length, 0.1 * length))
    place = scene.ground.at(length, 0.1 * length)
    scene.join(lf.Prismatic(slider.point("center"), place, axis=(1.0, 0.0)))
    scene.join(lf.DrivenDisplacement(slider.point("center"), place, time_to_place, (1.0, 0.0), name="drive"))
    scene.load(lf.Spring(slider.point("center"), block.point("center"), 500.0 / length, length=length))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(block.surface(), floor, friction=0.4, name="floor")
    return scene


@pytest.mark.parametrize("length", [1.0, 1e-6])
def test_a_block_is_pulled_forth_and_back(length: float) -> None:
    """k s below the limit, mu m g above it, the same backwards after twice the limit: friction by path."""
    scene = pulled(lf.Function(lambda t: length * t), length)
    weight = 2.0 * 9.81
    limit = 0.4 * weight
    stuck, rest = 0.0, None  # place of the block
    for s in (0.0, 0.012, 0.03, 0.045, 0.03, 0.005, -0.005):
        rest = lf.equilibrium(scene, initial=rest, time=s)
        stuck = min(max(stuck, s - limit / 500.0), s + limit / 500.0)
        assert rest.q[0] == pytest.approx(length * stuck, abs=1e-8 * length)
        assert rest.joint("drive").force[0] == pytest.approx(500.0 * (s - stuck), abs=1e-8 * weight)
        slips = abs(abs(s - stuck) - limit / 500.0) < 1e-9
        assert rest.contact("floor").state == ("slip" if slips else "stick")


@pytest.mark.parametrize("back", [1e-3, 1e-5, 1e-7])
def test_a_drive_that_turns_by_ever_so_little_unloads(back: float) -> None:
    """A block that slid sticks when the drive turns: what it did on the way there says nothing of the way back."""
    scene = pulled(lf.Function(lambda t: t))
    limit = 0.4 * 2.0 * 9.81
    there = lf.equilibrium(scene, initial=lf.equilibrium(scene, time=0.0), time=0.03)
    assert there.joint("drive").force[0] == pytest.approx(limit, rel=1e-9)
    turned = lf.equilibrium(scene, initial=there, time=0.03 - back)
    assert turned.contact("floor").state == "stick"
    assert limit - turned.joint("drive").force[0] == pytest.approx(500.0 * back, rel=1e-4)


def test_a_drive_elsewhere_at_the_start_of_a_run_is_refused() -> None:
    """A run begins at t = 0: a state with the drive elsewhere would be thrown back."""
    scene = pulled(lf.Harmonic(0.1, 1.0))
    rest = lf.equilibrium(scene, time=0.5)
    with pytest.raises(lf.ModelError, match=r"initial: its state is off the joint 'drive' by 0.04794 m at t = 0"):
        lf.simulate(scene, 0.1, lf.MoreauJean(1e-3), project=True, progress=False, initial=rest)
    with pytest.raises(lf.ModelError, match=r"its drive moves at t = 0 with 0.1 a second.*or time="):
        lf.equilibrium(scene)
    assert lf.equilibrium(scene, time=0.0).joint("drive").force == pytest.approx([0.0, 0.0], abs=1e-9)


def test_without_any_force_a_drive_moves_what_it_holds() -> None:
    """No weight, no spring, a drive 3 m off: more than its body is long, and nothing to measure damping by."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    box = scene.add(lf.Box(0.2, 0.1, mass=1.0), "box")
    place = scene.ground.at(0.0, 0.0)
    scene.join(lf.Prismatic(box.point("center"), place, axis=(1.0, 0.0)))
    scene.join(lf.DrivenDisplacement(box.point("center"), place, lf.Function(lambda t: t), (1.0, 0.0), name="drive"))
    rest = lf.equilibrium(scene, initial=lf.equilibrium(scene, time=0.0), time=3.0)
    assert rest.q == pytest.approx([3.0, 0.0, 0.0], abs=1e-9)
    assert rest.joint("drive").force == pytest.approx([0.0, 0.0], abs=1e-9)
