"""Factors of large meshes: their cost is counted before, PARDISO makes them where it is there, failures are told."""

from __future__ import annotations

import sys
import types
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import cholesky
from scipy.sparse import csc_matrix, diags_array, kron, random_array

import lcpflex as lf
from lcpflex.basics import libs
from lcpflex.bodies.fem import factor_cost, pardiso, sparse_factor
from lcpflex.bodies.fem.factor_cost import PARDISO, SUPERLU, Cost, check_reach, cost_of
from lcpflex.bodies.fem.factors import SuperLuFactor
from lcpflex.bodies.fem.sparse_factor import NotPositive, positive_factor
from lcpflex.bodies.reduction import kept_factor
from lcpflex.bodies.reduction.kept_factor import free_mesh
from lcpflex.errors import ModelError, ModelWarning

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}


@cache
def grid(k: int = 9) -> csc_matrix:
    """A discrete Laplace operator of k^3 nodes, positive definite."""
    line = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(k, k))
    one = diags_array(np.ones(k))
    return (kron(kron(line, one), one) + kron(kron(one, line), one) + kron(kron(one, one), line)).tocsc()


def by_superlu(matrix: csc_matrix) -> SuperLuFactor:
    found = positive_factor(matrix, np.arange(matrix.shape[0]))
    assert isinstance(found, SuperLuFactor)
    return found


class TestCost:
    def test_it_is_that_of_a_full_factor(self):
        rng = np.random.default_rng(3)
        pattern = random_array((60, 60), density=0.05, rng=rng)
        matrix = (pattern @ pattern.T + 5.0 * diags_array(np.ones(60))).tocsc()
        lower = cholesky(matrix.toarray(), lower=True)
        columns = (np.abs(lower) > 1e-14).sum(axis=0)
        found = cost_of(matrix)
        assert found.entries == columns.sum()
        assert found.operations == (columns**2).sum()

    def test_a_full_matrix(self):
        assert cost_of(csc_matrix(np.ones((7, 7)))) == (28.0, 140.0)

    def test_memory_of_a_factor_is_what_was_counted(self):
        found = by_superlu(grid())
        assert found.memory == pytest.approx(SUPERLU.memory * cost_of(grid()).entries, rel=0.05)

    def test_small_factors_say_nothing(self):
        check_reach(1000, Cost(1e6, 1e8), SUPERLU, better=True)  # warnings are errors here

    def test_a_long_one_is_told_with_what_pardiso_would_take(self):
        said = (
            r"210000 degrees of freedom takes about 9.1 GiB and 3 minutes .*PARDISO \(pip install 'lcpflex\[large\]'\)"
        )
        with pytest.warns(ModelWarning, match=said + r" does it in 2.2 GiB and 28 s"):
            check_reach(210_000, Cost(2.5e8, 7e11), SUPERLU, better=True)
        with pytest.warns(ModelWarning, match="3 minutes to factorise: take a coarser mesh"):
            check_reach(210_000, Cost(2.5e8, 7e11), SUPERLU)

    def test_one_beyond_the_machine_is_refused(self, monkeypatch):
        monkeypatch.setattr(factor_cost, "memory_of_machine", lambda: 8.0 * 2**30)
        with pytest.raises(ModelError, match=r"stiffness: .* 9.1 GiB .* this machine has 8 GiB, expected a smaller"):
            check_reach(210_000, Cost(2.5e8, 7e11), SUPERLU)
        check_reach(210_000, Cost(2.5e8, 7e11), PARDISO)

    def test_one_beyond_the_numbers_of_superlu_is_refused(self, monkeypatch):
        monkeypatch.setattr(factor_cost, "memory_of_machine", lambda: np.inf)
        with pytest.raises(ModelError, match="more entries than SuperLU counts"):
            check_reach(10**6, Cost(3e9, 1e13), SUPERLU)

    @pytest.mark.parametrize(("text", "limit"), [("1048576\n", 2.0**20), ("max\n", None), (None, None)])
    def test_a_container_has_its_own_memory(self, tmp_path, monkeypatch, text, limit):
        file = tmp_path / "memory.max"
        if text is not None:
            file.write_text(text)
        monkeypatch.setattr(factor_cost, "CONTAINER", Path(file))
        found = factor_cost.memory_of_machine()
        assert found == limit if limit is not None else found >= 2.0**29

    def test_before_the_work_begins(self, monkeypatch):
        monkeypatch.setattr(sparse_factor, "FEW", 100)
        monkeypatch.setattr(factor_cost, "memory_of_machine", lambda: 1e5)
        monkeypatch.setattr(sparse_factor, "_superlu", lambda _: pytest.fail("it was begun"))
        with pytest.raises(ModelError, match="729 degrees of freedom"):
            by_superlu(grid())

    def test_full_matrices_are_counted_however_small(self, monkeypatch):
        monkeypatch.setattr(sparse_factor, "PER_ROW", 1)
        monkeypatch.setattr(sparse_factor, "FEW", 3000)
        monkeypatch.setattr(factor_cost, "memory_of_machine", lambda: 1e5)
        with pytest.raises(ModelError, match="729 degrees of freedom"):
            by_superlu(grid())


