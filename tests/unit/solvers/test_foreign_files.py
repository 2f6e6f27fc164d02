"""Files of Siconos and FCLIB: every form is read, nothing else is, and what is written is read back."""

from importlib.util import find_spec

import numpy as np
import pytest
import scipy.sparse

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp, Lemke, MixedLcp, solve_lcp
from lcpflex.solvers.benchmark.siconos_files import (
    load_siconos,
    load_siconos_contacts,
    load_siconos_lcp,
    load_siconos_mlcp,
)
from lcpflex.solvers.contact.condensation import condensed, condensed_sparse, planar_rows
from lcpflex.solvers.contact.spatial import SpatialContactProblem

RNG = np.random.default_rng(5)
A6 = RNG.normal(size=(6, 6))
W6 = A6 @ A6.T + np.eye(6)
W6[0:2, 4:6] = W6[4:6, 0:2] = 0.0  # an empty block
Q6 = RNG.normal(size=6)
MU2, MU3 = np.array([0.3, 0.5]), np.array([0.3, 0.5, 0.7])


def _words(values):
    return " ".join(f"{x!r}" for x in np.asarray(values, dtype=float).tolist()) + "\n"


def dense(M):
    m, n = M.shape
    return f"0\n{m}\n{n}\n{m}\t{n}\n" + _words(M.T.ravel())


