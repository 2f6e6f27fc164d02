"""The fastest point of a run is found without looking closely at every instant."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.jit.kernel import FloatArray
from lcpflex.results.motion_units import ROWS, Units

SCENES = ("pendulum", "double_pendulum", "two_bars", "puck", "sphere_on_plate")


def units_of(scene: Any) -> tuple[Units, int]:
    model = scene.compile().model
    ndof = int(model.bodies.dof[-1])
    return Units(model, ndof), ndof


def swinging(m: int, ndof: int) -> FloatArray:
    """Rates of m instants, of waves that come and go."""
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 300.0, m)[:, None]
    return np.asarray(rng.normal(size=ndof) * np.sin(t * rng.uniform(0.5, 9.0, ndof)) * np.sin(0.01 * t))


@pytest.mark.parametrize("name", SCENES)
def test_it_is_the_largest(name: str) -> None:
    units, ndof = units_of(gallery.scenes()[name].build())
    for u in (swinging(2000, ndof), np.zeros((3, ndof)), np.ones((700, ndof)), np.zeros((0, ndof))):
        assert units.largest(u) == pytest.approx(float(units.of(u).max(initial=0.0)), rel=1e-14)


def test_a_run_that_went_astray_has_none() -> None:
    units, ndof = units_of(gallery.scenes()["pendulum"].build())
    u = swinging(50, ndof)
    u[20, 4] = np.nan
    assert np.isnan(units.largest(u))


def test_few_instants_are_looked_at_closely(monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[int] = []
    bent = Units._bent
    monkeypatch.setattr(Units, "_bent", lambda self, b, u: looked.append(len(u)) or bent(self, b, u))
    result = lf.simulate(gallery.scenes()["pendulum"].build(), 0.5, lf.MoreauJean(1e-4), record=0, progress=False)
    looked.clear()
    assert Units(result.compiled.model, result.u.shape[1]).largest(result.u) > 0.0
    assert 0 < sum(looked) <= 2 * ROWS < 0.2 * len(result.times)