class Fake:
    """What pypardiso has, by a dense inverse."""

    class pardiso_wrapper:  # as a module is written
        class PyPardisoError(Exception):
            def __init__(self, value: int) -> None:
                self.value = value

    def __init__(self, error: int = 0) -> None:
        self.error, self.freed, self.layers = error, 0, []
        outer = self

        class PyPardisoSolver:
            libmkl = types.SimpleNamespace(
                MKL_Set_Interface_Layer=lambda layer: outer.layers.append(("interface", layer)),
                MKL_Set_Threading_Layer=lambda layer: outer.layers.append(("threads", layer)),
            )

            def __init__(self, mtype: int = 11) -> None:
                self.iparm = {}
                outer.mtype = mtype

            def set_iparm(self, number: int, value: int) -> None:
                self.iparm[number] = value

            def get_iparm(self, number: int) -> int:
                return {16: 100, 17: 900}[number]

            def factorize(self, upper) -> None:
                assert abs(upper - upper.T).nnz, "one triangle was expected"
                if outer.error:
                    raise Fake.pardiso_wrapper.PyPardisoError(outer.error)
                whole = upper.toarray()
                self.inverse = np.linalg.inv(whole + np.triu(whole, 1).T)

            def solve(self, upper, right):
                return self.inverse @ right

            def free_memory(self, *, everything: bool) -> None:
                assert everything
                outer.freed += 1

        self.PyPardisoSolver = PyPardisoSolver


@pytest.fixture
def small(monkeypatch):
    """Meshes of these tests are large."""
    monkeypatch.setattr(sparse_factor, "FEW", 100)
    monkeypatch.setattr(sparse_factor, "LARGE", 1e3)
    pardiso.is_there.cache_clear()
    yield
    pardiso.is_there.cache_clear()


def install(monkeypatch, module) -> None:
    """Have ``import pypardiso`` find this; None: nothing."""
    monkeypatch.setitem(vars(libs), "pypardiso", None)  # what is loaded in its place goes with the test
    del vars(libs)["pypardiso"]
    monkeypatch.setitem(sys.modules, "pypardiso", module)