def blocks(M, size):
    m, n = (k // size for k in M.shape)
    ends = (
        " ".join(str(size * (k + 1)) for k in range(m)) + "\n",
        " ".join(str(size * (k + 1)) for k in range(n)) + "\n",
    )
    first, second, told = [0], [], ""
    for i in range(m):
        for j in range(n):
            block = M[size * i : size * (i + 1), size * j : size * (j + 1)]
            if block.any():
                told += f"{len(second)}\n" + _words(block.T.ravel())
                second.append(j)
        first.append(len(second))
    lists = " ".join(map(str, first)) + "\n" + " ".join(map(str, second)) + "\n"
    head = f"1\n{M.shape[0]}\n{M.shape[1]}\n{len(second)}\n{m}\n{n}\n{ends[0]}{ends[1]}{m + 1}\n{len(second)}\n"
    return head + lists + told


def sparse(M, kind):
    lines = [f"2\n{M.shape[0]}\n{M.shape[1]}\n1\nCSparse Version 3.1.9, May 4, 2016.  Copyright (c) somebody"]
    nnz = np.count_nonzero(M)
    prefix = "" if kind == "csc" else f"{kind}: "
    lines.append(f"{prefix}{M.shape[0]}-by-{M.shape[1]}, nzmax: {nnz} nnz: {nnz}, 1-norm: 3.5")
    if kind == "triplet":
        lines += [f"    {i} {j} : {float(M[i, j])!r}" for i, j in zip(*np.nonzero(M), strict=True)]
    else:
        T = M.T if kind == "csc" else M
        for j, line in enumerate(T):
            lines.append(f"    col {j} : locations 0 to 1")
            lines += [f"      {i} : {float(line[i])!r}" for i in np.flatnonzero(line)]
    return "\n".join(lines) + "\n"


FORMS = {
    "dense": dense,
    "blocks of 1": lambda M: blocks(M, 1),
    "blocks of 2": lambda M: blocks(M, 2),
    "columns": lambda M: sparse(M, "csc"),
    "rows": lambda M: sparse(M, "csr"),
    "triplets": lambda M: sparse(M, "triplet"),
}


def _file(folder, text, name="x.dat"):
    (folder / name).write_text(text)
    return folder / name


@pytest.mark.parametrize("form", FORMS)
class TestForms:
    def test_lcp(self, tmp_path, form):
        problem = load_siconos_lcp(_file(tmp_path, "6\n" + FORMS[form](W6) + _words(Q6) + "\nRemark of 2009\n"))
        assert np.array_equal(problem.M, W6)
        assert np.array_equal(problem.q, Q6)

    def test_plane(self, tmp_path, form):
        W, q = W6[:4, :4], Q6[:4]
        found = load_siconos_contacts(_file(tmp_path, "2\n2\n" + FORMS[form](W) + _words(q) + _words(MU2)))
        assert isinstance(found, ContactProblem)
        order = [0, 2, 1, 3]
        assert np.array_equal(found.dense(), W[np.ix_(order, order)])
        assert np.array_equal(found.free, q[order])
        assert solve_lcp(found).solved

    def test_space(self, tmp_path, form):
        found = load_siconos_contacts(_file(tmp_path, "3\n2\n" + FORMS[form](W6) + _words(Q6) + _words(MU2) + "1\n"))
        assert isinstance(found, SpatialContactProblem)
        assert np.array_equal(found.delassus, W6)
        assert np.array_equal(found.free, Q6)
        assert np.array_equal(found.friction, MU2)

    def test_bodies_are_eliminated(self, tmp_path, form):
        M, H = np.diag([1.0, 2.0, 3.0, 1.0, 2.0, 3.0]), np.eye(6)[:, :4] * 2.0
        f, b = np.arange(6.0), np.arange(4.0)
        text = "2\n2\n" + FORMS[form](M) + FORMS[form](H) + _words(f) + _words(b) + _words(MU2)
        found = load_siconos_contacts(_file(tmp_path, text))
        order = [0, 2, 1, 3]
        assert found.dense() == pytest.approx((H.T @ np.linalg.inv(M) @ H)[np.ix_(order, order)], abs=1e-14)
        assert found.free == pytest.approx((H.T @ (f / np.diag(M)) + b)[order], abs=1e-14)

    def test_mixed(self, tmp_path, form):
        head = "1\n0\n2\n4\n0 2 6\n0 1\n"
        found = load_siconos_mlcp(_file(tmp_path, head + FORMS[form](W6) + _words(Q6)))
        assert np.array_equal(found.M, W6)
        assert found.free.tolist() == [True] * 2 + [False] * 4
        A, C, D, B = W6[:2, :2], W6[:2, 2:], W6[2:, :2], W6[2:, 2:]
        parts = "".join(_words(part.ravel()) for part in (A, B, C, D))
        other = load_siconos_mlcp(_file(tmp_path, "0\n1\n2\n4\n" + parts + _words(Q6)))
        assert np.array_equal(other.M, W6)
        assert np.array_equal(other.q, Q6)
        assert solve_lcp(other).z == pytest.approx(solve_lcp(found).z, abs=1e-12)

    def test_the_kind_is_found(self, tmp_path, form):
        matrix = FORMS[form](W6)
        for text, kind in (
            ("6\n" + matrix + _words(Q6), Lcp),
            ("3\n2\n" + matrix + _words(Q6) + _words(MU2), SpatialContactProblem),
            ("1\n0\n2\n4\n0 2 6\n0 1\n" + matrix + _words(Q6), MixedLcp),
        ):
            assert type(load_siconos(_file(tmp_path, text))) is kind
        with pytest.raises(ModelError, match=r"as LCP, .*; as contacts, .*; as mixed LCP, "):
            load_siconos(_file(tmp_path, "6\n" + matrix))

    def test_every_cut_is_told(self, tmp_path, form):
        text = "2\n2\n" + FORMS[form](W6[:4, :4]) + _words(Q6[:4]) + _words(MU2)
        words = text.split()
        for count in range(0, len(words) - 1, 3):
            cut = text[: sum(len(w) + 1 for w in words[:count])]
            with pytest.raises(ModelError, match=r"x\.dat.: line \d+: .*expected") as refusal:
                load_siconos_contacts(_file(tmp_path, cut.rsplit(maxsplit=1)[0] if cut.strip() else ""))
            assert len(str(refusal.value)) < 500

    def test_every_damaged_word_is_told_or_read(self, tmp_path, form):
        rng = np.random.default_rng(1)
        text = "3\n2\n" + FORMS[form](W6) + _words(Q6) + _words(MU2)
        words, told = text.splitlines(), []
        for _ in range(60):
            lines = list(words)
            k = int(rng.integers(len(lines)))
            lines[k] = str(rng.choice(["", "nan", "-1", "1e400", "999999999999", "7", "x", "1 2 3 4 5", "é"]))
            try:
                load_siconos_contacts(_file(tmp_path, "\n".join(lines)))
            except ModelError as error:
                told.append(str(error))
        assert told
        assert all("expected" in text and len(text) < 500 for text in told)


class TestRefused:
    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("", "line 0: the file ends"),
            ("4\n2\n", r"line 1: found '4'; expected the dimension, 2 or 3"),
            ("1\n2\n", "line 1: the dimension is 1"),
            ("3\n9999999\n", "line 2: found '9999999'.* 0 to 1000000"),
            ("2\n9000\n0\n18000\n18000\n", "line 5: W or M is 18000 x 18000; expected at most 8000"),
            ("3\n1\n3\n", "line 3: found '3'; expected the storage"),
            ("3\n1\n0\n3\n3\n3 4\n", "line 6: W or M is 3 x 4|line 6: .*3 x 3 as before"),
            ("3\n1\n0\n3\n3\n3 3\n1 2 x", "line 7: found 'x'; expected entries of"),
        ],
    )
    def test_the_line_is_named(self, tmp_path, text, words):
        with pytest.raises(ModelError, match=words):
            load_siconos_contacts(_file(tmp_path, text))

    def test_rectangular_mixed_problems(self, tmp_path):
        text = "1\n1\n1\n1\n0 1 2\n0 1\n" + dense(np.ones((3, 2))) + _words(np.ones(3))
        with pytest.raises(ModelError, match="M is 3 x 2; expected 2 x 2, as many equations as unknowns"):
            load_siconos_mlcp(_file(tmp_path, text))

    def test_files_that_are_none(self, tmp_path):
        (tmp_path / "x.dat").write_bytes(b"\xff\xfe\x00\x80")
        for name in ("x.dat", "none.dat", "."):
            for load in (load_siconos_contacts, load_siconos_lcp, load_siconos_mlcp):
                with pytest.raises(ModelError, match="expected a text file"):
                    load(tmp_path / name)

    def test_singular_bodies(self, tmp_path):
        text = "2\n1\n" + dense(np.diag([1.0, 0.0, 1.0])) + dense(np.eye(3)[:, :2]) + _words(np.ones(6))
        with pytest.raises(ModelError, match="singular: expected bodies whose motion"):
            load_siconos_contacts(_file(tmp_path, text))


