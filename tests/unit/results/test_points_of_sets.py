"""The mean of a set of nodes is asked for by its name: the material at its middle moves otherwise."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError


def test_the_middle_of_a_surface_is_no_material_point() -> None:
    """A bar that bends: the mean of its whole surface lies at its middle, and does not bend with it."""
    bar = lf.Solid.bar(0.5, 0.02, 0.02, size=0.02, density=7800.0, youngs_modulus=2.1e9, poissons_ratio=0.3)
    scene = lf.SpatialScene()
    body = scene.add(bar, "bar", modes=2)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(-0.25, 0.0, 0.0)))
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3))
    with pytest.raises(ModelError, match=r"is neither a named point.*the mean of the nodes of 'surface'"):
        result.point("bar", (0.0, 0.0, 0.0))
    assert np.isfinite(result.point("bar", "surface")).all()