@pytest.mark.usefixtures("small")
class TestPardiso:
    def test_it_takes_the_large_ones_and_frees_its_memory(self, monkeypatch):
        fake = Fake()
        install(monkeypatch, fake)
        factor = positive_factor(grid(), np.arange(grid().shape[0]))
        assert (fake.mtype, fake.layers) == (2, [("interface", 0), ("threads", 1)])
        assert factor.in_blocks
        assert factor.memory == 1000 * 1024
        right = np.random.default_rng(1).standard_normal((grid().shape[0], 70))
        plain = by_superlu_alone(grid())
        assert factor.solve(right) == pytest.approx(plain.solve(right), rel=1e-9, abs=1e-9)
        assert factor.solve(right[:, 0]) == pytest.approx(plain.solve(right[:, 0]), rel=1e-9, abs=1e-9)
        assert fake.freed == 0
        del factor
        assert fake.freed == 1

    def test_small_ones_stay_with_superlu(self, monkeypatch):
        install(monkeypatch, Fake())
        monkeypatch.setattr(sparse_factor, "LARGE", 1e12)
        assert not by_superlu(grid()).in_blocks

    def test_a_pivot_that_is_not_positive(self, monkeypatch):
        fake = Fake(error=-4)
        install(monkeypatch, fake)
        with pytest.raises(NotPositive):
            positive_factor(grid(), np.arange(grid().shape[0]))
        assert fake.freed == 1

    def test_too_little_memory(self, monkeypatch):
        install(monkeypatch, Fake(error=-2))
        with pytest.raises(ModelError, match="the memory does not suffice to factorise a mesh of 729"):
            positive_factor(grid(), np.arange(grid().shape[0]))

    def test_other_errors_are_told_and_superlu_goes_on(self, monkeypatch):
        install(monkeypatch, Fake(error=-3))
        with pytest.warns(ModelWarning, match="installed but fails with error -3: large meshes"):
            by_superlu(grid())

    def test_without_it(self, monkeypatch):
        install(monkeypatch, None)
        by_superlu(grid())

    def test_without_its_library_it_is_told_once(self, monkeypatch):
        class Broken(types.ModuleType):
            def __getattr__(self, name: str):
                raise ImportError("Shared library mkl_rt not found.")

        install(monkeypatch, Broken("pypardiso"))
        with pytest.warns(ModelWarning, match=r"installed but cannot be loaded \(Shared library mkl_rt not found"):
            by_superlu(grid())
        by_superlu(grid())


def by_superlu_alone(matrix: csc_matrix) -> SuperLuFactor:
    order = np.arange(matrix.shape[0])
    return SuperLuFactor(sparse_factor._superlu(matrix), order)


@pytest.mark.usefixtures("small")
class TestTheRealOne:
    @pytest.fixture(autouse=True)
    def installed(self):
        pytest.importorskip("pypardiso", reason="the extra lcpflex[large] is not installed")

    def test_solutions(self):
        factor = positive_factor(grid(), np.arange(grid().shape[0]))
        assert isinstance(factor, pardiso.PardisoFactor)
        right = np.random.default_rng(1).standard_normal((grid().shape[0], 70))
        assert grid() @ factor.solve(right) == pytest.approx(right, rel=1e-9, abs=1e-9)
        assert grid() @ factor.solve(right[:, 0]) == pytest.approx(right[:, 0], rel=1e-9, abs=1e-9)

    def test_an_indefinite_matrix(self):
        n = grid().shape[0]
        with pytest.raises(NotPositive):
            positive_factor((grid() - 0.5 * diags_array(np.ones(n))).tocsc(), np.arange(n))

    def test_two_at_a_time(self):
        n = grid().shape[0]
        first, second = (positive_factor((k * grid()).tocsc(), np.arange(n)) for k in (1.0, 2.0))
        one = np.ones(n)
        assert first.solve(one) == pytest.approx(2.0 * second.solve(one))
        del first
        assert grid() @ second.solve(one) == pytest.approx(0.5 * one)


def test_factors_that_are_kept_are_few_and_small(monkeypatch):
    made = [lf.Solid.box((0.3, 0.2, 0.1 * k), elements=(2, 2, 2), **STEEL) for k in (1, 2, 3)]
    meshes = [one.finite_elements() for one in made]
    first = free_mesh(meshes[0])
    assert free_mesh(meshes[0]) is first
    free_mesh(meshes[1])
    assert free_mesh(meshes[0]) is first
    monkeypatch.setattr(kept_factor, "MEMORY", 0.5 * first._factor.memory)
    last = free_mesh(meshes[2])
    assert free_mesh(meshes[2]) is last
    assert free_mesh(meshes[0]) is not first