def test_joints_are_eliminated_too():
    """Two masses on a rod that one may push: together they are one mass."""
    M, H, G = np.diag([2.0, 3.0]), np.array([[1.0], [0.0]]), np.array([[1.0], [-1.0]])
    W, q = condensed(M, H, np.array([2.0, 3.0]), np.array([0.5]), G, np.array([0.0]))
    assert pytest.approx(np.array([[0.2]]), abs=1e-15) == W
    assert q == pytest.approx([1.5], abs=1e-15)


class TestManyBodies:
    """Bodies of which there are too many for a dense matrix: the same as with one."""

    @pytest.mark.parametrize("asymmetry", [0.0, 0.1])
    def test_the_same_as_dense(self, asymmetry):
        rng = np.random.default_rng(1)
        root = scipy.sparse.random_array((90, 90), density=0.03, rng=rng) + scipy.sparse.eye_array(90)
        unit = scipy.sparse.diags_array(10.0 ** rng.integers(-3, 4, 90))
        skew = asymmetry * scipy.sparse.random_array((90, 90), density=0.03, rng=rng)
        M = unit @ (root @ root.T + skew) @ unit
        H = unit @ scipy.sparse.random_array((90, 70), density=0.05, rng=rng)
        f, w = unit @ rng.standard_normal(90), rng.standard_normal(70)
        W, q = condensed_sparse(M, H, f, w)
        expected, load = condensed(M.toarray(), H.toarray(), f, w)
        assert W.toarray() == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
        assert q == pytest.approx(load, abs=1e-12 * np.abs(load).max())
        assert (abs(W - W.T).max() == 0.0) == (asymmetry == 0.0)

    @pytest.mark.parametrize("apart", [0.0, 1e-16, 1e-15])
    def test_singular_bodies(self, apart):
        """Two that move together but for the last digits."""
        M = scipy.sparse.csc_array([[1.0, 1.0 - apart, 0.0], [1.0 - apart, 1.0, 0.0], [0.0, 0.0, 1e-30]])
        with pytest.raises(ModelError, match="singular: expected bodies whose motion"):
            condensed_sparse(M, scipy.sparse.eye_array(3), np.ones(3), np.zeros(3))


@pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")
class TestFclib:
    def test_what_is_written_is_read_back(self, tmp_path):
        from lcpflex.solvers import load_fclib, save_fclib

        order = [0, 2, 4, 1, 5]
        some = ContactProblem(W6[np.ix_(order, order)], Q6[order], [0.3, 0.0, 0.5])
        for problem in (some, ContactProblem(1e-300 * W6, Q6, MU3), ContactProblem(W6[:3, :3], Q6[:3], np.zeros(3))):
            found = load_fclib(save_fclib(tmp_path / "x.hdf5", problem))
            assert np.array_equal(found.dense(), problem.dense())
            assert np.array_equal(found.free, problem.free)
            assert np.array_equal(found.friction, problem.friction)
        space = SpatialContactProblem(W6, Q6, MU2)
        found = load_fclib(save_fclib(tmp_path / "y.hdf5", space))
        assert np.array_equal(found.delassus, W6)
        assert np.array_equal(found.free, Q6)

    def test_spatial_problems_however_they_are_kept(self, tmp_path):
        """Sparse, by a factor, unsymmetric: read back it is the same operator, sparse beyond 200 rows."""
        from lcpflex.solvers import load_fclib, save_fclib

        k = 80
        J = scipy.sparse.random_array((3 * k, 40), density=0.05, rng=np.random.default_rng(1), format="csr")
        free, mu = np.linspace(-1.0, 1.0, 3 * k), np.linspace(0.0, 1.0, k)
        twisted = scipy.sparse.csr_array(J @ J.T + scipy.sparse.eye_array(3 * k, k=1))
        for problem in (
            SpatialContactProblem(J @ J.T, free, mu),
            SpatialContactProblem(None, free, mu, factor=J),
            SpatialContactProblem(twisted, free, mu),
            SpatialContactProblem((J @ J.T).toarray()[:9, :9], free[:9], mu[:3]),
        ):
            found = load_fclib(save_fclib(tmp_path / "x.hdf5", problem))
            assert scipy.sparse.issparse(found.delassus) == (problem.size > 200)
            np.testing.assert_array_equal(found.dense(), problem.dense())
            np.testing.assert_array_equal(found.free, problem.free)
            np.testing.assert_array_equal(found.friction, problem.friction)

    def _global(self, path, joints=True, **change):
        M, H, G = np.diag([2.0, 3.0, 1.0]), np.eye(3)[:, :2], np.array([[1.0], [-1.0], [0.0]])
        arrays = {"M": M, "H": H, **({"G": G} if joints else {})} | {k: v for k, v in change.items() if k in "MHG"}
        vectors = {"f": np.array([2.0, 3.0, 1.0]), "w": np.array([0.5, -0.1]), "mu": np.array([0.4]), "b": np.zeros(1)}
        vectors |= {k: v for k, v in change.items() if k in vectors}
        with libs.h5py.File(path, "w") as file:
            group = file.create_group("fclib_global")
            group["spacedim"] = np.array([change.get("spacedim", 2)])
            for name, A in arrays.items():
                rows, columns = np.nonzero(A)
                values = {
                    "m": A.shape[0],
                    "n": A.shape[1],
                    "nz": len(rows),
                    "p": columns,
                    "i": rows,
                    "x": A[rows, columns],
                }
                for key, value in values.items():
                    group[f"{name}/{key}"] = value
            for name, value in vectors.items():
                group[f"vectors/{name}"] = value
        return path

    def test_global_problems_lose_their_bodies(self, tmp_path):
        from lcpflex.solvers import load_fclib

        found = load_fclib(self._global(tmp_path / "x.hdf5"))
        assert found.dense() == pytest.approx(np.full((2, 2), 0.2), abs=1e-15)  # one mass of 5
        assert found.free == pytest.approx([1.5, 0.9], abs=1e-15)
        found = load_fclib(self._global(tmp_path / "x.hdf5", joints=False))
        assert found.dense() == pytest.approx(np.diag([0.5, 1 / 3]), abs=1e-15)
        assert Lemke().solve(found).solved

    def test_many_bodies_are_eliminated_by_sparse_factors(self, tmp_path, monkeypatch):
        """Where there are too many for a dense matrix: the same problem; with joints it is refused."""
        from lcpflex.solvers import load_fclib
        from lcpflex.solvers.benchmark import fclib

        path = self._global(tmp_path / "x.hdf5", joints=False, M=np.array([[2.0, 0.3, 0], [0.3, 3.0, 0], [0, 0, 1.0]]))
        dense = load_fclib(path)
        monkeypatch.setattr(fclib, "LARGEST", 2)
        found = load_fclib(path)
        np.testing.assert_allclose(found.dense(), dense.dense(), rtol=1e-15)
        np.testing.assert_allclose(found.free, dense.free, rtol=1e-15)
        assert found.dense()[0, 1] < -0.05
        with pytest.raises(ModelError, match="M is singular"):
            load_fclib(self._global(tmp_path / "z.hdf5", joints=False, M=np.ones((3, 3))))
        with pytest.raises(ModelError, match="M has 3 rows and 3 columns: expected at most 2, as it becomes dense"):
            load_fclib(self._global(tmp_path / "y.hdf5"))

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"M": np.ones((3, 3))}, "singular"),
            ({"M": np.ones((3, 2))}, r"M has shape \(3, 2\)"),
            ({"H": np.ones((2, 2))}, "H"),
            ({"f": np.ones(2)}, r"f \(2,\)"),
            ({"f": np.array([1.0, np.nan, 0.0])}, "f holds NaN"),
            ({"mu": np.ones(3)}, "2 or 3 rows"),
            ({"spacedim": 5}, "spacedim is 5"),
            ({"b": np.ones(2)}, "b"),
        ],
    )
    def test_damaged_global_problems(self, tmp_path, change, words):
        from lcpflex.solvers import load_fclib

        with pytest.raises(ModelError, match=words) as refusal:
            load_fclib(self._global(tmp_path / "x.hdf5", **change))
        assert "x.hdf5" in str(refusal.value)
        assert len(str(refusal.value)) < 500

    def test_what_cannot_be_written(self, tmp_path):
        from lcpflex.solvers import Lcp, save_fclib

        with pytest.raises(ModelError, match="problem is a Lcp"):
            save_fclib(tmp_path / "x.hdf5", Lcp(np.eye(2), [1.0, 1.0]))
        with pytest.raises(ModelError, match="cannot write"):
            save_fclib(tmp_path / "none" / "x.hdf5", ContactProblem([[1.0]], [1.0], [0.0]))
        assert not list(tmp_path.iterdir())

    def test_rows_of_a_planar_problem(self):
        W, q = planar_rows(
            ContactProblem([[2.0, 0.1, 0.3], [0.1, 3.0, 0.2], [0.3, 0.2, 4.0]], [1.0, 2.0, 3.0], [0.0, 0.5])
        )
        W = W.toarray()
        assert W[1].tolist() == [0.0] * 4
        assert q.tolist() == [1.0, 0.0, 2.0, 3.0]
        assert W[2, 3] == 0.2
