"""Contact problems with sparse matrices: the same as with dense ones, which are not formed beyond the stated size."""

import tracemalloc

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import Auto, BlockGaussSeidel, ContactProblem, Lcp, Lemke, load_problems, save_problems
from lcpflex.solvers.contact import matrices, problem as contact_problem
from lcpflex.solvers.contact.matrices import DENSE_LARGEST
from lcpflex.solvers.contact.relaxation import ConvexContactProblem
from tests.piles import columns, shuffled


def kinds(pile):
    """The same problem by a dense and a sparse Delassus matrix, and by its factor, sparse and dense."""
    J, free, mu = pile
    G = J @ J.T
    yield ContactProblem(G.toarray(), free, mu)
    yield ContactProblem(G, free, mu)
    yield ContactProblem(None, free, mu, factor=J)
    yield ContactProblem(None, free, mu, factor=J.toarray())


@pytest.fixture(params=[0.0, 0.5, "mixed"])
def pile(request):
    rng = np.random.default_rng(3)
    J, free, mu = columns(3, 4, friction=0.5)
    if request.param == "mixed":
        mu = np.where(rng.random(len(mu)) < 0.3, 0.0, rng.uniform(0.1, 1.5, len(mu)))
    elif request.param == 0.0:
        mu = np.zeros(len(mu))
    rows = np.concatenate([np.arange(len(mu)), len(mu) + np.flatnonzero(mu)])
    return J[rows], free[rows], mu


class TestTheSameAsDense:
    def test_data_and_forms(self, pile):
        dense, *others = kinds(pile)
        z = np.random.default_rng(0).random(dense.size)
        for problem in others:
            assert problem.dense() == pytest.approx(dense.dense(), abs=1e-14)
            assert problem.diagonal == pytest.approx(dense.diagonal, abs=1e-14)
            assert problem.units == pytest.approx(dense.units, rel=1e-14)
            assert problem.slack(z) == pytest.approx(dense.slack(z), abs=1e-13)
            for form in ("lcp", "copositive_lcp"):
                found, expected = getattr(problem, form)(), getattr(dense, form)()
                np.testing.assert_allclose(found.M, expected.M, atol=1e-14)
            assert problem.balanced().dense() == pytest.approx(dense.balanced().dense(), abs=1e-14)
            row = len(dense.friction) - 1
            assert [float(x) for x in problem.exact_system().row(row)] == pytest.approx(
                [float(x) for x in dense.exact_system().row(row)], abs=1e-14
            )

    def test_residuals_are_those_of_the_lcp(self, pile):
        rng = np.random.default_rng(1)
        for problem in kinds(pile):
            lcp = problem.lcp()
            for size in (0.0, 1e-3, 1.0, 1e6):
                z = size * rng.random(problem.size)
                assert problem.residuals(z) == pytest.approx(lcp.residuals(z), rel=1e-9)
                assert problem.residual(z, scaled=False) == pytest.approx(lcp.residual(z, scaled=False), rel=1e-9)

    def test_a_body_with_more_contacts_than_can_be_coupled(self, pile, monkeypatch):
        J, free, mu = pile
        known = ContactProblem(None, free, mu, factor=J)
        z = np.random.default_rng(1).random(known.size)
        expected = known.residuals(z)
        monkeypatch.setattr(contact_problem, "MOST_BLOCKS", 1)
        problem = ContactProblem(None, free, mu, factor=J)
        assert problem.coupling is None
        assert problem.residuals(z) == pytest.approx(expected, rel=1e-12)
        found = Auto().solve(problem)
        assert found.solved
        assert found.w[: len(mu)] == pytest.approx(Auto().solve(known).w[: len(mu)], abs=1e-9)

    def test_answers(self, pile):
        for solver in (Auto(), BlockGaussSeidel(), Lemke()):
            answers = [solver.solve(problem) for problem in kinds(pile)]
            assert all(found.solved for found in answers)
            dense, *others = kinds(pile)
            for found, problem in zip(answers[1:], others, strict=True):
                v = problem.velocity(np.concatenate(problem.forces(found.z)))
                assert v == pytest.approx(dense.velocity(np.concatenate(dense.forces(answers[0].z))), abs=1e-10)

    def test_unsymmetric_matrices(self):
        rng = np.random.default_rng(7)
        G = np.eye(6) + 0.1 * rng.standard_normal((6, 6))
        free, mu = rng.standard_normal(6), [0.3, 0.4, 0.2]
        dense, sparse = (ContactProblem(M, free, mu) for M in (G, scipy.sparse.csc_matrix(G)))
        z = rng.random(dense.size)
        assert sparse.residuals(z) == pytest.approx(dense.residuals(z), rel=1e-12)
        assert Auto().solve(sparse).z == pytest.approx(Auto().solve(dense).z, abs=1e-12)
        assert BlockGaussSeidel().solve(sparse).solved

    @pytest.mark.parametrize("asked", ["balanced first", "coupling first"])
    def test_the_balanced_problem_does_not_depend_on_what_was_asked_before(self, pile, asked):
        J, free, mu = pile
        for problem in kinds((1e3 * J, 1e3 * free, mu)):  # a thousandth of a gram: units far from one
            if asked == "coupling first":
                assert problem.coupling is not None
            alike = problem.balanced()
            z = np.random.default_rng(2).random(problem.size)
            assert alike.residuals(z) == pytest.approx(alike.lcp().residuals(z), rel=1e-9)
            assert alike.residuals(z) == pytest.approx(problem.residuals(problem.unknown_units.outward(z)), rel=1e-9)
            for solver in (Auto(), BlockGaussSeidel()):
                assert solver.solve(problem).solved
                found = solver.solve(alike)
                assert found.solved
                assert alike.lcp().residual(found.z) <= 1e-9

    def test_sweeps_over_an_lcp_of_any_size(self, monkeypatch):
        monkeypatch.setattr(matrices, "DENSE_LARGEST", 5)
        found = BlockGaussSeidel().solve(Lcp(np.eye(6) + 0.1, -np.ones(6)))
        assert found.solved
        assert found.z == pytest.approx(np.full(6, 1.0 / 1.6), rel=1e-9)


