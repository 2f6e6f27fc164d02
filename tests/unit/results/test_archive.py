"""Saved results: nothing is lost, nothing half-written is left, nothing is unpickled."""

from __future__ import annotations

import json
import os
import sys
import zipfile
from dataclasses import fields, is_dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit

import lcpflex as lf
from lcpflex.basics import libs
from lcpflex.dynamics.applied_forces import spring_energy
from lcpflex.errors import ModelError
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.results.archive import SIGNATURE
from lcpflex.results.energy_balance import Energies
from lcpflex.results.result import Result
from tests.full_disk import full_disk

without_h5py = pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")


def assert_same(a: Any, b: Any, path: str = "result") -> None:
    """Equal to the last bit, through dataclasses, named tuples, tuples and mappings."""
    if isinstance(a, np.ndarray):
        assert a.dtype == b.dtype, path
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), path
    elif is_dataclass(a):
        assert type(a) is type(b), path
        for field in fields(a):
            if field.name == "materials":  # of functions of a user's, which are not kept
                continue
            assert_same(getattr(a, field.name), getattr(b, field.name), f"{path}.{field.name}")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), path
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{path}[{k}]")
    elif isinstance(a, dict):
        assert_same(sorted(a.items()), sorted(b.items()), path)
    else:
        assert a == b, path


ENDINGS = (".npz", pytest.param(".h5", marks=without_h5py), pytest.param(".HDF5", marks=without_h5py))


@pytest.mark.parametrize("ending", ENDINGS)
def test_result_of_a_users_own_system_comes_back_whole(bounce: Result, tmp_path: Path, ending: str) -> None:
    assert_same(bounce, Result.load(bounce.save(tmp_path / f"bounce{ending}")))


@pytest.mark.parametrize("ending", ENDINGS)
def test_result_of_a_scene_comes_back_whole_and_can_be_drawn(swing: Result, tmp_path: Path, ending: str) -> None:
    loaded = Result.load(swing.save(tmp_path / f"swing{ending}"))
    assert_same(swing, loaded)
    np.testing.assert_array_equal(loaded.point("pendulum", "right"), swing.point("pendulum", "right"))
    loaded.draw(0.2).savefig(tmp_path / "drawn.png")
    assert (tmp_path / "drawn.png").stat().st_size > 5000


def test_file_is_open_to_any_program(swing: Result, tmp_path: Path) -> None:
    """Documented names, plain arrays, JSON; no pickle."""
    swing.save(tmp_path / "swing.npz")
    with np.load(tmp_path / "swing.npz", allow_pickle=False) as file:
        assert str(file["format"]) == "lcpflex result 2"
        np.testing.assert_array_equal(file["times"], swing.times)
        np.testing.assert_array_equal(file["energies.kinetic"], swing.energies.kinetic)
        assert "compiled.model.bodies.mass" in file
        assert json.loads(str(file["structure"]))["fields"]["stepper"] == swing.stepper


@without_h5py
def test_hdf5_file_has_the_names_of_npz(swing: Result, tmp_path: Path) -> None:
    import h5py

    swing.save(tmp_path / "swing.npz")
    swing.save(tmp_path / "swing.h5")
    with h5py.File(tmp_path / "swing.h5") as found, np.load(tmp_path / "swing.npz") as file:
        assert set(found) == set(file.files)
        texts = {name: bytes(found[name][()]).decode() for name in ("format", "structure")}
        assert texts == {name: str(file[name]) for name in texts}
        for name in set(file.files) - set(texts):
            np.testing.assert_array_equal(found[name][()], file[name])
        assert found["q"].dtype == np.float64


@without_h5py
def test_what_others_add_to_an_hdf5_file_is_left_alone(swing: Result, tmp_path: Path) -> None:
    import h5py

    with h5py.File(swing.save(tmp_path / "swing.h5"), "a") as file:
        file["of the user"] = np.arange(3.0)
        file["q"].attrs["remark"] = "as measured"
    assert_same(swing, Result.load(tmp_path / "swing.h5"))


@without_h5py
def test_a_changed_number_of_an_hdf5_file_is_seen(swing: Result, tmp_path: Path) -> None:
    """In a small array, which no filter of HDF5 guards; and an array of another type with the same bytes."""
    import h5py

    path = swing.save(tmp_path / "swing.h5")
    with h5py.File(path, "a") as file:
        file["compiled.model.bodies.mass"][0] *= 1.5
    with pytest.raises(ModelError, match=r"swing\.h5.*check sum of compiled\.model\.bodies\.mass"):
        Result.load(path)
    path = swing.save(tmp_path / "swing.h5")
    with h5py.File(path, "a") as file:
        kept, check = file["size"][()], file["size"].attrs["crc32"]
        del file["size"]
        file["size"] = kept.view(np.float64)
        file["size"].attrs["crc32"] = check
    with pytest.raises(ModelError, match="check sum of size"):
        Result.load(path)


