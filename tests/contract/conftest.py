"""Finding all solvers, and judging them by a measure written anew."""

import dataclasses
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

import lcpflex.solvers
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import interpreted
from lcpflex.solvers import ContactProblem, Lcp, SpatialContactProblem, Status

TOLERANCE = 1e-10

# Methods that converge or not: they owe honesty everywhere, and answers to definite problems of a few unknowns only.
WITHOUT_GUARANTEE = ("GaussSeidel", "BlockGaussSeidel", "MinMapNewton")


def _solver_classes():
    """Every class in the room and its chambers that can solve and refuse, public or not."""
    for module in pkgutil.walk_packages(lcpflex.solvers.__path__, "lcpflex.solvers."):
        for cls in vars(importlib.import_module(module.name)).values():
            solves = callable(getattr(cls, "solve", None)) and callable(getattr(cls, "refuses", None))
            if solves and inspect.isclass(cls) and cls.__module__ == module.name and dataclasses.is_dataclass(cls):
                yield cls


# Those that are made of another solver.
WRAPPERS = {
    "TimeLimit": (lcpflex.solvers.Auto(), 60.0),
    "UserSolver": (lambda problem: lcpflex.solvers.Auto().solve(problem),),
}


def _solvers():
    """(name, solver) of each class, once more for each further backend of quadratic programs that is installed."""
    import qpsolvers

    for cls in sorted(_solver_classes(), key=lambda c: c.__name__):
        backends = {f.name: f.default for f in dataclasses.fields(cls)}.get("backend")
        if cls.__name__ == "QuadraticProgram":
            yield from ((f"{cls.__name__}-{b}", cls(b)) for b in sorted(qpsolvers.available_solvers))
        else:
            assert backends is None, f"{cls.__name__} has a backend: say here which ones exist"
            needed = WRAPPERS.get(cls.__name__, ())
            yield cls.__name__, cls(*needed)


SOLVERS = dict(_solvers())
FLAT = ContactProblem([[1.0, 0.0], [0.0, 1.0]], [-1.0, 0.1], [0.3])
FLAT_LCP = Lcp([[1.0, 0.0, 0.0], [-0.3, 1.0, 1.0], [0.6, -1.0, 0.0]], [-1.0, 0.1, 0.0])  # which a kernel assembles
SPACE = SpatialContactProblem(np.eye(3), [-1.0, 0.1, 0.0], [0.3])
PLANAR = {name: solver for name, solver in SOLVERS.items() if not (solver.refuses(FLAT) and solver.refuses(FLAT_LCP))}
CONES = {name: solver for name, solver in SOLVERS.items() if not solver.refuses(SPACE)}


def pytest_generate_tests(metafunc):
    for name, solvers in (("any_solver", PLANAR), ("cone_solver", CONES)):
        if name in metafunc.fixturenames:
            metafunc.parametrize(name, solvers.values(), ids=solvers)


@pytest.fixture(scope="session")
def all_solvers():
    """Every solver by its name."""
    return SOLVERS


@pytest.fixture(scope="session")
def measure():
    """The residual of a point, from its definition in numpy."""
    return natural_residual


def own_units(problem, lcp):
    """Units of the unknowns by the definition, in plain numpy: contacts by their diagonal, others by that of M."""
    if isinstance(problem, ContactProblem):
        G, n, tangent = problem.dense(), len(problem.friction), np.flatnonzero(problem.friction)
        D = np.diag(G)[:n].copy()
        D[tangent] = np.maximum(D[tangent], np.diag(G)[n:])
        D = np.where(1e-13 * D.max(initial=0.0) < D, D, D.max(initial=0.0))
        s = 1.0 / np.sqrt(np.where(D > 0.0, D, 1.0))
        return np.concatenate([s, s[tangent], 1.0 / s[tangent]])
    A = np.maximum(np.abs(lcp.M), np.abs(lcp.M.T))
    diagonal = np.diag(A)
    smallest, largest = diagonal.min(initial=np.inf), diagonal.max(initial=0.0)
    if smallest > 1e-200 and largest / 16.0 <= smallest and largest < 1e200:
        return np.ones(len(A))
    with np.errstate(all="ignore"):
        d = np.where(diagonal > 0.0, np.clip(1.0 / np.sqrt(diagonal), 1e-150, 1e150), 0.0)
        while (d == 0.0).any():
            shared = (A * d).max(axis=1)
            new = (d == 0.0) & (shared > 0.0)
            if not new.any():
                d[d == 0.0] = d.max() if d.any() else 1.0
            d[new] = np.clip(1.0 / shared[new], 1e-150, 1e150)
        for _ in range(4):
            for i in range(len(d)):
                peak = d[i] * (A[i] * d).max()
                d[i] /= np.sqrt(peak) if 4.0 < peak < np.inf else 1.0
    return d


