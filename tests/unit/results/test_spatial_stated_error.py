"""Stated errors of spatial runs bound the true ones of free rotation, and the summary tells them."""

from __future__ import annotations

import re

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.stated_error import scene_size

OMEGA = np.array([4.04901407, 2.93352774, 2.33771363])  # of J = (1, 2, 3), omega0 = (.01, 5, .01) after 8 s


def tumbling() -> lf.SpatialScene:
    """Mass and inertia alone: nothing is known of its extent."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag([1.0, 2.0, 3.0]))
    scene.add(body, "top", angular_velocity=(0.01, 5.0, 0.01))
    return scene


@pytest.mark.parametrize("step", [4e-3, 1e-3])
def test_stated_errors_of_a_tumbling_body_are_those_of_its_rotation(step: float) -> None:
    result = lf.simulate(tumbling(), 8.0, lf.MoreauJean(step=step))
    radius = np.sqrt(3.0)  # of gyration
    true = radius * float(np.linalg.norm(result.u[-1, 3:6] - OMEGA))
    assert result.speed_error is not None
    assert result.place_error is not None
    # errors of a tumbling body grow along its motion, which sums of local errors do not know of
    assert 0.25 * true < result.speed_error < 4.0 * true  # half of it
    assert result.place_error > 0.0


def test_a_summary_tells_them() -> None:
    result = lf.simulate(tumbling(), 1.0, lf.MoreauJean(step=1e-3))
    assert scene_size(result) == result.compiled.size  # type: ignore[union-attr]
    words = result.summary()
    assert "7 coordinates and 6 velocities" in words
    assert re.search(r"local errors of the steps sum up to .* \(.* % of the largest extent or travel\)", words)
    assert "nan" not in words
