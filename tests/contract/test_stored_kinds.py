"""Every kind of problem written, read, and solved again as before."""

import numpy as np
import pytest
import scipy.sparse

from lcpflex.errors import ModelError
from lcpflex.solvers import (
    Auto,
    BoxedLcp,
    ContactProblem,
    Lcp,
    Lemke,
    MixedLcp,
    PrincipalPivoting,
    QuadraticProgram,
    SpatialContactProblem,
    Status,
    load_problems,
    replay,
    save_problems,
)
from lcpflex.solvers.contact.cone import ConvexFriction
from lcpflex.solvers.contact.relaxation import ConvexContactProblem

rng = np.random.default_rng(5)
J = rng.standard_normal((5, 6))
FREE, MU = np.array([-1.0, 0.5, -0.2, 0.3, -0.4]), np.array([0.3, 0.0, 0.7])
KEYS = (("foot", 1), "heel", ("toe", ("left", 2)))
SPARSE = scipy.sparse.csr_array(J * (np.abs(J) > 0.4))
SPACE = np.array([-1.0, 0.2, 0.0, -1.0, 0.0, 2.0]), [0.3, 0.5], ("a", ("b", 2))
CONTACT = ContactProblem(J @ J.T, FREE, MU, KEYS)
PROBLEMS = {
    "lcp": Lcp(J @ J.T, FREE),
    "lcp with a factor": Lcp(J @ J.T, FREE, J),
    "mixed": MixedLcp(J @ J.T, FREE, [1, 3]),
    "boxed": BoxedLcp(J @ J.T, FREE, [0.0, -np.inf, -1.0, 0.0, -np.inf], [0.1, np.inf, 1.0, np.inf, 0.2]),
    "contact": CONTACT,
    "contact by its factor": ContactProblem(None, FREE, MU, KEYS, J),
    "contact by its sparse factor": ContactProblem(None, FREE, MU, KEYS, SPARSE),
    "relaxed": ConvexContactProblem(CONTACT),
    "relaxed by its factor": ConvexContactProblem(ContactProblem(None, FREE, MU, KEYS, SPARSE)),
    "spatial": SpatialContactProblem(np.eye(6), *SPACE),
    "spatial, sparse": SpatialContactProblem(scipy.sparse.csr_array(np.eye(6)), *SPACE),
    "spatial by its factor": SpatialContactProblem(None, *SPACE, np.eye(6)),
    "spatial by its sparse factor": SpatialContactProblem(None, *SPACE, scipy.sparse.csr_array(np.eye(6))),
}


def fields(problem):
    """Every array and name of a problem."""
    if isinstance(problem, ConvexContactProblem):
        return fields(problem.contact)
    names = ("M", "q", "factor", "free", "lower", "upper", "delassus", "friction", "keys")
    return {name: getattr(problem, name) for name in names if hasattr(problem, name)}


@pytest.mark.parametrize("name", PROBLEMS)
def test_comes_back_to_the_bit_and_is_solved_alike(tmp_path, name):
    was = PROBLEMS[name]
    (record,) = load_problems(save_problems(tmp_path / "x", [was], [name]))
    now = record.problem
    assert (type(now), record.name) == (type(was), name)
    before, after = fields(was), fields(now)
    assert before.keys() == after.keys()
    for key, value in before.items():
        if value is None or key == "keys":
            assert after[key] == value
            continue
        assert scipy.sparse.issparse(after[key]) == scipy.sparse.issparse(value)
        dense = [x.toarray() if scipy.sparse.issparse(x) else x for x in (value, after[key])]
        np.testing.assert_array_equal(*dense)
    if not name.startswith("spatial"):
        first, again = Auto().solve(was), Auto().solve(now)
        assert first.solved
        assert first.z.tobytes() == again.z.tobytes()
    else:
        r = np.array([1.0, -0.2, 0.0, 1.0, 0.0, -0.5])
        assert now.residual(r) == was.residual(r) == pytest.approx(0.0, abs=1e-15)


def test_all_kinds_in_one_file_are_replayed(tmp_path):
    records = load_problems(save_problems(tmp_path / "all", list(PROBLEMS.values()), list(PROBLEMS)))
    assert [one.name for one in records] == list(PROBLEMS)
    taken = [one for one in records if not one.name.startswith("spatial")]
    found = replay(taken, {"Auto": Auto(), "Lemke": Lemke()}, repeats=1)
    assert not found.contradictory
    assert [row.solved for row in found.rows] == [len(taken)] * 2
    everything = replay(records, {"Lemke": Lemke()}, repeats=1)
    assert (everything.rows[0].solved, everything.rows[0].refused) == (len(taken), len(records) - len(taken))


def test_other_programs_do_not_take_boxes_for_lcps(tmp_path):
    with np.load(save_problems(tmp_path / "x", [PROBLEMS["boxed"], PROBLEMS["mixed"]])) as stored:
        assert not {"M_0", "q_0", "M_1", "q_1"} & set(stored.files)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"kind_0": "mixed", "matrix_0": np.eye(2), "vector_0": np.ones(2)}, "key free_0 is missing"),
        ({"kind_0": "boxed", "matrix_0": np.eye(1), "vector_0": [1.0], "lower_0": 0.0}, "key upper_0 is missing"),
        ({"kind_0": "boxed", "matrix_0": np.eye(1), "vector_0": [1.0], "lower_0": 1.0, "upper_0": 0.0}, "<= upper"),
        ({"kind_0": "soft"}, "kind is 'soft': expected one of"),
        ({"kind_0": "spatial", "A_0": np.eye(3), "b_0": np.ones(3)}, "key mu_0 is missing"),
        ({"b_0": np.ones(2), "mu_0": [0.1], "factor_data_0": [1.0]}, "key factor_indices is missing"),
        (
            {"b_0": np.ones(2), "mu_0": [0.1], "factor_data_0": [1.0], "factor_indices_0": [7],
             "factor_indptr_0": [0, 1, 1], "factor_shape_0": [2, 2]},
            "factor",
        ),
    ],
)  # fmt: skip
def test_what_is_missing_or_damaged_is_named(tmp_path, arrays, words):
    np.savez(tmp_path / "x.npz", **arrays)
    with pytest.raises(ModelError, match=words):
        load_problems(tmp_path / "x.npz")


SOLVERS = [Auto(), Lemke(), PrincipalPivoting(), QuadraticProgram()]


class TestRelaxationAsAnLcp:
    @pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
    @pytest.mark.parametrize("name", ["relaxed", "relaxed by its factor"])
    def test_all_solvers_find_what_clarabel_finds(self, solver, name):
        problem = PROBLEMS[name]
        found, cone = solver.solve(problem), ConvexFriction().solve(problem.contact)
        assert found.solved
        assert cone.solved
        assert found.w == pytest.approx(cone.w, abs=1e-9)
        assert solver.solve(problem, found).solved

    def test_jaws_are_proved_infeasible(self):
        contact = ContactProblem([[1.0, -1.0], [-1.0, 1.0]], [-1.0, -1.0], [0.0, 0.0])
        assert Auto().solve(ConvexContactProblem(contact)).status is Status.INFEASIBLE
