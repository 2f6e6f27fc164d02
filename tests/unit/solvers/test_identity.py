"""Problems, solutions and outcomes are compared by identity, and what a user sees of a problem cannot be written."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import (
    Auto,
    BoxedLcp,
    ContactProblem,
    Lcp,
    MixedLcp,
    SpatialContactProblem,
    replay,
)
from lcpflex.solvers.contact.relaxation import ConvexContactProblem

M, q = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-1.0, -1.0])
SPARSE = scipy.sparse.csr_array(np.eye(3))
MAKE = {
    "lcp": lambda: Lcp(M, q),
    "factored": lambda: Lcp(np.eye(2), q, np.eye(2)),
    "mixed": lambda: MixedLcp(M, q, [0]),
    "boxed": lambda: BoxedLcp(M, q, 0.0, [1.0, np.inf]),
    "contact": lambda: ContactProblem(M, q, [0.3]),
    "sparse contact": lambda: ContactProblem(SPARSE, [1.0, 2.0, 3.0], [0.0] * 3),
    "by factor": lambda: ContactProblem(None, q, [0.3], factor=np.eye(2)),
    "relaxed": lambda: ConvexContactProblem(ContactProblem(M, q, [0.3])),
    "space": lambda: SpatialContactProblem(np.eye(3), np.ones(3), [0.3]),
    "sparse space": lambda: SpatialContactProblem(SPARSE, np.ones(3), [0.3]),
    "solution": lambda: Auto().solve(Lcp(M, q)),
    "replay": lambda: replay([Lcp(M, q)], Auto(), repeats=1),
}
PROBLEMS = [name for name in MAKE if name not in ("solution", "replay")]


@pytest.mark.parametrize("name", MAKE)
def test_two_of_the_same_numbers_are_two(name):
    one, other = MAKE[name](), MAKE[name]()
    assert one == one
    assert one != other
    assert other in [one, other]
    assert [one, other].index(other) == 1
    assert len({one, other, one}) == 2
    assert one != 3


@pytest.mark.parametrize("name", [name for name in PROBLEMS if name != "relaxed"])
def test_data_cannot_be_written(name):
    for part in MAKE[name]().data if name != "mixed" else MAKE[name]().boxed.data:
        for array in (part.data, part.indices, part.indptr) if scipy.sparse.issparse(part) else (part,):
            if array is not None:
                with pytest.raises(ValueError, match="read-only"):
                    array[...] = 0


class TestUnits:
    """A problem in other units is another one."""

    badly_scaled = staticmethod(lambda: Lcp([[1.0, 0.0], [0.0, 1e12]], [-1.0, -1e6]))

    def test_the_problem_stays_as_it_is(self):
        z = [0.9, 1e-6]
        for change in (lambda p: p.measured_in([1.0, 1.0]), lambda p: p.measured_alike()):
            problem, twin = self.badly_scaled(), self.badly_scaled()
            before = twin.residual(z)
            made = change(problem)
            assert made is not problem
            assert problem.residual(z) == before
            assert change(problem).residual(z) == made.residual(z)  # in either order
            assert made.residual(z) != before
            assert change(twin).residual(z) == made.residual(z)  # also where it was looked at before
            assert made.M.base is problem.M.base  # no copy of the numbers

    def test_a_factor_and_what_is_known_of_M_go_along(self):
        problem = Lcp(np.diag([1.0, 4.0]), q, np.diag([1.0, 2.0]))
        made = problem.measured_in([2.0, 3.0])
        assert made.factor is problem.factor
        assert made.matrix_class == "positive semidefinite"
        assert Auto().solve(made).z == pytest.approx([1.0, 0.25])

    @pytest.mark.parametrize("units", [[1.0], [1.0, 0.0], [1.0, -1.0], [1.0, np.nan], [np.inf, 1.0], "m", None])
    def test_what_is_no_unit(self, units):
        with pytest.raises(ModelError, match="units"):
            Lcp(M, q).measured_in(units)
