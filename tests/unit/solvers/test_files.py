"""Problems in files come back as they were; files that hold none are refused with what was expected."""

import json
import sys
from importlib.util import find_spec

import numpy as np
import pytest
import scipy.sparse

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.solvers import ContactProblem, Lcp
from lcpflex.solvers.benchmark.fclib import load_fclib
from lcpflex.solvers.benchmark.files import load_problems, load_text_lcp, save_problems
from lcpflex.solvers.contact.spatial import SpatialContactProblem

M = np.array([[2.0, 1.0], [1.0, 2.0]])
q = np.array([-1.0, 0.1])


def _delassus(rows, seed=0):
    J = np.random.default_rng(seed).normal(size=(rows, rows + 1))
    return J, J @ J.T


def _contact():
    J, G = _delassus(5)
    keys = (("foot", 1), "heel", ("toe", ("left", 2)))
    return ContactProblem(G, [-1.0, 0.5, -0.2, 0.3, -0.4], [0.3, 0.0, 0.7], keys=keys, factor=J)


class TestRecords:
    def test_problems_come_back_to_the_bit(self, tmp_path):
        J, G = _delassus(3)
        given = [Lcp(M, q), _contact(), Lcp(G, np.arange(3.0), J)]
        path = save_problems(tmp_path / "record", given, ["plain", "größer", "with a factor"])
        assert path == tmp_path / "record.npz"
        found = load_problems(path)
        assert [one.name for one in found] == ["plain", "größer", "with a factor"]
        plain, contact, factored = (one.problem for one in found)
        for was, now in ((given[0], plain), (given[2], factored)):
            assert isinstance(now, Lcp)
            np.testing.assert_array_equal(was.M, now.M)
            np.testing.assert_array_equal(was.q, now.q)
        np.testing.assert_array_equal(factored.factor, J)
        assert isinstance(contact, ContactProblem)
        assert contact.keys == given[1].keys
        for name in ("free", "friction", "factor"):
            np.testing.assert_array_equal(getattr(contact, name), getattr(given[1], name))
        np.testing.assert_array_equal(contact.dense(), given[1].dense())
        np.testing.assert_array_equal(contact.lcp().M, given[1].lcp().M)

    def test_the_matrix_of_a_contact_problem_is_that_of_its_lcp(self, tmp_path):
        """So that other programs read M_i and q_i and need know nothing of contact."""
        problem = _contact()
        with np.load(save_problems(tmp_path / "x.npz", [problem]), allow_pickle=False) as stored:
            np.testing.assert_array_equal(stored["M_0"], problem.lcp().M)
            np.testing.assert_array_equal(stored["q_0"], problem.lcp().q)
            np.testing.assert_array_equal(stored["A_0"], problem.dense())

    def test_problem_known_by_its_factor_only(self, tmp_path):
        J = scipy.sparse.csr_array(np.array([[1.0, 0.0, 0.5], [0.0, 2.0, 0.0]]))
        path = save_problems(tmp_path / "x", [ContactProblem(None, [-1.0, 1.0], [0.4], factor=J)])
        (found,) = load_problems(path)
        np.testing.assert_allclose(found.problem.dense(), J.toarray() @ J.toarray().T, rtol=1e-15)

    def test_matrix_and_vector_of_elsewhere_suffice(self, tmp_path):
        np.savez(tmp_path / "x.npz", M_0=M, q_0=q, M_1=np.zeros((0, 0)), q_1=np.zeros(0))
        first, empty = load_problems(tmp_path / "x.npz")
        np.testing.assert_array_equal(first.problem.M, M)
        assert (empty.problem.size, empty.name) == (0, "problem 1")

    def test_others_may_read_a_record_as_any_new_file(self, tmp_path):
        (tmp_path / "plain").touch()
        assert save_problems(tmp_path / "x", []).stat().st_mode == (tmp_path / "plain").stat().st_mode

    def test_no_problems_are_a_record_too(self, tmp_path):
        assert load_problems(save_problems(tmp_path / "x", [])) == []

    def test_a_failed_write_leaves_the_old_file_and_no_other(self, tmp_path, monkeypatch):
        path = save_problems(tmp_path / "x.npz", [Lcp(M, q)])

        def full(*_, **__):
            raise OSError("no space left on device")

        monkeypatch.setattr(np.lib.format, "write_array", full)
        with pytest.raises(ModelError, match="no space left"):
            save_problems(path, [Lcp(M, -q)])
        np.testing.assert_array_equal(load_problems(path)[0].problem.q, q)
        assert list(tmp_path.iterdir()) == [path]

    @pytest.mark.parametrize(
        ("problems", "names", "words"),
        [
            ([Lcp(M, q)], ["a", "b"], "names has 2 entries: expected 1"),
            ([3], None, "int: expected Lcp or ContactProblem"),
            ([ContactProblem(M, q, [0.1], keys=(object(),))], None, "keys is .*expected names of text"),
        ],
    )
    def test_what_cannot_be_stored_is_refused(self, tmp_path, problems, names, words):
        with pytest.raises(ModelError, match=words):
            save_problems(tmp_path / "x.npz", problems, names)
        assert not list(tmp_path.iterdir())

    def test_folder_that_does_not_exist(self, tmp_path):
        with pytest.raises(ModelError, match="path: cannot write"):
            save_problems(tmp_path / "none" / "x.npz", [Lcp(M, q)])


