"""Numbers of kinds are names: no code asks which of two is the larger, so that a new kind may stand anywhere."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import lcpflex
from lcpflex.bodies.surface import NO_NODE, RANK, Kind, Surface, can_touch
from lcpflex.contact.rule_pairs import TOUCHES
from lcpflex.contact.spatial.table import (
    BY_CYLINDER,
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_CAP,
    NODE_RIM,
    NODE_SIDE,
    WITH_EDGE,
)

ROOT = Path(lcpflex.__file__).parent  # of solvers, the units of large problems come in an order: contacts, joint rows
ORDERS = ast.Lt, ast.LtE, ast.Gt, ast.GtE
KINDS = {  # modules whose capitals are kinds
    "lcpflex.contact.narrow_phase.feature",
    "lcpflex.contact.spatial.kinds",
    "lcpflex.contact.spatial.table",
    "lcpflex.model.coordinates",
}


def is_kind(part: ast.expr, constants: set[str]) -> bool:
    """Whether an expression is one of the constants, or an entry of something that is called kind."""
    while isinstance(part, ast.Subscript):
        part = part.value
    name = part.id if isinstance(part, ast.Name) else getattr(part, "attr", "")
    return name in constants or "kind" in name.rstrip("s").split("_")


def ordered(source: str) -> Iterator[int]:
    """Lines that compare kinds by <, <=, > or >=."""
    tree = ast.parse(source)
    constants = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module in KINDS
        for alias in node.names
        if alias.name.isupper()
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = (node.left, *node.comparators)
            for operator, pair in zip(node.ops, pairwise(sides), strict=True):
                if isinstance(operator, ORDERS) and any(is_kind(side, constants) for side in pair):
                    yield node.lineno


def test_no_kinds_are_compared_by_size() -> None:
    paths = [path for path in sorted(ROOT.rglob("*.py")) if "solvers" not in path.parts]
    found = [f"{path}:{line}" for path in paths for line in ordered(path.read_text())]
    assert not found, "name the kinds, or take a column of their table"


@pytest.mark.parametrize(
    "text",
    [
        "table.kind[k] >= 8",
        "kind < limit",
        "kinds[0] <= kinds[1]",
        "0 < c.surface_kind[a] < 3",
        "from lcpflex.contact.spatial.table import EDGE_SIDE as E\nx > E",
    ],
)
def test_comparisons_are_seen(text: str) -> None:
    assert set(ordered(text)) == {text.count("\n") + 1}


def test_columns_of_pairs_in_space() -> None:
    assert np.flatnonzero(WITH_EDGE).tolist() == [EDGE_EDGE, EDGE_SIDE, EDGE_RIM, EDGE_FACET, EDGE_CAP]
    assert np.flatnonzero(BY_CYLINDER).tolist() == [NODE_SIDE, NODE_CAP, NODE_RIM, EDGE_SIDE, EDGE_RIM, EDGE_CAP]


def test_what_touches_by_rank_touches_by_kind() -> None:
    for a in Kind:
        for b in Kind:
            ranks = RANK.get(a, NO_NODE), RANK.get(b, NO_NODE)
            touch = TOUCHES[ranks] or TOUCHES[ranks[::-1]]
            assert touch == can_touch(Surface(a, ()), Surface(b, ())) == (min(ranks) < NO_NODE and max(ranks) > 0)