class TestArguments:
    @pytest.mark.parametrize("matrix", [np.eye(3), scipy.sparse.eye_array(3), "none", [[np.nan]]])
    def test_a_matrix_of_no_contacts(self, matrix):
        with pytest.raises(ModelError, match=r"delassus.*expected"):
            ContactProblem(matrix, [], [])
        for nothing in ([], [[]], np.zeros((0, 3)), scipy.sparse.csr_array((0, 0))):
            assert Auto().solve(ContactProblem(nothing, [], [])).solved

    @pytest.mark.parametrize(
        ("matrix", "words"),
        [
            (scipy.sparse.csr_array([[1.0, np.nan], [0.0, 1.0]]), r"delassus.data\[1\] is nan"),
            (scipy.sparse.csr_array([[1j, 0.0], [0.0, 1.0]]), "delassus is .*real numbers"),
            (scipy.sparse.csr_array(np.eye(3)), r"delassus has shape \(3, 3\)"),
            (scipy.sparse.csr_array(np.ones((2, 3))), r"delassus has shape \(2, 3\)"),
        ],
    )
    def test_matrices_that_are_refused(self, matrix, words):
        with pytest.raises(ModelError, match=words) as refusal:
            ContactProblem(matrix, [1.0, 1.0], [0.5])
        assert len(str(refusal.value)) < 500

    def test_formats_and_entries_given_twice(self):
        for kind in ("csr", "csc", "coo", "bsr", "lil", "dok", "dia"):
            matrix = scipy.sparse.coo_array(([1.0, 1.0, 3.0], ([0, 0, 1], [0, 0, 1]))).asformat(kind)
            assert ContactProblem(matrix, [1.0, 1.0], [0.5]).dense().tolist() == [[2.0, 0.0], [0.0, 3.0]]

    def test_arrays_are_copied_and_read_only(self):
        J, free, mu = columns(1, 2)
        given = (J @ J.T).tocsr()
        problem = ContactProblem(given, free, mu, factor=J)
        before = problem.dense().copy()
        given.data[:] = 0.0
        assert np.array_equal(problem.dense(), before)
        for array in (problem.free, problem.friction, problem.delassus.data, problem.factor.data):
            with pytest.raises(ValueError, match="read-only"):
                array[:] = 0.0
        with pytest.raises(ValueError, match="read-only"):
            ContactProblem(before, free, mu).delassus[:] = 0.0


