"""Ctrl-C while a kernel works: a signal sets a number that kernels ask for by counted work."""

import signal
import threading

import numpy as np
import pytest

from lcpflex.solvers import Auto, GaussSeidel, Lcp, Lemke, MinMapNewton, PrincipalPivoting
from lcpflex.solvers.attention import LARGE, Ear, is_called, listening
from lcpflex.solvers.lcp.active_factor import factorise
from lcpflex.solvers.lcp.gauss_seidel import projected_gauss_seidel
from lcpflex.solvers.lcp.lemke import attempt, lemke, lemke_workspace, lexicographic_attempt
from lcpflex.solvers.lcp.newton import min_map_newton, newton_workspace
from lcpflex.solvers.lcp.pivoting import block_pivots
from lcpflex.solvers.lcp.principal_pivoting import principal_pivoting, principal_pivoting_workspace
from lcpflex.solvers.status import SOLVED

HANDLED = getattr(signal, "SIGUSR1", signal.SIGINT)
N = 20


def hard(n=N):
    """M (n, n), q (n,) of Murty, on which Lemke's method takes 2^n pivots, and its like without symmetry."""
    return np.tril(2.0 * np.ones((n, n)), -1) + np.eye(n), -np.ones(n)


def symmetric(n=N):
    A = np.random.default_rng(3).standard_normal((n, n))
    return A @ A.T, -np.ones(n)


def called(workspace):
    workspace[-1][-1] = 1
    return workspace


@pytest.fixture
def handled():
    """A signal whose handler returns; how often it ran."""
    ran = []
    before = signal.signal(HANDLED, lambda *_: ran.append(1))
    yield ran
    signal.signal(HANDLED, before)


@pytest.fixture
def interrupted():
    """Ctrl-C raises KeyboardInterrupt, which a process started in the background does not set up."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


class TestKernels:
    """Each returns after at most one piece of its work once the number is set."""

    def test_lemke(self):
        M, q = hard()
        table, basis = called(lemke_workspace(N))
        for one in (attempt(M, q, N, table, basis, 0, 10_000), lexicographic_attempt(M, q, N, table, basis, 10_000)):
            assert one[0] != SOLVED
            assert one[1] == 0
        assert lemke(M, q, N, np.zeros(N), table, basis, 10_000)[1] == 0

    def test_block_pivots(self):
        table, basis = called(lemke_workspace(N))
        basis[:N] = 1
        assert block_pivots(*hard(), N, np.zeros(N), table, basis, 100) == (-1, np.inf)

    def test_principal_pivoting(self):
        M, q = symmetric()
        factor, basis = called(principal_pivoting_workspace(N))
        assert principal_pivoting(M, q, N, np.zeros(N), factor, basis, False, 1e-10, 10_000)[1] == 0
        basis[:N] = 1
        assert factorise(M, N, factor, basis) == 0

    def test_newton(self):
        vectors, table, basis = called(newton_workspace(N))
        found = min_map_newton(*hard(), N, np.zeros(N), False, 1e-10, 10_000, vectors, table, basis)
        assert found[0] != SOLVED
        assert found[1] == 0

    def test_gauss_seidel(self):
        M, q = symmetric()
        table, basis = called(lemke_workspace(N))
        found = projected_gauss_seidel(M, q, N, np.zeros(N), 1.0, 1e-10, 10_000, np.zeros(N), table, basis)
        assert found[0] != SOLVED
        assert found[1] == 0


class TestEar:
    def test_a_signal_reaches_the_numbers(self, handled):
        """And the solve is repeated from its beginning, where the handler returns."""
        ear, seen = Ear(np.zeros(7, dtype=np.int64)), []

        def solve():
            seen.append(bool(is_called(ear.numbers)))
            if len(seen) < 4:
                signal.raise_signal(HANDLED)
                assert is_called(ear.numbers)
            return len(seen)

        assert ear(solve) == 4
        assert seen == [False] * 4
        assert len(handled) == 3

    def test_control_c_ends_it(self, interrupted):
        ear, calls = Ear(np.zeros(7, dtype=np.int64)), []

        def solve():
            calls.append(1)
            signal.raise_signal(signal.SIGINT)

        with pytest.raises(KeyboardInterrupt):
            ear(solve)
        assert calls == [1]
        assert signal.set_wakeup_fd(-1) == -1  # nothing is left behind

    def test_what_was_in_the_numbers_stays(self):
        numbers = np.arange(9, dtype=np.int64)
        numbers[-1] = 0
        assert (Ear(numbers).numbers == numbers).all()
        assert listening(numbers, LARGE - 1)[0] is numbers

    def test_who_listens_already_goes_on(self, handled):
        other, ear, calls = Ear(np.zeros(3, dtype=np.int64)), Ear(np.zeros(3, dtype=np.int64)), []

        def solve():
            calls.append(1)
            if len(calls) == 1:
                ear(lambda: signal.raise_signal(HANDLED))

        other(solve)
        assert len(calls) == 2  # the one who listened was called
        assert not is_called(ear.numbers)

    def test_threads_are_not_called(self):
        found = []
        thread = threading.Thread(target=lambda: found.append(Ear(np.zeros(3, dtype=np.int64))(lambda: 1)))
        thread.start()
        thread.join()
        assert found == [1]


@pytest.mark.parametrize("solver", [Auto(), Lemke(), MinMapNewton(), GaussSeidel()], ids=lambda s: type(s).__name__)
def test_large_solves_listen_and_find_the_same(solver, monkeypatch):
    """A solve that listens comes to the bits of one that does not."""
    n = LARGE + 10
    A = np.random.default_rng(7).standard_normal((n, n))
    for M in (A @ A.T + n * np.eye(n), A @ A.T + n * np.eye(n) + A - A.T):
        problem = Lcp(M, np.random.default_rng(8).standard_normal(n))
        heard = solver.solve(problem)
        with monkeypatch.context() as patch:
            patch.setattr("lcpflex.solvers.attention.LARGE", 10 * n)
            deaf = solver.solve(problem)
        assert np.array_equal(heard.z, deaf.z)
        assert heard.status is deaf.status


def test_principal_pivoting_listens_with_a_guess():
    n = LARGE + 10
    A = np.random.default_rng(9).standard_normal((n, n))
    problem = Lcp(A @ A.T + np.eye(n), np.random.default_rng(10).standard_normal(n))
    first = PrincipalPivoting().solve(problem)
    again = PrincipalPivoting().solve(problem, first)
    assert again.solved
    assert again.iterations == 1


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer of signals")
def test_a_signal_ends_a_long_path():
    """A path of 2^30 pivots is left early; the last one, after the handler, ends by itself.

    The timer goes on: a signal that came before the solve listened would be the only one else.
    """
    n, long = 30, 10**9
    (M, q), (table, basis), pivots = hard(n), lemke_workspace(n), []
    ear = Ear(basis)

    def solve():
        limit = 100 if pivots and pivots[-1] else long
        pivots.append(lexicographic_attempt(M, q, n, table, ear.numbers, limit)[1])

    before = signal.signal(signal.SIGALRM, lambda *_: None)
    signal.setitimer(signal.ITIMER_REAL, 0.2, 0.2)
    try:
        ear(solve)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)  # before its signal ends the process again
        signal.signal(signal.SIGALRM, before)
    assert pivots[0] < long
    assert pivots[-1] == 100
