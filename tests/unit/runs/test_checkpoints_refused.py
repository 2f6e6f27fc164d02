"""Checkpoints and arguments that a run does not go on with, and runs that begin from a result."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.runs.checkpoint import read
from tests.unit.runs.checkpoint_runs import assert_same_bits, broken_off, own_system, pushed, thrown


def changed(path: Path, **entries: Any) -> None:
    """The file with other entries in its structure."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    structure = json.loads(str(arrays.pop("structure")))
    for name, value in entries.items():
        structure[name] = {**structure[name], **value}
    np.savez(path, structure=np.array(json.dumps(structure)), **arrays)


def test_a_scene_or_stepper_that_is_another_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch)
    with pytest.raises(lf.ModelError, match=r"stepper: MoreauJean\(step=0.002.*stepper.step differs"):
        lf.resume(path, stepper=lf.MoreauJean(2e-3))
    with pytest.raises(lf.ModelError, match=r"stepper: EventDriven"):
        lf.resume(path, stepper=lf.EventDriven())
    other = thrown()
    other.add(lf.Disc(0.1, mass=1.0), position=(5.0, 5.0))
    with pytest.raises(lf.ModelError, match=r"scene: another one was given .*: scene.model"):
        lf.resume(path, scene=other)
    heavier = thrown()
    heavier.gravity = np.array((0.0, -9.81))
    with pytest.raises(lf.ModelError, match=r"scene.model.loads.gravity differs"):
        lf.resume(path, scene=heavier)
    with pytest.raises(lf.ModelError, match=r"scene: 'ball' was given"):
        lf.resume(path, scene="ball")
    assert lf.resume(path, thrown(), lf.MoreauJean(1e-3)).complete


def test_functions_have_to_be_given_again_and_to_be_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch, pushed)
    with pytest.raises(lf.ModelError, match=r"scene: none was given.*Python functions.*lf\.resume\(path, scene="):
        lf.resume(path)
    with pytest.raises(lf.ModelError, match=r"scene: other functions were given"):
        lf.resume(path, pushed(most=21.0))
    assert lf.resume(path, pushed()).complete
    broken_off(tmp_path / "own.npz", monkeypatch, own_system)
    with pytest.raises(lf.ModelError, match=r"scene: none was given.*UserSystem"):
        lf.resume(tmp_path / "own.npz")
    with pytest.raises(lf.ModelError, match=r"scene: other functions were given.*force"):
        lf.resume(tmp_path / "own.npz", own_system(stiffness=3.0))
    assert lf.resume(tmp_path / "own.npz", own_system()).complete


def test_a_solver_of_ones_own_has_to_be_given_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Own:
        def solve(self, problem: Any) -> Any:
            return lf.Auto().solve(problem)

        def __repr__(self) -> str:
            return "Own()"

    path = tmp_path / "run.npz"
    stepper = lf.MoreauJean(1e-3, solver=Own())
    broken_off(path, monkeypatch, stepper=stepper)
    with pytest.raises(lf.ModelError, match=r"stepper: none was given.*solver"):
        lf.resume(path)
    with pytest.raises(lf.ModelError, match=r"stepper: .* differs"):
        lf.resume(path, stepper=lf.MoreauJean(2e-3, solver=Own()))
    assert_same_bits(lf.simulate(thrown(), 0.1, stepper), lf.resume(path, stepper=stepper))


def test_another_version_is_refused_and_other_libraries_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch)
    changed(path, made={"numpy": "1.0"})
    assert any("numpy" in note and "1.0" in note for note in lf.resume(path).notes)
    changed(path, made={"lcpflex": "0.0.1"})
    with pytest.raises(lf.ModelError, match=r"written by lcpflex 0\.0\.1, expected"):
        lf.resume(path)
    changed(path, made={"lcpflex": lf.__version__, "sources": "0"})
    with pytest.raises(lf.ModelError, match=r"of other sources"):
        lf.resume(path)


def test_what_is_no_checkpoint_or_damaged_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each with its path, in few words; no other exception leaves."""
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch)
    whole = path.read_bytes()
    random = np.random.default_rng(3)
    damaged = [b"", b"PK", b"text\n" * 100, whole[: len(whole) // 2], whole[:-100], whole + b"x" * 10, whole[100:]]
    for _ in range(60):
        data = bytearray(whole)
        for at in random.integers(0, len(data), 3):
            data[at] ^= 1 << int(random.integers(8))
        damaged.append(bytes(data))
    bad = tmp_path / "bad.npz"
    messages = []
    for data in damaged:
        bad.write_bytes(data)
        try:
            read(bad)
        except lf.ModelError as error:
            messages.append(str(error))
    assert all(str(bad) in message and len(message) < 500 + len(str(bad)) for message in messages)
    assert len(messages) >= 55  # bits of the names' time stamps mean nothing
    lf.simulate(thrown(), 0.01, lf.MoreauJean(1e-3)).save(bad)
    for wrong in (bad, tmp_path, tmp_path / "none.npz", 3, None, "a\0b"):
        with pytest.raises(lf.ModelError, match=r"path"):
            lf.resume(wrong)  # type: ignore[arg-type]
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(lf.ModelError, match=r"path"):
        lf.resume(tmp_path / "array.npy")


@pytest.mark.parametrize(
    "entries",
    [
        {"run": {"object": "os:system"}},
        {"run": {"fields": {}}},
        {"run": {"object": "lcpflex.scene.scene:Scene"}},
        {"scene": {"object": "lcpflex.scene.handles:Placed"}},
        {"stepper": {"fields": {"step": {"array": "nowhere"}}}},
        {"options": {"object": "builtins:eval"}},
        {"made": {"more": "1"}},
    ],
)
def test_a_file_with_other_entries_is_refused(
    entries: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch)
    changed(path, **entries)
    with pytest.raises(lf.ModelError, match=r"no complete checkpoint"):
        lf.resume(path)


def test_a_run_that_is_under_way_is_not_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.npz"
    broken_off(path, monkeypatch)
    with pytest.raises(lf.ModelError, match=r"checkpoint: .* lf\.resume\(path\) goes on with it"):
        lf.simulate(thrown(), 0.1, lf.MoreauJean(1e-3), checkpoint=path)
    assert lf.resume(path).complete
    assert lf.simulate(thrown(), 0.01, lf.MoreauJean(1e-3), checkpoint=path).complete  # that one has ended
    path.write_text("of something else")
    with pytest.raises(lf.ModelError, match=r"checkpoint: .* no checkpoint"):
        lf.simulate(thrown(), 0.1, lf.MoreauJean(1e-3), checkpoint=path)
    assert path.read_text() == "of something else"


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"checkpoint": 3}, "checkpoint"),
        ({"checkpoint": "/nowhere/at/all/run.npz"}, "checkpoint"),
        ({"checkpoint": "."}, "checkpoint"),
        ({"every": -1.0}, "every"),
        ({"every": "1 min"}, "every"),
        ({"initial": 3}, "initial"),
    ],
)
def test_arguments_are_refused_before_the_run(arguments: dict[str, Any], name: str, tmp_path: Path) -> None:
    arguments = {"checkpoint": tmp_path / "run.npz"} | arguments
    with pytest.raises(lf.ModelError, match=f"^{name}: "):
        lf.simulate(thrown(), 0.1, lf.MoreauJean(1e-3), **arguments)
    assert not list(tmp_path.iterdir())
