"""Random contact problems by every way to a solver: see :mod:`tests.property.solver_campaign`."""

from __future__ import annotations

import numpy as np
import pytest

from tests.property.random_contacts import LARGEST, Drawn, draw, miss
from tests.property.solver_campaign import WAYS, WHOLE, Answer, answered, campaign, count

# Of all problems: within 1e-10 of the load at least, within 1e-8 at least.
LEAST = {
    (2, "delassus"): (0.985, 0.99),
    (2, "sparse"): (0.985, 0.99),
    (2, "factor"): (0.985, 0.99),
    (2, "bodies"): (0.98, 0.98),
    (3, "delassus"): (0.985, 0.99),
    (3, "sparse"): (0.985, 0.99),
    (3, "factor"): (0.985, 0.99),
    (3, "bodies"): (0.96, 0.97),
}


def check(dimension: int, way: str, seeds: range) -> None:
    counts, (close, near) = campaign(dimension, way, seeds), LEAST[dimension, way]
    assert counts["wrong"] == 0
    assert counts["within 1e-10"] >= close * len(seeds)
    assert counts["within 1e-8"] >= near * len(seeds)


@pytest.mark.slow
@pytest.mark.parametrize(("dimension", "way"), LEAST)
def test_two_hundred_problems(dimension: int, way: str) -> None:
    check(dimension, way, range(1000, 1200))


@pytest.mark.campaign
@pytest.mark.parametrize(("dimension", "way"), LEAST)
def test_all_problems(dimension: int, way: str) -> None:
    check(dimension, way, WHOLE)


def one_contact(*velocity: float) -> Drawn:
    """A mass point of 4 kg on a rough floor, mu = .5, with the velocity (normal, tangents) before its contact."""
    size = len(velocity)
    white = np.zeros((size, 2, size))
    white[:, 0] = 0.5 * np.eye(size)
    free = np.array(velocity)
    body = np.array([[0, -1]] * size)
    return Drawn(size, 0, "", 1, white, body, free, np.abs(free), np.array([0.5]))


@pytest.mark.parametrize(
    ("velocity", "impulse"),
    [
        ((-1.0, 0.25), (4.0, -1.0)),  # sticks
        ((-1.0, 2.0), (4.0, -2.0)),  # slides on
        ((1.0, -3.0), (0.0, 0.0)),  # is open
        ((-1.0, 0.3, 0.0), (4.0, -1.2, 0.0)),
        ((-1.0, 3.0, -4.0), (4.0, -1.2, 1.6)),
        ((1.0, 3.0, -4.0), (0.0, 0.0, 0.0)),
    ],
)
def test_the_judge_knows_a_mass_point_on_a_floor(velocity: tuple[float, ...], impulse: tuple[float, ...]) -> None:
    drawn, right = one_contact(*velocity), np.array(impulse)
    assert miss(drawn, right) <= 1e-15
    for change in np.concatenate([np.eye(len(right)), -np.eye(len(right))]):
        assert miss(drawn, right + 0.04 * change) >= 1e-3  # a hundredth of the load in velocities
    assert miss(drawn, np.full(len(right), np.nan)) == np.inf


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_judge_sees_every_force_that_is_off(dimension: int) -> None:
    """Those of contacts with their pins condensed, and those of all rows."""
    for seed, way in [(48, "factor"), (18, "delassus"), (18, "bodies"), (8 if dimension == 3 else 48, "bodies")]:
        drawn = draw(dimension, seed)
        forces = WAYS[way](drawn)[0]
        right = miss(drawn, forces)
        assert right <= 1e-9
        for row in range(0, len(forces), 7):
            unit = np.sqrt((drawn.J[row // dimension * dimension :][:dimension] ** 2).sum(axis=1).max())
            bad = forces.copy()
            bad[row] += np.abs(drawn.free).max() / unit
            assert miss(drawn, bad) >= max(1e3 * right, 1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_problems_are_what_they_say(dimension: int) -> None:
    kinds = set()
    for seed in range(60):
        drawn = draw(dimension, seed)
        n, J = len(drawn.friction), drawn.J
        kinds.update(drawn.kind.split())
        assert 2 <= n <= LARGEST
        assert drawn.friction.max() <= 3.0
        copies = n - len(np.unique(J[: drawn.of_contacts : dimension], axis=0))
        assert copies == 0 or "threefold" in drawn.kind
        assert ("pins" in drawn.kind) == (len(J) > drawn.of_contacts)
        moved = J @ np.linalg.lstsq(J, drawn.free)[0] - drawn.free
        assert np.abs(moved).max() <= 1e-9 or "gaps" in drawn.kind  # the bodies have that motion
        assert drawn.condensed[0].shape == (drawn.of_contacts, J.shape[1])
        assert np.abs(drawn.condensed[0] @ J[drawn.of_contacts :].T).max(initial=0.0) <= 1e-9 * (J**2).max()
    assert kinds >= {"masses", "threefold", "pins", "gaps", "3"}
    assert draw(dimension, 5).free.tobytes() == draw(dimension, 5).free.tobytes()


def test_counts_tell_what_is_wrong() -> None:
    drawn = one_contact(-1.0, 2.0)
    made = [Answer(drawn, "bodies", solved, off, 1e-3, "") for solved, off in [(True, 1e-11), (False, 1e-3)]]
    told = count([*made, Answer(drawn, "bodies", True, 1e-5, 1e-3, ""), Answer(drawn, "bodies", True, 1e-9, 1e-3, "")])
    names = ("problems", "within 1e-10", "within 1e-8", "solved", "wrong")
    assert [told[name] for name in names] == [4, 1, 2, 3, 1]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_each_way_solves_a_few(dimension: int, way: str) -> None:
    answers = [answered(draw(dimension, seed), way) for seed in range(20, 30)]
    assert sum(one.within for one in answers) >= 9
    assert all(one.miss <= 1e-8 for one in answers)
