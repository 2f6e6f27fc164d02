"""Bodies that rest on the indentation of a force law from the start: admitted, and they stay where they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts
from tests.scenes import disc_on_floor, floor_of

WEIGHT = 9.81


def resting(
    stiffness: float, by_law: bool, radius: float = 0.1, mass: float = 1.0, gravity: float = WEIGHT
) -> lf.Scene:
    """A disc that its weight has pressed into the floor."""
    law = {"law": lf.Penalty(stiffness)} if by_law else {}
    return disc_on_floor(radius - mass * gravity / stiffness, radius=radius, mass=mass, gravity=gravity, **law)


STEPPERS: dict[str, tuple[bool, Any]] = {
    "event-driven": (True, lf.EventDriven()),
    "Moreau-Jean": (True, lf.MoreauJean(1e-4)),
    "smooth": (True, lf.Smooth()),
    "smooth, by a law of its own": (False, lf.Smooth(lf.Penalty(1e4))),
    "massless": (False, lf.MasslessBoundary(1e-4, compliance={"floor": lf.laws.PowerLaw(1e4, exponent=1.0)})),
}


@pytest.mark.parametrize(("by_law", "stepper"), STEPPERS.values(), ids=list(STEPPERS))
def test_a_body_rests_on_a_law(by_law: bool, stepper: Any) -> None:
    result = lf.simulate(resting(1e4, by_law), 0.05, stepper)
    depth = WEIGHT / 1e4
    assert result.q[:, 1] == pytest.approx(0.1 - depth, rel=0.0, abs=1e-12)
    assert result.contact("floor").least_gap == pytest.approx(-depth, rel=1e-9)
    assert result.contact("floor").force[-1, 0] == pytest.approx(WEIGHT, rel=1e-9)
    assert not result.warnings
    assert not doubts(result)


@pytest.mark.parametrize(
    "given",
    [{"stiffness": 100.0}, {"stiffness": 1e3, "radius": 100.0, "mass": 1e-3, "gravity": 9810.0}, {"stiffness": 1e9}],
    ids=["soft as foam", "millimetres and tonnes", "steel"],
)
def test_the_depth_is_that_of_the_law_at_any_size(given: dict[str, float]) -> None:
    scene = resting(by_law=True, **given)
    result = lf.simulate(scene, 0.02, lf.EventDriven())
    assert np.ptp(result.q[:, 1]) < 1e-9 * result.q[0, 1]


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(1e-4), lf.MasslessBoundary(1e-4)])
def test_what_has_no_law_must_not_penetrate(stepper: Any) -> None:
    with pytest.raises(lf.ModelError, match=r"contact 'floor': its surfaces penetrate by 0\.000981 m"):
        lf.simulate(resting(1e4, by_law=False), 0.05, stepper)


@pytest.mark.parametrize("first", ["law", "none"])
def test_of_two_contacts_the_one_without_a_law_is_refused(first: str) -> None:
    """In either order of declaration, also where the one by law is deeper."""
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.09))
    walls = {
        "law": (floor_of(scene), {"law": lf.Penalty(981.0)}),
        "none": (scene.ground.half_plane((-0.099, 0.0), (1.0, 0.0)), {}),
    }
    for name in ("law", "none") if first == "law" else ("none", "law"):
        wall, law = walls[name]
        scene.contact(disc.surface(), wall, name=name, **law)
    with pytest.raises(lf.ModelError, match=r"contact 'none': its surfaces penetrate by 0\.001 m"):
        lf.simulate(scene, 0.01, lf.EventDriven())


def test_a_system_of_ones_own_rests_where_the_stepper_has_a_law() -> None:
    system = lf.UserSystem(
        q=[-WEIGHT / 1e4], u=[0.0], mass=[[1.0]], force=lambda t, q, u: [-WEIGHT], gaps=lambda q: q, normals=[[1.0]]
    )
    result = lf.simulate(system, 0.02, lf.Smooth(lf.Penalty(1e4)))
    assert np.ptp(result.q) < 1e-12
    with pytest.raises(lf.ModelError, match=r"'contact1' penetrates by 0\.000981 m"):
        lf.simulate(system, 0.02, lf.MoreauJean(1e-4))


def test_least_gap_passes_over_what_was_too_far_to_measure() -> None:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 1.0))
    scene.contact(disc.surface(), floor_of(scene), name="floor")
    scene.contact(disc.surface(), scene.ground.half_plane((50.0, 0.0), (-1.0, 0.0)), name="far")
    result = lf.simulate(scene, 0.5, lf.MoreauJean(1e-3))
    floor, far = result.contact("floor"), result.contact("far")
    assert np.isnan(floor.gap[0])
    assert floor.least_gap == np.nanmin(floor.gap) < 1e-3
    assert np.isnan(far.gap).all()
    assert far.least_gap == np.inf
