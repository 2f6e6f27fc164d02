"""What the search for places of rest says while it works, and what it hands back when it is ended."""

from __future__ import annotations

from typing import Any

import pytest

import lcpflex as lf
from lcpflex.basics.stopwatch import Budget
from lcpflex.statics.path import Path
from tests.scenes import disc_on_floor


def two_valleys() -> lf.Scene:
    """A disc that a spring pulls into one of two grooves."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(0.003, mass=0.1), "disc", position=(0.01, 0.02))
    places = [(0.05, 0.0), (0.015, 0.0), (0.01, -0.005), (0.005, 0.0), (-0.005, 0.0), (-0.01, -0.005), (-0.015, 0.0)]
    scene.contact(disc.surface(), scene.ground.chain([*places, (-0.05, 0.0)]), name="strip")
    return scene


def test_a_place_of_rest(always: pytest.LogCaptureFixture) -> None:
    lf.equilibrium(disc_on_floor(0.2))
    assert any(line.startswith("equilibrium after 0 s: step ") for line in always.messages)
    assert any("of the forces that act" in line for line in always.messages)


def test_several_places(always: pytest.LogCaptureFixture) -> None:
    found = lf.equilibria(two_valleys(), reach=0.05)
    assert len(found) > 1
    assert any("equilibria after 0 s: 1 pushes done" in line for line in always.messages)
    assert any(f"{len(found)} places found" in line for line in always.messages)
    assert any("; step " in line for line in always.messages)  # the path within
    assert not found[0].warnings


@pytest.fixture(scope="module")
def whole() -> tuple[list[lf.Rest], int]:
    """A search to its end, and how many steps it took."""
    steps = [0]
    with pytest.MonkeyPatch.context() as patched:
        advance = Path.advance

        def counted(path: Path, *given: Any) -> bool:
            steps[0] += 1
            return advance(path, *given)

        patched.setattr(Path, "advance", counted)
        return lf.equilibria(two_valleys(), reach=0.05), steps[0]


@pytest.mark.parametrize(
    ("ends", "words"),
    [("interrupt", "interrupted, after "), pytest.param("budget", "the budget of 600 s", marks=pytest.mark.slow)],
)
def test_what_was_found_before_it_was_ended(
    ends: str, words: str, whole: tuple[list[lf.Rest], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By Ctrl-C, or by its budget, in the midst of the pushes."""
    places, last = whole[0], whole[1] - 2
    advance, steps = Path.advance, [0]

    def counted(path: Path, *given: Any) -> bool:
        steps[0] += 1
        if steps[0] == last and ends == "interrupt":
            raise KeyboardInterrupt
        return advance(path, *given)

    monkeypatch.setattr(Path, "advance", counted)
    monkeypatch.setattr(Budget, "is_spent", property(lambda budget: ends == "budget" and steps[0] >= last))
    found = lf.equilibria(two_valleys(), reach=0.05)
    assert len(found) == len(places)
    assert found[0].warnings[-1].startswith(f"equilibria: {words}")
    assert "more places may be left" in found[0].warnings[-1]
    for one, other in zip(found, places, strict=True):
        assert (one.q == other.q).all()


def test_interrupted_before_there_is_a_place(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(path: Path, *given: Any) -> bool:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "advance", interrupted)
    with pytest.raises(KeyboardInterrupt):
        lf.equilibria(two_valleys())
    with pytest.raises(KeyboardInterrupt):
        lf.equilibrium(two_valleys())


def test_a_budget_that_is_spent_at_once() -> None:
    for search in (lf.equilibrium, lf.equilibria):
        with pytest.raises(lf.SolverError, match=r"not at rest within budget = 1e-09 s and 0 steps"):
            search(disc_on_floor(0.2), budget=1e-9)
    with pytest.raises(lf.ModelError, match="progress: 3 was given"):
        lf.equilibria(disc_on_floor(), progress=3)  # type: ignore[arg-type]
