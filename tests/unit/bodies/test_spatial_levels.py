"""Fidelity levels of bodies of space lead from the rigid body to the full mesh, all of them the same body."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
BEAM = lf.SpatialBeam(0.5, 2e-4, (2e-9, 6e-9), 4e-9, elements=3, **STEEL)


@cache
def part() -> Any:
    return lf.Solid.bar(0.2, 0.02, 0.01, size=0.02, **STEEL)


def levels_of(body: Any) -> list[Any]:
    assert body.fidelity_levels is not None
    return list(body.fidelity_levels())


def names_of(body: Any) -> list[str]:
    return [level.name for level in levels_of(body)]


MODES = ["rigid", "1 mode", "2 modes", "4 modes", "8 modes", "full mesh"]


@pytest.mark.parametrize(
    ("modes", "options", "names"),
    [
        (5, {}, MODES),
        (3, {"damping": [0.1, 0.2, 0.3]}, ["rigid", "1 mode", "2 modes", "3 modes"]),
        (
            2,
            {"interfaces": ["left"], "residual_damping": 0.3, "damping": 0.02},
            ["rigid", *(f"{n} free and 6 residual modes" for n in (1, 2, 4)), "full mesh"],
        ),
        (4, {"clamped": "left"}, MODES),
        (4, {"second_order": 3}, MODES),
        (4, {"stiffening": lf.Stiffening(held="left")}, MODES),
    ],
)
def test_of_beams(modes: int, options: dict[str, Any], names: list[str]) -> None:
    body = BEAM.reduce(modes, **options)
    assert names_of(body) == names
    for level in levels_of(body):
        made = level.make()
        assert made.modes == level.modes
        np.testing.assert_allclose(made.second, body.second, rtol=1e-12, atol=1e-12 * body.second.max())
        shared = min(level.modes, body.modes) - (body.residual_modes if level.modes < 18 else body.modes)
        np.testing.assert_allclose(made.stiffness[: max(shared, 0)], body.stiffness[: max(shared, 0)], rtol=1e-9)
        assert (made.geometric is None) == (body.geometric is None or not level.modes)
        assert names_of(made) == names


@pytest.mark.parametrize(
    ("options", "static", "words"),
    [
        ({}, 0, "{n} modes"),
        ({"interfaces": ["left"]}, 6, "{n} free and 6 residual modes"),
        ({"contact": [0]}, 3, "{n} free and 3 residual modes"),
        ({"boundary": [0, 1, 2]}, 9 - 6, "{n} modes and 3 of the boundary"),
        ({"clamped": "left"}, 0, "{n} modes"),
    ],
)
def test_of_solids(options: dict[str, Any], static: int, words: str) -> None:
    """Static shapes stand beside modes, and neither in the rigid body nor in the full mesh, which has them."""
    body = part().reduce(4, damping=0.01, **options)
    levels = levels_of(body)
    assert [level.name for level in levels][:2] == ["rigid", words.format(n=1).replace("1 modes", "1 mode")]
    assert levels[3].name == words.format(n=4)
    assert levels[3].modes == 4 + static == body.modes
    held = len(part().finite_elements().sets["left"]) * 3 - 6 if "clamped" in options else 0
    assert (levels[-1].name, levels[-1].modes) == ("full mesh", 3 * len(part().finite_elements().places) - 6 - held)
    for level in (levels[0], levels[1], levels[3], levels[-1]):
        assert level.make().modes == level.modes
    again = pickle.loads(pickle.dumps(body))
    np.testing.assert_array_equal(levels_of(again)[3].make().stiffness, body.stiffness)


def test_of_component_modes() -> None:
    body = lf.craig_bampton(part(), "left", 4)
    names = names_of(body)
    assert names[:4] == ["rigid", "1 mode", "2 modes", "4 modes"]
    assert names[-2:] == ["boundary nodes", "full mesh"] or names[-1] == "full mesh"
    for level in (levels_of(body)[2], levels_of(body)[-1]):
        made = level.make()
        assert made.modes == level.modes
        assert names_of(made) == names


def test_levels_are_a_function() -> None:
    with pytest.raises(lf.ModelError, match="fidelity_levels: 3 was given, expected a function"):
        replace(BEAM.reduce(2), fidelity_levels=3)


def test_levels_of_a_very_large_mesh_end_below_it() -> None:
    large = lf.Solid.bar(0.2, 0.02, 0.02, size=0.0035, **STEEL)
    levels = levels_of(large.reduce(0))
    assert 3 * large.finite_elements().places.shape[0] > 6000
    assert [level.modes for level in levels] == [0, *(2**k for k in range(8))]
    assert levels[-1].name == "128 modes"
