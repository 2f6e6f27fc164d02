"""Reactions of joints as results: names, files, tables, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

FIELDS = ("joint_force", "joint_peak", "joint_impulse", "joint_unique")


def pendulum() -> lf.Scene:
    scene = lf.Scene()
    bob = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), "bob", position=(0.5, 0.0))
    scene.join(lf.Revolute(bob.at(-0.5, 0.0), scene.ground.at(0.0, 0.0), name="hinge"))
    return scene


@pytest.fixture(scope="module")
def result() -> lf.Result:
    return lf.simulate(pendulum(), 0.05, lf.MoreauJean(1e-3), record=0.01, progress=False)


def test_shapes_and_words(result: lf.Result) -> None:
    hinge = result.reaction("hinge")
    assert (hinge.name, hinge.force.shape, hinge.impulse.shape) == ("hinge", (6, 2), (6, 2))
    assert {getattr(hinge, name).shape for name in ("moment", "largest_force", "largest_moment", "unique")} == {(6,)}
    assert np.isnan(hinge.force[0]).all()
    assert np.isfinite(hinge.force[1:]).all()
    assert str(hinge).startswith("hinge: at most 2.83")


def test_a_file_keeps_them(result: lf.Result, tmp_path: Path) -> None:
    loaded = lf.Result.load(result.save(tmp_path / "run.npz"))
    for name in FIELDS:
        assert np.array_equal(getattr(loaded, name), getattr(result, name), equal_nan=True)


def test_results_of_older_versions_have_none(result: lf.Result, tmp_path: Path) -> None:
    older = replace(result, **dict.fromkeys(FIELDS))
    with pytest.raises(lf.ModelError, match="saved by a version that recorded none"):
        lf.Result.load(older.save(tmp_path / "run.npz")).reaction("hinge")


@pytest.mark.parametrize("name", ["Hinge", "", 3, None, ("hinge",)])
def test_unknown_joints(result: lf.Result, name: Any) -> None:
    with pytest.raises(lf.ModelError, match="joint: no joint"):
        result.reaction(name)


def test_a_table_has_them(result: lf.Result) -> None:
    pytest.importorskip("pandas")
    table = result.to_dataframe()
    assert np.array_equal(table["hinge.force y"], result.reaction("hinge").force[:, 1], equal_nan=True)
    assert np.array_equal(table["hinge.moment"], result.reaction("hinge").moment, equal_nan=True)


def test_growing_memory_and_pages_lose_nothing() -> None:
    """More instants than fit into a page: the impulse of the force is the change of momentum over all of them."""
    run = lf.simulate(pendulum(), 1.0, lf.MoreauJean(1e-3), progress=False)
    force = run.reaction("hinge").force[1:]
    assert force.sum(axis=0) * 1e-3 == pytest.approx(run.u[-1, :2] + [0.0, 9.81], abs=1e-9)


def test_a_run_that_goes_on(tmp_path: Path) -> None:
    """From a checkpoint, with the bits of the run that was not interrupted."""
    path = tmp_path / "run.npz"
    whole = lf.simulate(pendulum(), 0.1, lf.MoreauJean(1e-3), record=0.007, progress=False, checkpoint=path, every=1e-9)
    again = lf.resume(path)
    assert np.array_equal(again.reaction("hinge").force, whole.reaction("hinge").force, equal_nan=True)


def lying(links: int, friction: float) -> lf.Result:
    """A chain dropped flat on a floor, at rest after some steps."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    placed = [scene.add(lf.Box(0.08, 0.04, mass=1.0 + k % 3), position=(0.1 * k, 0.022)) for k in range(links)]
    for k, link in enumerate(placed):
        scene.contact(link.surface(), floor, friction=friction, name=f"floor {k}")
        if k:
            scene.join(lf.Revolute(placed[k - 1].at(0.05, 0.0), link.at(-0.05, 0.0), name=f"hinge {k}"))
    return lf.simulate(scene, 0.05, lf.MoreauJean(1e-3), record=1e-3, progress=False)


@pytest.mark.parametrize(("links", "friction"), [(3, 0.5), (5, 0.0), (14, 0.5), (14, 0.0)])
def test_what_contacts_may_share_is_marked(links: int, friction: float) -> None:
    """Each link stands by itself, or hangs on its hinges with less on the floor: many forces with one motion."""
    result = lying(links, friction)
    forces = np.array([result.reaction(f"hinge {k}").force[-1] for k in range(1, links)])
    balance = np.diff(np.vstack([np.zeros(2), forces, np.zeros(2)]), axis=0)[:, 1]  # of the hinges at each link
    masses = np.array([1.0 + k % 3 for k in range(links)])
    carried = masses * (9.81 + np.diff(result.u[-2:, 1::3], axis=0)[0] / 1e-3)
    pressed = np.diff(result.impulse[-2:, :, 0], axis=0)[0] / 1e-3
    assert pressed + balance == pytest.approx(carried, abs=1e-9)  # by the impulses
    assert result.force[-1, :, 0] != pytest.approx(pressed, abs=1e-3)  # not by the least forces, which are others
    assert not any(result.reaction(f"hinge {k}").unique[-1] for k in range(1, links))


def test_what_no_contact_shares_is_not_marked() -> None:
    """A lever on one support."""
    scene = lf.Scene()
    bar = scene.add(lf.RigidBody(mass=3.0, inertia=0.25), "bar", position=(0.5, 0.0))
    scene.join(lf.Revolute(bar.at(-0.5, 0), scene.ground.at(0, 0), name="hinge"))
    scene.contact(bar.node(0.3, 0.0), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="stop")
    result = lf.simulate(scene, 0.02, lf.MoreauJean(1e-3), progress=False)
    assert result.reaction("hinge").unique.all()