class TestDamagedRecords:
    @pytest.mark.parametrize(
        ("arrays", "words"),
        [
            ({"M_0": M}, "key q_0 is missing"),
            ({"q_0": q}, "key M_0 is missing"),
            ({"M_0": M, "q_0": np.ones(3)}, r"M_0, q_0: M has shape \(2, 2\)"),
            ({"M_0": M, "q_0": np.array([np.nan, 1.0])}, r"q\[0\] is nan"),
            ({"M_0": np.array([["a", "b"], ["c", "d"]]), "q_0": q}, "expected numbers"),
            ({"M_0": M, "q_0": q, "M_1": M}, "key q_1 is missing"),
            ({"A_0": M, "b_0": q}, "key mu_0 is missing"),
            ({"A_0": M, "b_0": q, "mu_0": np.array([-0.1])}, "A_0, b_0, mu_0"),
            ({"A_0": M, "b_0": q, "mu_0": np.array([0.1]), "keys_0": np.array("[1")}, "expected a JSON list"),
            ({"A_0": M, "b_0": q, "mu_0": np.array([0.1]), "keys_0": np.array("3")}, "expected a JSON list"),
            ({"A_0": M, "b_0": q, "mu_0": np.array([0.1]), "keys_0": np.array('[{"a": 1}]')}, "holds an object"),
            ({"A_0": M, "b_0": q, "mu_0": np.array([0.1]), "keys_0": np.array("[1, 2]")}, "keys"),
            ({"M_0": M, "q_0": q, "factor_0": np.eye(2)}, "factor"),
            ({"matrix": M}, "no key M_0 among"),
        ],
    )
    def test_the_key_is_named(self, tmp_path, arrays, words):
        path = tmp_path / "x.npz"
        np.savez(path, **arrays)
        with pytest.raises(ModelError, match=words) as refusal:
            load_problems(path)
        assert str(path) in str(refusal.value)

    def test_pickled_objects_are_never_loaded(self, tmp_path):
        path = tmp_path / "x.npz"
        np.savez(path, M_0=np.array([{"a": 1}], dtype=object), q_0=q)
        with pytest.raises(ModelError, match="cannot be read"):
            load_problems(path)

    @pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
    def test_truncated_file(self, tmp_path, share):
        whole = save_problems(tmp_path / "whole", [_contact()] * 3).read_bytes()
        path = tmp_path / "part.npz"
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(ModelError, match="part"):
            load_problems(path)

    def test_flipped_bytes_are_found(self, tmp_path):
        path = save_problems(tmp_path / "x", [_contact()])
        content = bytearray(path.read_bytes())
        content[60:90] = bytes(255 - byte for byte in content[60:90])
        path.write_bytes(content)
        with pytest.raises(ModelError, match="cannot be read"):
            load_problems(path)

    def test_other_files(self, tmp_path):
        (tmp_path / "text.npz").write_text("2 1 1 2")
        np.save(tmp_path / "single.npy", M)
        for name, words in (("text.npz", "cannot be read"), ("single.npy", "single array"), ("none.npz", "No such")):
            with pytest.raises(ModelError, match=words):
                load_problems(tmp_path / name)