class TestSize:
    @pytest.fixture
    def large(self):
        J, free, mu = columns(50, 25)  # 2500 contacts, 5000 rows
        return ContactProblem(J @ J.T, free, mu)

    def test_no_dense_matrix_beyond_the_stated_size(self, large):
        assert len(large.free) > DENSE_LARGEST
        for form in (large.dense, large.lcp, large.copositive_lcp, ConvexContactProblem(large).lcp):
            with pytest.raises(ModelError, match=f"rows: expected at most {DENSE_LARGEST}") as refusal:
                form()
            assert len(str(refusal.value)) < 500
        with pytest.raises(ModelError, match=f"at most {DENSE_LARGEST}"):
            Lemke().solve(large)

    def test_a_large_dense_matrix_is_kept_without_its_zeros(self):
        n = DENSE_LARGEST + 1
        problem = ContactProblem(np.eye(n), -np.ones(n), np.zeros(n))
        assert scipy.sparse.issparse(problem.delassus)
        found = Auto().solve(problem)
        assert found.solved
        assert np.array_equal(found.z, np.ones(n))

    def test_memory_is_linear(self):
        peaks = []
        for count in (100, 400):
            J, free, mu = columns(count, 10)
            problem = ContactProblem(None, free, mu, factor=J)
            tracemalloc.start()
            problem.residual(np.ones(problem.size))
            peaks.append(tracemalloc.get_traced_memory()[1] / len(mu))
            tracemalloc.stop()
        assert peaks[1] < 1.5 * peaks[0]
        assert max(peaks) < 10_000  # bytes a contact


class TestFiles:
    def test_sparse_stays_sparse(self, tmp_path):
        J, free, mu = columns(3, 4)
        given = [ContactProblem(J @ J.T, free, mu), ContactProblem((J @ J.T).toarray(), free, mu)]
        given.append(ContactProblem(J @ J.T, free, mu, factor=J))
        read = [one.problem for one in load_problems(save_problems(tmp_path / "x.npz", given))]
        for before, after in zip(given, read, strict=True):
            assert scipy.sparse.issparse(after.delassus) == scipy.sparse.issparse(before.delassus)
            assert np.array_equal(after.dense(), before.dense())
            assert (after.factor is None) == (before.factor is None)
        with np.load(tmp_path / "x.npz") as stored:
            assert "A_data_0" in stored.files
            assert "M_0" not in stored.files
            assert "M_1" in stored.files

    def test_hdf5(self, tmp_path):
        pytest.importorskip("h5py")
        from lcpflex.solvers import load_fclib, save_fclib

        pile = columns(10, 8)
        small, large = columns(2, 2), shuffled(pile, 1)
        for J, free, mu in (small, large):
            problem = ContactProblem(J @ J.T, free, mu)
            after = load_fclib(save_fclib(tmp_path / "x.hdf5", problem))
            assert scipy.sparse.issparse(after.delassus) == (len(free) > 200)
            assert np.array_equal(after.dense(), problem.dense())
            assert np.array_equal(after.free, problem.free)
