"""Archives are compared with their size before anything is unpacked, and what the library writes it reads."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse

import lcpflex as lf
from lcpflex.basics import archives
from lcpflex.errors import ModelError
from lcpflex.results import archive
from lcpflex.runs import checkpoint
from lcpflex.solvers import Lcp, load_problems, save_problems
from lcpflex.solvers.benchmark.fclib import load_fclib

KILOBYTE, MEGABYTE = 2**10, 2**20
READERS: dict[str, Any] = {
    "results": lf.Result.load,
    "problems": load_problems,
    "matrices": lambda path: lf.matrices_from_files(path, path, np.zeros((2, 2))),
    "coordinates": lambda path: lf.matrices_from_files(_identity(path), _identity(path), path),
    "checkpoints": lf.resume,
}


@pytest.fixture
def little_free(monkeypatch: pytest.MonkeyPatch) -> None:
    """64 kB are much: files of tests stay small."""
    monkeypatch.setattr(archives, "FREE", 64 * KILOBYTE)


def _identity(path: Path) -> Path:
    target = path.with_name("identity.npy")
    np.save(target, np.eye(4))
    return target


def _header(shape: object, kind: str = "<f8", order: bool = False) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": order, "shape": shape})  # type: ignore[arg-type]
    return stream.getvalue()


def _zip(path: Path, entries: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as file:
        for name, data in entries.items():
            file.writestr(f"{name}.npy", data)
    return path


def _bomb(path: Path, method: int = zipfile.ZIP_DEFLATED, parts: int = 1) -> Path:
    """Zeros, 2 MB when unpacked, in so many entries."""
    n = MEGABYTE // 4 // parts
    return _zip(path, {f"M_{i}": _header((n,)) + bytes(8 * n) for i in range(parts)}, method)


@pytest.mark.usefixtures("little_free")
@pytest.mark.parametrize(
    ("reader", "method", "parts"),
    [
        *((reader, zipfile.ZIP_DEFLATED, 1) for reader in READERS),
        ("problems", zipfile.ZIP_BZIP2, 1),
        ("results", zipfile.ZIP_LZMA, 1),
        ("checkpoints", zipfile.ZIP_DEFLATED, 16),
    ],
)
def test_what_would_take_far_more_is_refused_with_its_numbers(
    tmp_path: Path, reader: str, method: int, parts: int
) -> None:
    path = _bomb(tmp_path / "bomb.npz", method, parts)
    factor = 2.1e6 / path.stat().st_size
    with pytest.raises(ModelError, match=r"would take 2\.1 MB when it is unpacked") as refused:
        READERS[reader](path)
    assert "bomb.npz" in str(refused.value)
    assert f"{path.stat().st_size / 1e6:.3g} MB" in str(refused.value)
    assert float(str(refused.value).split(" times as much")[0].split()[-1]) == pytest.approx(factor, rel=0.01)


def test_the_real_limit(tmp_path: Path) -> None:
    """1.2 GB of zeros, which the directory of the file tells without their being there."""
    path = _bomb(tmp_path / "bomb.npz", parts=1)
    data = bytearray(path.read_bytes())
    size = 2 * MEGABYTE + len(_header((MEGABYTE // 4,)))
    place = data.rindex(size.to_bytes(4, "little"))
    data[place : place + 4] = (1_200_000_000).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(ModelError, match=r"would take 1\.2 GB when it is unpacked"):
        load_problems(path)


HUGE = {
    "a huge shape": _header((10**12,)) + bytes(80),
    "huge in two": _header((2**40, 2**40)) + bytes(80),
    "one number too many": _header((11,)) + bytes(80),
    "a long text": _header((), "<U1000000000") + bytes(80),
    "complex": _header((10**9, 2), "<c16", True) + bytes(80),
    "negative": _header((-1, 5)) + bytes(80),
    "cut header": _header((10,))[:30],
    "another version": b"\x93NUMPY\x03\x00" + _header((10,))[8:] + bytes(80),
    "no numpy": b"hello" * 20,
    "nothing": b"",
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
@pytest.mark.parametrize("name", HUGE)
def test_headers_that_claim_more_than_is_there(tmp_path: Path, reader: str, method: int, name: str) -> None:
    with pytest.raises(ModelError, match=r"x\.npz"):
        READERS[reader](_zip(tmp_path / "x.npz", {"M_0": HUGE[name]}, method))


@pytest.mark.parametrize("name", HUGE)
def test_single_arrays(tmp_path: Path, name: str) -> None:
    (tmp_path / "x.npy").write_bytes(HUGE[name])
    for reader in ("matrices", "coordinates"):
        with pytest.raises(ModelError, match=r"x\.npy"):
            READERS[reader](tmp_path / "x.npy")


@pytest.mark.parametrize("cut", [1, 30, 200, -1])
def test_files_that_were_cut(tmp_path: Path, cut: int) -> None:
    path = save_problems(tmp_path / "x.npz", [Lcp(np.eye(3), [1.0, -1.0, 2.0])])
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(ModelError, match=r"x\.npz"):
        load_problems(path)


def test_sparse_matrices_of_a_shape_that_takes_memory(tmp_path: Path) -> None:
    path = tmp_path / "x.npz"
    scipy.sparse.save_npz(path, scipy.sparse.coo_matrix(([1.0], ([0], [0])), shape=(10**9, 10**9)))
    with pytest.raises(ModelError, match=r"x\.npz.*at most 10000000 rows"):
        READERS["matrices"](path)


@pytest.mark.usefixtures("little_free")
class TestOwnFiles:
    """Whatever the library writes can be read, also what compresses as well as a bomb."""

    def test_problems(self, tmp_path: Path) -> None:
        sparse = np.zeros((300, 300))
        sparse[0, 0] = 1.0
        problems = [Lcp(sparse, np.zeros(300)) for _ in range(3)]
        path = save_problems(tmp_path / "x.npz", problems)
        assert path.stat().st_size < 3 * sparse.nbytes / 150
        found = load_problems(path)
        assert all(np.array_equal(a.problem.M, sparse) for a in found)
        assert len(found) == 3
        with np.load(path) as plain:
            assert plain["M_2"][0, 0] == 1.0

    @pytest.mark.parametrize("ending", [".npz", ".h5"])
    def test_results_of_a_long_rest(self, tmp_path: Path, ending: str) -> None:
        scene = lf.Scene(gravity=(0.0, 0.0))
        for k in range(30):
            scene.add(lf.Disc(radius=0.1, mass=1.0), name=f"d{k}", position=(float(k), 0.0))
        result = lf.simulate(scene, 0.5, lf.MoreauJean(step=1e-3), progress=False)
        result.save(tmp_path / f"x{ending}")
        again = lf.Result.load(tmp_path / f"x{ending}")
        assert again.q.tobytes() == result.q.tobytes()

    def test_hdf5(self, tmp_path: Path) -> None:
        h5py = pytest.importorskip("h5py")
        for name, reader in (("x.h5", archive.read), ("x.hdf5", load_fclib)):
            with h5py.File(tmp_path / name, "w") as file:
                group = file.create_group("fclib_local")
                for k in range(4):
                    group.create_dataset(
                        f"p{k}", data=np.zeros(MEGABYTE // 4), compression="gzip", chunks=(MEGABYTE // 4,)
                    )
            with pytest.raises(ModelError, match=rf"{name}.*would take 8\.39 MB when it is unpacked"):
                reader(tmp_path / name)

    @pytest.mark.parametrize("written", [0, 1])
    def test_hdf5_of_which_little_or_nothing_is_stored(self, tmp_path: Path, written: int) -> None:
        """HDF5 fills what was never written, and would fill any amount: not beyond what any file may take."""
        h5py = pytest.importorskip("h5py")
        with h5py.File(tmp_path / "x.hdf5", "w") as file:
            claims = file.create_dataset("fclib_local/q", (10**12,), dtype=float, chunks=(10,))
            claims[:written] = 1.0
        words = rf"x\.hdf5.*fclib_local/q claims .*\(1000000000000,\), 8e\+03 GB, of which {8e-5 * written:.3g} MB"
        with pytest.raises(ModelError, match=words):
            load_fclib(tmp_path / "x.hdf5")


def test_checkpoints_are_read_as_before(tmp_path: Path) -> None:
    scene = lf.Scene()
    scene.add(lf.Disc(radius=0.1, mass=1.0), name="disc", position=(0.0, 0.5))
    lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), progress=False, checkpoint=tmp_path / "x.npz")
    assert checkpoint.read(tmp_path / "x.npz").arrays
