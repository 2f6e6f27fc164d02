"""Bodies that are struck: too few modes are told, and massless boundaries keep the modes that were asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}
STRIP = lf.Beam(0.3, 0.02, 0.01, elements=30, **STEEL)
LAW = lf.laws.PowerLaw(1e10)  # of a steel ball on a plane, about [N/m^1.5]


def struck(body: Any, speed: float = 1.0, law: Any = None, at: float = 0.15, **modes: Any) -> lf.Scene:
    """A disc of half a kilogram meets a free strip in its middle."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    strip = scene.add(body, "strip", **modes)
    disc = scene.add(lf.Disc(radius=0.01, mass=0.5), "disc", position=(at, 0.015), velocity=(0.0, -speed))
    scene.contact(disc.surface(), strip.surface("top"), law=law, name="strike")
    return scene


def pushes(result: lf.Result) -> list[tuple[float, float, float]]:
    """Begin and end [s] and largest force [N] of each push."""
    history = result.contact("strike")
    pressed = history.force[:, 0] > 1e-6 * history.peak_force
    edges = np.flatnonzero(np.diff(np.concatenate([[0], pressed.astype(int), [0]])))
    ends = zip(edges[::2], np.minimum(edges[1::2], len(pressed) - 1), strict=True)
    return [(history.times[a], history.times[b], float(history.force[a:b, 0].max())) for a, b in ends]


@pytest.mark.slow
def test_a_massless_boundary_keeps_what_was_asked_for() -> None:
    """30 modes, Hertz at the contact: pushes, their times and forces are those of all modes with continuous forces."""
    exact = lf.simulate(struck(STRIP.reduce(None), law=lf.ContactLaw(LAW)), 1.5e-3, lf.Smooth(), record=5e-7)
    stepper = lf.MasslessBoundary(compliance={"strike": LAW})
    result = lf.simulate(struck(STRIP, modes=30), 1.5e-3, stepper, record=5e-7)
    assert not result.warnings
    found, expected = pushes(result), pushes(exact)
    assert len(found) == len(expected) == 2
    np.testing.assert_allclose([push[:2] for push in found], [push[:2] for push in expected], rtol=0.02, atol=1e-6)
    np.testing.assert_allclose([push[2] for push in found], [push[2] for push in expected], rtol=0.03)


def test_a_massless_boundary_that_halves_the_modes_says_what_it_lacks() -> None:
    """The same modes without residual ones: half of them are made static, and end below what the contact excites."""
    result = lf.simulate(struck(STRIP.reduce(30)), 1e-3, lf.MasslessBoundary(), record=5e-7)
    assert any("the dynamic modes of 'strip' (15) end at" in text for text in result.warnings)


def test_static_modes_are_those_of_contacts() -> None:
    """Residual modes of joints stay dynamic, and so do all modes where the contact gives way by itself."""
    scene = struck(STRIP, modes=6)
    strip = scene.body("strip")
    scene.join(lf.Weld(strip.point("left"), scene.ground.at(0.0, 0.0)))
    compiled = scene.compiled(gives_way=True)
    residual, of_contacts = compiled.layout.residual[0]
    assert residual > of_contacts > 0
    result = lf.simulate(scene, 1e-4, lf.MasslessBoundary(step=1e-7), progress=False)
    sizes = np.linalg.svd(result.u[:, 3 : 9 + residual], compute_uv=False)
    assert (sizes > 1e-12 * sizes[0]).sum() == 6 + 3  # and the three ways of the weld, which one contact node shares
    soft = lf.simulate(scene, 1e-4, lf.MasslessBoundary(step=1e-7, compliance={"strike": LAW}), progress=False)
    modes = soft.modes_of("strip").columns
    assert (soft.u[:, modes] != 0.0).any(axis=0).all()


def matrices() -> lf.Matrices:
    """The strip as matrices of a program that is not known."""
    mesh = lf.meshes.bar(0.3, 0.01, 30)
    parts = lf.Continuum(mesh, poissons_ratio=0.3, thickness=0.02, **STEEL).finite_elements()
    top = [int(n) for n in np.flatnonzero(parts.places[:, 1] > 0.005 - 1e-9)]
    top.sort(key=lambda node: -parts.places[node, 0])
    return lf.Matrices(parts.mass, parts.stiffness, parts.places, node_sets={"top": top})


@pytest.mark.parametrize("kind", ["beam", "matrices"])
def test_too_few_modes_for_an_impact_are_told_of_every_body(kind: str) -> None:
    model: Any = STRIP if kind == "beam" else matrices()
    law = lf.ContactLaw(LAW)
    few, enough = (
        lf.simulate(struck(model, law=law, modes=n, contact_nodes=0), 4e-4, lf.Smooth(), record=5e-7) for n in (3, 16)
    )
    assert any("free modes" in t or "the modes of 'strip' (3) end at" in t for t in few.warnings)
    assert any("keep more" in text for text in few.warnings)
    assert not any("keep more" in text for text in enough.warnings)


def test_residual_modes_hold_no_waves() -> None:
    """They end above what was excited, and do not count: the free modes are too few all the same."""
    scene = struck(STRIP, law=lf.ContactLaw(LAW), modes=3, contact_nodes=3)
    result = lf.simulate(scene, 4e-4, lf.Smooth(), record=5e-7)
    assert result.modes_of("strip").frequency.max() > 5000.0
    assert any("the free modes of 'strip' (3) end at" in text for text in result.warnings)


def test_explicit_steps_are_chosen_by_the_highest_frequency() -> None:
    """A massless boundary chooses its step by the modes that have mass; residual ones of joints have."""
    alone, held = (struck(STRIP, modes=8) for _ in range(2))
    for x in (0.0, 0.3):
        strip = held.body("strip")
        held.load(lf.TorsionSpring(strip.at(x, 0.0), held.ground.at(x, 0.0), stiffness=1.0))
    stepper, lengths, highest = lf.MasslessBoundary(compliance={"strike": LAW}), [], []
    for scene in (alone, held):
        result = lf.simulate(scene, 4e-4, stepper, progress=False)
        lengths.append(result.times[-1] / result.steps)
        highest.append(result.modes_of("strip").frequency.max())
    assert highest[1] > 1.5 * highest[0]
    assert lengths[1] < 0.8 * lengths[0]
