"""Methods for 0 <= z _|_ w = M z + q >= 0, and proofs that there is none.

To add one: a frozen dataclass with ``solve(problem, guess=None)`` that ends in
:func:`lcpflex.solvers.acceptance.accept`, and its name in :mod:`lcpflex.solvers`.
"""