@without_h5py
def test_an_hdf5_file_that_claims_more_than_it_holds(swing: Result, tmp_path: Path) -> None:
    import h5py

    path = swing.save(tmp_path / "swing.h5")
    with h5py.File(path, "a") as file:
        del file["q"]
        file.create_dataset("q", shape=(10**12,), chunks=(1000,), dtype=float)
    with pytest.raises(ModelError, match=r"swing\.h5.*q claims more numbers than the file holds: the shape \(10"):
        Result.load(path)


def test_hdf5_without_h5py(swing: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    monkeypatch.delitem(vars(libs), "h5py", raising=False)  # where another test has loaded it
    (tmp_path / "made.h5").write_bytes(SIGNATURE + bytes(1000))
    for work in (lambda: swing.save(tmp_path / "swing.h5"), lambda: Result.load(tmp_path / "made.h5")):
        with pytest.raises(ModelError, match=r"^path: .*\.h5.* needs h5py.*pip install 'lcpflex\[hdf5\]'"):
            work()
    assert not (tmp_path / "swing.h5").exists()


def test_a_file_for_paraview_is_no_file_of_a_result(swing: Result, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"path: .*swing\.vtkhdf.*expected the ending \.npz, \.h5 or \.hdf5"):
        swing.save(tmp_path / "swing.vtkhdf")


@pytest.mark.parametrize("ending", ENDINGS[:2])
def test_a_million_numbers_take_the_room_of_the_numbers(bounce: Result, tmp_path: Path, ending: str) -> None:
    """8 MB of random numbers, which nothing compresses, and 10 kB for all else."""
    m, n = 1000, 497
    zero, random = np.zeros(m), np.random.default_rng(5)
    q, u = random.standard_normal((2, m, n))
    many = replace(
        bounce, times=np.sort(random.random(m)), q=q, u=u, force=np.zeros((m, 1, 2)), impulse=np.zeros((m, 1, 2)),
        state=np.zeros((m, 1), np.int8), gap=random.random((m, 1)), residual=random.random(m),
        penetration=zero, joint_drift=zero, size=np.zeros(m, np.int64),
        energies=Energies(*random.standard_normal((8, m))),
    )  # fmt: skip
    numbers = q.size + u.size + 11 * m
    assert numbers > 1e6
    path = many.save(tmp_path / f"many{ending}")
    assert path.stat().st_size <= 8 * numbers + 20_000
    assert_same(many, Result.load(path))


def test_saving_replaces_an_older_file(bounce: Result, tmp_path: Path) -> None:
    path = tmp_path / "result.npz"
    path.write_bytes(b"old")
    bounce.save(path)
    assert Result.load(path).complete
    assert [p.name for p in tmp_path.iterdir()] == ["result.npz"]


@pytest.mark.parametrize("name", ["missing/result.npz", "file/result.npz", "folder"])
def test_unwritable_path(bounce: Result, tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ModelError, match=r"path: cannot write .*" + name):
        bounce.save(tmp_path / name)
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("path", [None, 3.5])
def test_what_is_no_path(bounce: Result, path: Any) -> None:
    with pytest.raises(ModelError, match="expected the name of a file"):
        bounce.save(path)
    with pytest.raises(ModelError, match="expected the name of a file"):
        Result.load(path)


def test_a_link_stays_a_link_and_a_device_a_device(bounce: Result, tmp_path: Path) -> None:
    target, link = tmp_path / "there.npz", tmp_path / "link.npz"
    link.symlink_to(target)
    assert_same(bounce, Result.load(bounce.save(link)))
    assert link.is_symlink()
    assert target.is_file()
    pipe = tmp_path / "pipe.npz"
    os.mkfifo(pipe)
    with pytest.raises(ModelError, match="no regular file"):
        bounce.save(pipe)
    assert pipe.is_fifo()


def test_full_disk_leaves_the_older_file_and_nothing_else(swing: Result, tmp_path: Path) -> None:
    """The system refuses to write beyond 4 kB, as a full disk would."""
    path = tmp_path / "result.npz"
    path.write_bytes(b"old")
    with full_disk(4096), pytest.raises(ModelError, match="cannot write"):
        swing.save(path)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["result.npz"]


def test_unreadable_files(bounce: Result, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"cannot read .*nowhere"):
        Result.load(tmp_path / "nowhere.npz")
    path = tmp_path / "result.npz"
    path.write_bytes(b"this is text")
    with pytest.raises(ModelError, match="no complete result"):
        Result.load(path)
    whole = bounce.save(path).read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ModelError, match="no complete result"):
        Result.load(path)
    np.savez(path, times=np.zeros(3))
    with pytest.raises(ModelError, match="no such entry"):
        Result.load(path)


