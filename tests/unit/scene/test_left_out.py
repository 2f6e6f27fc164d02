"""What "everything against everything" leaves out is told, or refused."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

import lcpflex as lf

UP = (0.0, 0.0, 1.0)


def told(scene: Any) -> tuple[str, ...]:
    warnings: tuple[str, ...] = scene.compiled().warnings
    return warnings


def rims(
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81), floor: bool = True
) -> tuple[lf.SpatialScene, list[Any]]:
    """Two discs that have rims alone, and a box: rims touch planes, and nothing else."""
    scene = lf.SpatialScene(gravity)
    if floor:
        scene.ground.plane((0.0, 0.0, 0.0), UP)
    disc = lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1])
    discs = [scene.add(disc, name, position=(0.0, k, 1.0)) for k, name in enumerate(("low", "high"))]
    for one in discs:
        one.rim("center", UP, 0.1)
    return scene, [*discs, scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "box", position=(3.0, 0.0, 1.0))]


def test_pairs_without_a_contact_are_told_by_their_kinds_number_and_names() -> None:
    scene, _ = rims()
    scene.contact_all()
    text = (
        "contact_all: a {} has no contact with a rim and passes through it: {}; exclude what may, or give one of them "
    )
    pairs = {"convex polyhedron": "'box.surface' and 'low.rim1', 'box.surface' and 'high.rim1'"}
    pairs["rim"] = "'low.rim1' and 'high.rim1'"
    found = sorted(told(scene))
    assert found == [text.format(kind, named) + "another surface" for kind, named in sorted(pairs.items())]
    with pytest.warns(lf.ModelWarning) as caught:
        scene.compile()
    assert sorted(str(one.message) for one in caught) == found
    result = lf.simulate(scene, 2e-3, lf.MoreauJean(step=1e-3), progress=False)
    assert set(found) <= set(result.warnings)
    assert all(text in result.summary() for text in found)


def test_what_the_user_leaves_out_is_not_told() -> None:
    scene, (low, high, box) = rims()
    scene.contact_all(exclude=[(low, high), (box, low)])
    assert len(told(scene)) == 1
    scene.join(lf.Ball(high.at(0.0, 0.0, 0.0), box.at(-3.0, 1.0, 0.0)))
    assert told(scene) == ()
    scene.contact_all(friction=0.5, exclude=[(box, low)])  # of low and high, it is for the second rule to say
    (only,) = told(scene)
    assert "'low.rim1' and 'high.rim1'" in only


def test_points_and_solids_that_fill_all_around_do_not_meet() -> None:
    scene, (low, high, box) = rims()
    low.node("center")
    high.node("center")
    box.hole("center", 0.01)
    scene.ground.plane((0.0, 0.0, -1.0), UP)
    scene.contact_all(exclude=[(low, high), (box, low), (box, high)])
    assert told(scene) == ()


@pytest.mark.parametrize("load", ["none", "force", "spring", "joint", "declared"])
def test_what_falls_through_all_that_it_meets_is_refused_where_nothing_holds_it(load: str) -> None:
    scene, (low, high, box) = rims(floor=False)
    scene.ground.box((0.0, 0.0, -1.0), (2.0, 2.0, 2.0))
    high.sphere("center", 0.1)
    scene.contact_all()
    there = scene.ground.at(0.0, 0.0, 1.0)
    if load == "force":
        scene.load(lf.Force(low.point("center"), (0.0, 0.0, 9.81)))
    elif load == "spring":
        scene.load(lf.Spring(low.point("center"), scene.ground.at(0.0, 0.0, 2.0), 100.0))
    elif load == "joint":
        scene.join(lf.Ball(low.point("center"), there))
    elif load == "declared":
        scene.contact(low.sphere("center", 0.1), box.surface())
    if load != "none":
        assert any("'ground.box1' and 'low.rim1'" in text for text in told(scene))
        return
    wanted = r"'low' would fall through all that there is.* 'low.rim1' and 'box.surface'.*a rim with one of: plane"
    with pytest.raises(lf.ModelError, match=wanted):
        scene.compile()
    with pytest.raises(lf.ModelError, match=wanted):
        lf.simulate(scene, 2e-3, lf.EventDriven(), progress=False)


def test_bodies_that_are_joined_fall_together() -> None:
    """A frame with discs on it: nothing that they meet carries them, and one foot does."""
    scene = lf.SpatialScene()
    scene.ground.box((0.0, 0.0, -1.0), (4.0, 4.0, 2.0))
    frame = scene.add(lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1]), "frame", position=(0.0, 0.0, 1.0))
    for k, x in enumerate((-0.5, 0.5)):
        wheel = scene.add(lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1]), f"wheel{k}", position=(x, 0.0, 1.0))
        wheel.rim("center", (0.0, 1.0, 0.0), 0.1)
        scene.join(lf.Ball(wheel.point("center"), frame.at(x, 0.0, 0.0)))
    scene.contact_all()
    with pytest.raises(lf.ModelError, match=r"'frame', 'wheel0', 'wheel1' would fall.*'wheel0.rim1' and 'ground.box1'"):
        scene.compile()
    frame.sphere("center", 0.1)
    assert len(told(scene)) == 2  # rims with the box and with each other; of no wheel with the ball of its own frame


def test_nothing_is_refused_without_gravity() -> None:
    scene, _ = rims((0.0, 0.0, 0.0), floor=False)
    scene.contact_all()
    assert len(told(scene)) == 2


def test_bodies_without_a_surface_are_told() -> None:
    scene, _ = rims()
    low, high, box = (scene.body(name) for name in ("low", "high", "box"))
    scene.add(lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1]), "ghost")
    held = scene.add(lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1]), "held")
    scene.join(lf.Ball(held.point("center"), scene.ground.at(0.0, 0.0, 0.0)))
    scene.contact_all(exclude=[(low, high), (low, box), (high, box)])
    compiled = scene.compiled()
    (warning,) = compiled.warnings
    assert re.search("nothing holds and nothing touches 'ghost', without a surface", warning)
    assert compiled.notes == ("contact_all: nothing touches 'held', without a surface",)


def test_the_same_in_the_plane() -> None:
    scene = lf.Scene()
    ring = scene.add(lf.RigidBody(1.0, 0.1), "ring", (0.0, 1.0))
    ring.hole("center", 0.2)
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.add(lf.RigidBody(1.0, 0.1), "ghost")
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", (5.0, 1.0))
    scene.contact_all(exclude=[(disc, ring)])
    with pytest.raises(lf.ModelError, match=r"'ring' would fall through .*'ring.hole1' and 'ground.half_plane1'"):
        scene.compile()
    ring.circle("center", 0.3)
    (warning,) = told(scene)
    assert "nothing touches 'ghost'" in warning


def test_thousands_of_surfaces_are_counted_by_their_kinds() -> None:
    """Not pair by pair, of which there are half a million."""
    numbers = []
    for count in (500, 1000):
        scene = lf.SpatialScene()
        scene.ground.plane((0.0, 0.0, 0.0), UP)
        disc = lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1])
        for k in range(count):
            scene.add(disc, position=(float(k), 0.0, 1.0)).rim("center", UP, 0.1)
        scene.contact_all()
        (text,) = told(scene)
        numbers.append(int(re.findall(r"(\d+) more", text)[0]))
    assert numbers == [math.comb(500, 2) - 3, math.comb(1000, 2) - 3]
