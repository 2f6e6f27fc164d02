"""Results of many pairs: what is looked for once, and what only pairs that touched are asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.checks import resolution
from lcpflex.results import contacts_by_name as index
from lcpflex.results.result import Result

ROW = 12


def run(stepper: Any) -> Result:
    """A row of discs that fall one by one onto a floor: each pair is declared, neighbours and the floor touch."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    discs = [
        scene.add(lf.Disc(0.05, mass=1.0), f"disc{k}", position=(0.1 * k, 0.051 + 0.002 * k)).surface()
        for k in range(ROW)
    ]
    for i, disc in enumerate(discs):
        scene.contact(disc, floor, friction=0.3, name=f"floor {i}")
        for j in range(i + 1, ROW):
            scene.contact(disc, discs[j], friction=0.3, name=f"{i} and {j}")
    return lf.simulate(scene, 0.06, stepper, record=0, progress=False)


@pytest.fixture(scope="module", params=[lf.MoreauJean(1e-3), lf.EventDriven()], ids=lambda s: type(s).__name__)
def result(request: pytest.FixtureRequest) -> Result:
    return run(request.param)


def test_it_is_what_a_scan_finds(result: Result) -> None:
    points = result.contact_points
    assert len(points.record) > 0
    for k, name in enumerate(result.contact_names):
        found = result.contact(name)
        own = (points.contact == k) & (points.force[:, 0] > 0.0)
        np.testing.assert_array_equal(found.pairs, np.bincount(points.record[own], minlength=len(result.times)))
        assert found.events == tuple(event for event in result.events if event.contact == name)
        np.testing.assert_array_equal(found.force, result.force[:, k])


def test_points_and_events_are_scanned_once(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    scans = []
    made = index._made
    monkeypatch.setattr(index, "_found", type(index._found)())
    monkeypatch.setattr(index, "_made", lambda of: scans.append(of) or made(of))
    for name in result.contact_names:
        result.contact(name)
    assert scans == [result]


def test_another_result_has_its_own() -> None:
    first, second = (run(lf.MoreauJean(1e-3)) for _ in range(2))
    assert index.contacts_by_name(first) is index.contacts_by_name(first)
    assert index.contacts_by_name(first) is not index.contacts_by_name(second)


def test_names_that_are_not_there(result: Result) -> None:
    unknown: list[Any] = ["nobody", 3, None, ["floor 0"]]
    for name in unknown:
        with pytest.raises(lf.ModelError, match="name: no contact"):
            result.contact(name)


def test_checks_ask_pairs_that_touched(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    few_pairs = resolution._few_pairs
    monkeypatch.setattr(resolution, "_few_pairs", lambda r, law, name: asked.append(law) or few_pairs(r, law, name))
    resolution.unresolved(result)
    touched = [k for k, name in enumerate(result.contact_names) if result.contact(name).impulse.any()]
    assert asked == touched
    assert 0 < len(touched) < 0.5 * len(result.contact_names)