class TestText:
    @pytest.mark.parametrize(
        "text",
        [
            "2\n2 1\n1 2\n-1 0.1\n",
            "2 2 1 1 2 -1 0.1",
            "# two unknowns\n2\n\n2. 1.e0  # row\n1 2\n\t-1\n0.1",
            "2 1 -1\n1 2 0.1\n",
            "# M | q\n2 1 -1 # first\n\n1 2 0.1",
        ],
    )
    def test_both_forms(self, tmp_path, text):
        (tmp_path / "x.dat").write_text(text)
        problem = load_text_lcp(tmp_path / "x.dat")
        np.testing.assert_array_equal(problem.M, M)
        np.testing.assert_array_equal(problem.q, q)

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("", "0 numbers"),
            ("2 1 2", "3 numbers in 1 rows"),
            ("2\n2 1\n1 2\n-1 0.1 7", "8 numbers"),
            ("1.5 2 3", "expected n, M"),
            ("-1 2 3", "expected n, M"),
            ("2\n2 one\n1 2\n-1 0.1", "line 2: .*one"),
            ("1\n2\nnan", r"q\[0\] is nan"),
        ],
    )
    def test_anything_else_is_refused(self, tmp_path, text, words):
        (tmp_path / "x.dat").write_text(text)
        with pytest.raises(ModelError, match=words) as refusal:
            load_text_lcp(tmp_path / "x.dat")
        assert "x.dat" in str(refusal.value)

    def test_the_form_of_siconos_is_column_by_column(self, tmp_path):
        (tmp_path / "x.dat").write_text("2\n0\n2\n2\n2\t2\n4 -1\n3 5 \n-1 -2\n\nRemark 4.1.14\nof 2009\n")
        problem = load_text_lcp(tmp_path / "x.dat")
        np.testing.assert_array_equal(problem.M, [[4.0, 3.0], [-1.0, 5.0]])
        np.testing.assert_array_equal(problem.q, [-1.0, -2.0])

    def test_the_forms_are_told_apart(self, tmp_path):
        """A plain file may begin as Siconos' do."""
        (tmp_path / "x.dat").write_text("2\n0 2\n2 2\n2 7\n")
        problem = load_text_lcp(tmp_path / "x.dat")
        np.testing.assert_array_equal(problem.M, [[0.0, 2.0], [2.0, 2.0]])
        np.testing.assert_array_equal(problem.q, [2.0, 7.0])

    @pytest.mark.parametrize("text", ["2\n1\n2\n2\n1\n1\n1\n2\n2\n", "2\n0\n2\n2\n2 2\n1 1\n1 1\n-1"])
    def test_other_storages_and_cut_files_of_siconos(self, tmp_path, text):
        (tmp_path / "x.dat").write_text(text)
        with pytest.raises(ModelError, match="dense storage of Siconos"):
            load_text_lcp(tmp_path / "x.dat")

    def test_words_among_the_numbers_of_siconos(self, tmp_path):
        (tmp_path / "x.dat").write_text("2\n0\n2\n2\n2 2\n1 1\n1 one\n-1 -1\n")
        with pytest.raises(ModelError, match=r"one.*expected 4 numbers of M and 2 of q"):
            load_text_lcp(tmp_path / "x.dat")

    def test_binary_and_missing_files(self, tmp_path):
        (tmp_path / "x.dat").write_bytes(b"\xff\xfe\x00\x80")
        for name in ("x.dat", "none.dat"):
            with pytest.raises(ModelError, match="expected a text file"):
                load_text_lcp(tmp_path / name)


@pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")
class TestFclib:
    """Files written here in the layout FCLIB documents, /fclib_local with W as CSparse stores it."""

    W2 = np.array([[2.0, 0.1, 0.3, 0.0], [0.1, 1.5, 0.0, 0.2], [0.3, 0.0, 1.8, 0.4], [0.0, 0.2, 0.4, 1.1]])
    q2 = np.array([-1.0, 0.3, -0.5, 0.2])

    def _write(self, path, W, q, mu, dimension, form="triplets", leave_out=(), **change):
        kinds = {"triplets": scipy.sparse.coo_array, "columns": scipy.sparse.csc_array, "rows": scipy.sparse.csr_array}
        stored = kinds[form](W)
        if form == "triplets":
            p, i, nz = stored.coords[1], stored.coords[0], stored.nnz
        else:
            p, i, nz = stored.indptr, stored.indices, {"columns": -1, "rows": -2}[form]
        values = {"W/m": W.shape[0], "W/n": W.shape[1], "W/nzmax": stored.nnz, "W/nz": nz, "W/p": p, "W/i": i}
        values |= {"W/x": stored.data, "vectors/q": q, "vectors/mu": mu, "spacedim": np.array([dimension])} | change
        with libs.h5py.File(path, "w") as file:
            for key, value in values.items():
                if key not in leave_out:
                    file[f"fclib_local/{key}"] = value
        return path

    @pytest.mark.parametrize("form", ["triplets", "columns", "rows"])
    def test_planar_problem(self, tmp_path, form):
        path = self._write(tmp_path / "x.hdf5", self.W2, self.q2, np.array([0.3, 0.5]), 2, form)
        problem = load_fclib(path)
        assert isinstance(problem, ContactProblem)
        order = [0, 2, 1, 3]  # normals first
        np.testing.assert_array_equal(problem.dense(), self.W2[np.ix_(order, order)])
        np.testing.assert_array_equal(problem.free, self.q2[order])
        np.testing.assert_array_equal(problem.friction, [0.3, 0.5])

    def test_the_form_tells_rows_from_columns(self, tmp_path):
        W, q, mu = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3), np.ones(1)
        for form in ("triplets", "columns", "rows"):
            problem = load_fclib(self._write(tmp_path / f"{form}.hdf5", W, q, mu, 3, form))
            np.testing.assert_array_equal(problem.delassus, W)

    def test_tangents_without_friction_are_left_out(self, tmp_path):
        path = self._write(tmp_path / "x.hdf5", self.W2, self.q2, np.array([0.0, 0.5]), 2)
        problem = load_fclib(path)
        np.testing.assert_array_equal(problem.free, self.q2[[0, 2, 3]])
        np.testing.assert_array_equal(problem.dense(), self.W2[np.ix_([0, 2, 3], [0, 2, 3])])

    def test_spatial_problem_keeps_its_rows(self, tmp_path):
        W = np.diag([2.0, 1.0, 1.0])
        problem = load_fclib(self._write(tmp_path / "x.hdf5", W, np.array([-1.0, 0.4, 0.0]), np.array([0.3]), 3))
        assert isinstance(problem, SpatialContactProblem)
        np.testing.assert_array_equal(problem.delassus, W)
        # Pressed by 0.5, it slides: friction of 0.3 * 0.5 acts against the speed left, 0.4 - 0.15.
        assert problem.residual([0.5, -0.15, 0.0]) < 1e-15
        assert problem.residual([0.5, 0.15, 0.0]) > 0.1
        assert problem.residual([0.5, 0.0, 0.0]) > 0.1
        assert problem.residual([0.6, -0.18, 0.0]) > 0.05

    def test_spatial_sticking_and_separating(self):
        sticking = SpatialContactProblem(np.diag([2.0, 1.0, 1.0]), [-1.0, 0.1, 0.05], [0.3])
        assert sticking.residual([0.5, -0.1, -0.05]) < 1e-15
        parting = SpatialContactProblem(np.diag([2.0, 1.0, 1.0]), [1.0, 0.1, 0.05], [0.3])
        assert parting.residual([0.0, 0.0, 0.0]) == 0.0
        assert parting.residual([0.1, 0.0, 0.0]) > 0.1

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"leave_out": ("W/x",)}, "expected /fclib_local with W"),
            ({"leave_out": ("vectors/mu",)}, "expected /fclib_local with W"),
            ({"leave_out": ("spacedim",)}, "expected /fclib_local with W"),
            ({"vectors/q": np.ones(3)}, "expected 2 or 3 rows"),
            ({"spacedim": np.array([4])}, "expected 2 or 3 rows"),
            ({"W/nz": -3}, "W/nz is -3"),
            ({"W/i": np.array([99] * 12)}, "x.hdf5"),
            ({"vectors/q": np.array([np.nan, 0.0, 0.0, 0.0])}, "nan"),
        ],
    )
    def test_damaged_files(self, tmp_path, change, words):
        path = self._write(tmp_path / "x.hdf5", self.W2, self.q2, np.array([0.3, 0.5]), 2, **change)
        with pytest.raises(ModelError, match=words) as refusal:
            load_fclib(path)
        assert "x.hdf5" in str(refusal.value)

    def test_a_solution_that_was_never_written(self, tmp_path):
        """As in most files of the collection: the data set is there, without storage; HDF5 reads its fill value."""
        W, q, mu = scipy.sparse.block_diag([np.diag([2.0, 1.0, 1.0])] * 200), np.zeros(600), np.ones(200)
        path = self._write(tmp_path / "x.hdf5", W, q, mu, 3, "columns")
        before = load_fclib(path)
        with libs.h5py.File(path, "a") as file:
            for key in ("solution/r", "solution/u", "guesses/1/v"):
                file.create_dataset(f"fclib_local/{key}", (600,), dtype=float)
                assert file[f"fclib_local/{key}"].id.get_storage_size() == 0
            del file["fclib_local/vectors/q"]
            file.create_dataset("fclib_local/vectors/q", (600,), dtype=float, fillvalue=-1.5)
        problem = load_fclib(path)
        np.testing.assert_array_equal(problem.dense(), before.dense())
        np.testing.assert_array_equal(problem.free, np.full(600, -1.5))

    def test_other_files(self, tmp_path):
        with libs.h5py.File(tmp_path / "global.hdf5", "w") as file:
            file["fclib_global/spacedim"] = 2
        with libs.h5py.File(tmp_path / "empty.hdf5", "w"):
            pass
        (tmp_path / "text.hdf5").write_text("none")
        for name, words in (
            ("global", "expected /fclib_global with M"),
            ("empty", "no problem"),
            ("text", "expected"),
            ("no", "No"),
        ):
            with pytest.raises(ModelError, match=words):
                load_fclib(tmp_path / f"{name}.hdf5")

    def test_without_h5py_the_way_to_it_is_told(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "h5py", None)
        monkeypatch.delitem(vars(libs), "h5py", raising=False)  # where another test has loaded it
        with pytest.raises(ModelError, match=r"pip install 'lcpflex\[hdf5\]'"):
            load_fclib(tmp_path / "x.hdf5")


def test_keys_are_json(tmp_path):
    with np.load(save_problems(tmp_path / "x", [_contact()])) as stored:
        assert json.loads(str(stored["keys_0"])) == [["foot", 1], "heel", ["toe", ["left", 2]]]