def natural_residual(problem, z, units=None):
    """max |min(d z, w)| / max(|q| + |M||z|), above 1e-6 |q| relative to |q|; inf for NaN. In units of the unknowns.

    Where those are guessed and M is unsymmetric the larger one of that and of the same in the units given.
    """
    M, q, z = np.asarray(problem.M), np.asarray(problem.q), np.asarray(z)
    if units is None:
        units = own_units(problem, problem)
        if np.abs(M - M.T).max(initial=0.0) > 1e-10 * np.abs(M).max(initial=0.0) and (units != 1.0).any():
            return max(natural_residual(problem, z, units), natural_residual(problem, z, np.ones(len(z))))
    load = np.abs(q).max(initial=0.0) or 1.0
    with np.errstate(all="ignore"):
        M, q, z = M * units * units[:, None], q / load * units, z / load / units
    if not np.isfinite(z).all():
        return np.inf
    if not len(z):
        return 0.0
    with np.errstate(all="ignore"):
        row = np.abs(M).max(axis=1)
        w = (M.astype(np.longdouble) @ z.astype(np.longdouble)).astype(float) + q
        worst = np.abs(np.minimum(np.where(row > 0, row, 1.0) * z, w)).max()
        size = (np.abs(q) + np.abs(M) @ np.abs(z)).max()
    if not np.isfinite([worst, size]).all():
        return np.inf
    if worst > 1e-6 * np.abs(q).max():
        return worst / np.abs(q).max() if q.any() else np.inf
    return worst / size if worst else 0.0


@pytest.fixture(scope="session")
def faults():
    """What is wrong with an answer, as a list of sentences."""
    return find_faults


def find_faults(example, solution):
    """Compare an answer with what is known, by a measure and a check of certificates of their own."""
    lcp, found = example.lcp, []
    units = own_units(example.problem, lcp) if isinstance(example.problem, ContactProblem) else None
    residual = natural_residual(lcp, solution.z, units) if len(solution.z) == lcp.size else np.inf
    if solution.solved != (solution.residual <= TOLERANCE) or (solution.solved and residual > 1.001 * TOLERANCE):
        found.append(f"{solution.status.name}, residual {solution.residual:.1e} said and {residual:.1e} found")
    if solution.solved and example.outcome in (Status.INFEASIBLE, Status.NO_SOLUTION):
        found.append(f"{solution.status.name}, but there is no solution")
    if solution.status in (Status.INFEASIBLE, Status.NO_SOLUTION) and example.solvable:
        found.append(f"{solution.status.name}, but there is a solution")
    if solution.status is Status.NOT_UNIQUE:
        others = [z for z in solution.solutions if natural_residual(lcp, z, units) <= 1.001 * TOLERANCE]
        if not any((z != others[0]).any() for z in others):
            found.append("NOT_UNIQUE without two solutions")
        if example.unique == "z":
            found.append("NOT_UNIQUE, but there is one solution")
    if (solution.status is Status.INFEASIBLE) != (solution.certificate is not None):
        found.append("INFEASIBLE if and only if there is a certificate")
    elif solution.certificate is not None and not _proves(lcp, solution.certificate):
        found.append("the certificate proves nothing")
    if solution.solved and example.z is not None and example.unique:
        found += _motion_faults(example, solution.z)
    return found