@pytest.mark.parametrize("name", ["os.system", "result.np", "builtins.eval", "result.Result.load"])
def test_file_cannot_name_anything_but_values(bounce: Result, tmp_path: Path, name: str) -> None:
    path = bounce.save(tmp_path / "result.npz")
    with np.load(path) as file:
        entries = {key: file[key] for key in file.files}
    entries["structure"] = np.array(json.dumps({"value": name, "fields": {}}))
    np.savez(path, **entries)
    with pytest.raises(ModelError, match="no complete result"):
        Result.load(path)


def test_entries_are_plain_npy(swing: Result, tmp_path: Path) -> None:
    with zipfile.ZipFile(swing.save(tmp_path / "swing.npz")) as file:
        assert all(name.endswith(".npy") for name in file.namelist())


def test_a_file_of_the_first_format_is_read() -> None:
    """Its classes were named by modules that are elsewhere now. A disc of 2 kg lands after 1 cm, and slides."""
    found = Result.load(Path(__file__).parent / "result_of_first_format.npz")
    assert found.contact_points.area.tolist() == [0.0] * len(found.contact_points.record) != []
    impact = found.events[0]
    assert (impact.kind, impact.contact) == ("impact", "floor")
    assert impact.time == pytest.approx(np.sqrt(2.0 * 0.01 / 10.0), abs=1e-12)
    assert found.contact("floor").force[4] == pytest.approx([20.0, -0.3 * 20.0], abs=1e-9)
    assert found.contact_points.place == pytest.approx(found.point("disc", "center")[4:] - [0.0, 0.1], abs=1e-9)
    assert found.compiled.model.contacts.friction == pytest.approx([0.3])
    found.draw(0.06)


def test_joints_and_loads_of_the_first_format_hold_as_they_held() -> None:
    """One joint of each kind: the stored motion does not violate them, and the spring has the energy it had."""
    found = Result.load(Path(__file__).parent / "result_of_first_format.npz")
    model = found.compiled.model
    residual = np.zeros(model.joints.row[-1])
    joint_residual(model, found.times[-1], found.q[-1], np.zeros((0, 3)), residual)
    assert np.abs(residual).max() < 1e-9
    weight = 10.0 * found.q[:, 1::3] @ model.bodies.mass
    springs = [spring_energy(model, q) for q in found.q]
    assert springs == pytest.approx(found.energies.potential - weight, abs=1e-9)


@njit
def _push(t: float) -> float:
    return 3.0 * t


@pytest.mark.parametrize("lost", ["compiled function", "Python function", "force law"])
def test_mechanics_of_a_scene_whose_functions_no_file_keeps_are_refused(lost: str, tmp_path: Path) -> None:
    """The address of a compiled function is that of nothing in another process; a force that is left out is 0."""
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", position=(0.0, 0.2))
    force = {"compiled function": _push, "Python function": lambda t: 3.0 * t, "force law": 0.0}[lost]
    scene.load(lf.Force(disc.point("center"), (0.0, force)))
    law = lf.Penalty(1e5) if lost == "force law" else None
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor", law=law)
    result = lf.simulate(scene, 2e-3, lf.MoreauJean(step=1e-3), progress=False)
    result.compiled.at(t=0.1)
    loaded = Result.load(result.save(tmp_path / "result.npz"))
    again = Result.load(loaded.save(tmp_path / "again.npz"))
    for found in (loaded, again):
        kept = "no force laws" if lost == "force law" else "no Python functions of time"
        with pytest.raises(ModelError, match=f"result from a file, which keeps {kept}"):
            found.compiled.at(t=0.1)
        np.testing.assert_array_equal(found.point("disc", "center"), result.point("disc", "center"))


def test_stated_errors_of_older_files_are_left_out(bounce: Result, tmp_path: Path) -> None:
    """Files of results that stated the error of their steps are read, and where it went is told."""
    path = bounce.save(tmp_path / "old.npz")
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    structure = json.loads(str(arrays["structure"]))
    structure["fields"] |= {"place_error": 0.25, "speed_error": None}
    np.savez(path, **arrays | {"structure": np.array(json.dumps(structure))})
    found = Result.load(path)
    assert_same(bounce, found)
    for old, new in (("place_error", "place"), ("speed_error", "speed")):
        with pytest.raises(AttributeError, match=rf"'{old}': .*result.verify\(\) .*result.error.{new}$"):
            getattr(found, old)
