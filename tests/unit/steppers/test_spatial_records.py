"""What is written down of contacts in space: forces on the body of the first surface, on whichever side of a pair."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from lcpflex.contact.rule_pairs import RulePairs
from lcpflex.contact.spatial.table import side_of, spatial_contact_table
from lcpflex.jit.struct import allocate, put_array
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.results.contact_history import ContactPoints
from lcpflex.runs.page_result import touching_points
from lcpflex.steppers.recorder import IN_SPACE
from lcpflex.steppers.spatial.records import add_impulse, note_spatial_contact

OWNER = np.array([2, 0, 1])  # bodies of three surfaces
GIVEN = np.array([[0, 1], [2, 0]])  # surfaces of two declared contacts


def entries(laws: list[int], bodies: list[tuple[int, int]], seed: int = 1) -> Any:
    """A table with entries of these contacts, sides i and j on these bodies, with random normals and tangents."""
    rng = np.random.default_rng(seed)
    table = spatial_contact_table(len(laws))
    table.law[:], table.body[:] = laws, bodies
    normal = rng.normal(size=(len(laws), 3))
    table.normal[:] = normal / np.linalg.norm(normal, axis=1)[:, None]
    along = np.cross(table.normal, rng.normal(size=(len(laws), 3)))
    table.tangent[:] = along / np.linalg.norm(along, axis=1)[:, None]
    return table


def recording(laws: int = 2, points: int = 8) -> Any:
    """What the kernels write to, without the rest of a recorder."""
    told = spatial_contact_table(0)
    put_array(told, "first", GIVEN[:, 0].copy())
    put_array(told, "owner", OWNER.copy())
    return SimpleNamespace(
        table=told, now_force=np.zeros((laws, 4)), now_state=np.zeros(laws, np.int64),
        points=np.zeros((points, IN_SPACE)), total_impulse=np.zeros((laws, 4)), n_points=0, n_instants=3,
    )  # fmt: skip


def noted(table: Any, forces: Any, states: list[int]) -> Any:
    """A recording of entries with these forces along n, t1 and t2."""
    told = recording()
    for k, (force, state) in enumerate(zip(forces, states, strict=True)):
        note_spatial_contact.py_func(told, table, k, (1.0 * k, 2.0, 3.0), *force, state)
    return told


def test_a_force_is_that_on_the_body_of_the_first_surface_whichever_side_a_pair_has_it_on() -> None:
    table = entries([0, 1, 1], [(2, 0), (1, 2), (2, 1)])  # the last one the other way round
    second = np.cross(table.normal, table.tangent)
    table.area[:] = 0.5, 0.0, 2.0
    forces = np.array([[5.0, 1.0, -2.0], [4.0, 0.5, 0.25], [3.0, -1.0, 0.75]])
    on_i = forces[:, :1] * table.normal + forces[:, 1:2] * table.tangent + forces[:, 2:] * second
    expected = on_i * np.array([[1.0], [1.0], [-1.0]])
    told = noted(table, forces, [STICK, SLIP, STICK])
    found: ContactPoints = touching_points(SimpleNamespace(data={"points": told.points[:3]}, laws=[None, None]))  # type: ignore[arg-type]
    assert found.vector == pytest.approx(expected, abs=1e-14)
    assert found.normal == pytest.approx(table.normal * np.array([[1.0], [1.0], [-1.0]]), abs=1e-16)
    assert np.abs((found.normal * found.friction_force).sum(axis=1)).max() < 1e-15
    assert found.contact.tolist() == [0, 1, 1]
    assert found.record.tolist() == [3, 3, 3]
    assert found.place.tolist() == [[0.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 2.0, 3.0]]
    assert found.area.tolist() == [0.5, 0.0, 2.0]
    assert found.state.tolist() == [STICK, SLIP, STICK]
    assert told.now_force[:, 0].tolist() == [5.0, 7.0]
    assert told.now_force[1, 1:] == pytest.approx(found.friction_force[1:].sum(axis=0), abs=1e-15)
    assert told.now_state.tolist() == [STICK, SLIP]


def test_impulses_of_rows_sum_up_to_the_same_vectors() -> None:
    table = entries([0, 1, 1], [(2, 0), (1, 2), (2, 1)])
    forces = np.array([[5.0, 1.0, -2.0], [4.0, 0.5, 0.25], [3.0, -1.0, 0.75]])
    laid = SimpleNamespace(table=table, n_contacts=3, tangent=np.repeat(np.arange(3), 2))
    work = SimpleNamespace(rows=laid, posed=SimpleNamespace(tangent_of=np.array([0, 2, 4])))
    told, rows = recording(), [*forces[:, 0], *forces[:, 1:].ravel()]
    for r, p in enumerate(rows):
        add_impulse.py_func(work, r, float(p), told)
    assert told.total_impulse == pytest.approx(noted(table, forces, [STICK] * 3).now_force, abs=1e-15)


def test_of_a_pair_by_a_rule_the_earlier_surface_is_the_first() -> None:
    told = spatial_contact_table(0, pairs=allocate(
        RulePairs, dict.fromkeys(("slots", "surfaces", "buckets", "levels", "found", "counts"), 0),
        pair=np.array([[-1, -1], [-1, -1], [-1, -1], [1, 2]]),
    ))  # fmt: skip
    put_array(told, "first", GIVEN[:, 0].copy())
    put_array(told, "owner", OWNER.copy())
    assert (side_of(told, 3, 0), side_of(told, 3, 1)) == (1.0, -1.0)
    assert (side_of(told, 1, 1), side_of(told, 1, 2)) == (1.0, -1.0)