def _proves(lcp, u):
    """No 0 <= z has w >= 0 as far as z_i <= 1e6 max|q| / max_j |M_ji|: there 0 <= u.w = q.u + z.(M^T u) < 0.

    Rounding leaves a proof no larger reach: M^T u is not exactly <= 0.
    """
    if not np.isfinite(u).all() or (u < 0.0).any():
        return False
    column = np.abs(lcp.M).max(axis=0)
    reach = 1e6 * np.abs(lcp.q).max() / np.where(column > 0.0, column, np.inf)
    return bool(lcp.q @ u + np.maximum(lcp.M.T @ u, 0.0) @ reach < 0.0)


def _motion_faults(example, z):
    """Where w (or the contact velocity) is unique, the distance to it is bounded by the residual.

    For M definite or semidefinite and points with |min(d z, w)| <= r, the energy of the difference e is
    e.M e <= r (|z|_1 + |z*|_1 + |w|_1 / d + |w*|_1 / d), and |M e|_i^2 <= M_ii e.M e.
    """
    lcp = example.lcp
    if not lcp.symmetric:
        return []
    d = np.abs(lcp.M).max(axis=1, initial=0.0)
    d[d == 0.0] = 1.0
    points = [(np.maximum(p, 0.0), lcp.M @ p + lcp.q) for p in (z, example.z)]
    r = max(np.abs(np.minimum(d * p, w)).max(initial=0.0) for p, w in points)
    r += 1e-15 * len(z) * (np.abs(lcp.q) + np.abs(lcp.M) @ np.abs(z)).max(initial=0.0)
    energy = r * sum((p + np.abs(w) / d).sum() for p, w in points)
    gap = np.abs(points[0][1] - points[1][1])
    bound = 4.0 * np.sqrt(np.diag(lcp.M) * energy) + 4.0 * r
    return [f"w differs by {gap.max():.1e}"] if (gap > bound).any() else []


@pytest.fixture
def attempt(measure):
    """Have a problem solved, or refused for the reason given."""
    return try_solver


def try_solver(solver, problem, guess=None):
    """The solution, None if the solver refuses: then with the reason that it gives when it is asked."""
    reason = solver.refuses(problem)
    if reason:
        with pytest.raises(ModelError) as caught:
            solver.solve(problem, guess)
        assert reason in str(caught.value)
        return None
    solution = solver.solve(problem, guess)
    assert isinstance(solution.status, Status)
    if not getattr(solver, "model", ""):
        lcp = problem.lcp() if isinstance(problem, ContactProblem) else problem
        assert isinstance(lcp, Lcp)
        assert solution.solved == (solution.residual <= TOLERANCE)
        units = own_units(problem, lcp) if isinstance(problem, ContactProblem) else None
        assert not solution.solved or natural_residual(lcp, solution.z, units) <= 1.001 * TOLERANCE
    return solution


@pytest.fixture(scope="session")
def guaranteed():
    """Whether a solver may be asked for the answer, not only for the truth."""
    return lambda solver: type(solver).__name__ not in WITHOUT_GUARANTEE


@pytest.fixture
def as_plain_python(monkeypatch):
    """Run a solver with the kernels that it calls as plain Python."""

    def plain(kernel):
        scope = kernel.py_func.__globals__
        called = {name: scope[name] for name in kernel.py_func.__code__.co_names if hasattr(scope.get(name), "py_func")}
        return interpreted(kernel, **{name: plain(inner) for name, inner in called.items()})

    def switch(solver):
        count = 0
        for module in {m.__module__ for m in (type(solver), *_solver_classes())}:
            scope = importlib.import_module(module)
            for name, value in list(vars(scope).items()):
                if hasattr(value, "py_func"):
                    monkeypatch.setattr(scope, name, plain(value))
                    count += 1
        return count

    return switch
