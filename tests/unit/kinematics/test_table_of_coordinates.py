"""Kinds of relative coordinates are told apart in one table; nobody else asks which of them is an angle."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import lcpflex
from lcpflex.model.coordinates import ANGLE, ANGULAR, COORDINATES, KINDS, SPATIAL_KINDS, UNITS, is_angular

ROOT = Path(lcpflex.__file__).parent
BRANCHES = {  # what a kind is, one branch each: values and gradients; directions and rests from the start in space
    "kinematics/relative.py",
    "kinematics/spatial/relative.py",
    "compile/spatial/coordinates.py",
    "compile/spatial/loads.py",
}


def questions(source: str) -> Iterator[int]:
    """Lines that compare something with ANGLE, or a kind with "angle"."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Compare):
            parts = [part for side in (node.left, *node.comparators) for part in ast.walk(side)]
            names = {part.id if isinstance(part, ast.Name) else getattr(part, "attr", "") for part in parts}
            words = {part.value for part in parts if isinstance(part, ast.Constant)}
            about_kinds = any(name.rstrip("s").endswith("kind") for name in names)
            if "ANGLE" in names or (about_kinds and "angle" in words):
                yield node.lineno


def test_nobody_asks_for_the_kind_of_an_angle() -> None:
    asked = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in sorted(ROOT.rglob("*.py"))
        if str(path.relative_to(ROOT)) not in BRANCHES
        for line in questions(path.read_text())
    ]
    assert not asked, "take the column `angular` of lcpflex.model.coordinates"


@pytest.mark.parametrize(
    "text",
    [
        "kind == ANGLE",
        "ANGLE != kinds[r]",
        "kind in (ANGLE, TURN)",
        "relative.ANGLE == k",
        "row.kind == 'angle'",
        "'angle' in kinds",
        "{COMPONENT, ANGLE} <= kinds",
    ],
)
def test_questions_are_seen(text: str) -> None:
    assert list(questions(text)) == [1]


def test_the_plane_has_the_first_ones() -> None:
    assert SPATIAL_KINDS[: len(KINDS)] == KINDS
    assert len(set(SPATIAL_KINDS)) == len(COORDINATES) == len(UNITS) == len(ANGULAR)


def test_columns() -> None:
    assert SPATIAL_KINDS[ANGLE] == "angle"
    assert [unit == "rad" for unit in UNITS] == ANGULAR.tolist() == [is_angular(name) for name in SPATIAL_KINDS]
    assert np.flatnonzero(ANGULAR[: len(KINDS)]).tolist() == [ANGLE]
