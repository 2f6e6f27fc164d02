"""Siconos' Lemke algorithm or its Gauss-Seidel for planar friction on stored problems.

    /usr/bin/python3 siconos_solvers.py lemke|gauss-seidel TOLERANCE FILE.npz

reads M_i and q_i, with mu_i if there is friction (rows normal, tangent of each contact in turn), and prints one line of
JSON: for each problem the seconds of a call (least of five loops), the point found and the flag. Needs no lcpflex.
"""

import json
import sys
import time

import numpy as np
import siconos.numerics as sn


def seconds_of(call):
    """Least of five loops of about 2 ms."""
    began = time.perf_counter()
    call()
    repeats = max(1, int(2e-3 / max(time.perf_counter() - began, 1e-7)))
    least = np.inf
    for _ in range(5):
        began = time.perf_counter()
        for _ in range(repeats):
            call()
        least = min(least, (time.perf_counter() - began) / repeats)
    return least


def by_lemke(M, q, mu, tolerance):
    """(call, point) of the pivoting solver behind the driver, which reports failure."""
    problem, options = sn.LCP(M, q), sn.SolverOptions(sn.SICONOS_LCP_LEMKE)
    z, w = np.zeros(len(q)), np.zeros(len(q))

    def call():
        z[:] = 0.0
        return sn.linearComplementarity_driver(problem, z, w, options)

    return call, z


def by_gauss_seidel(M, q, mu, tolerance):
    """(call, impulses) of the block Gauss-Seidel for planar friction."""
    problem = sn.FrictionContactProblem(2, len(mu), M, q, mu)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = 20000
    r, u = np.zeros(len(q)), np.zeros(len(q))

    def call():
        r[:] = 0.0
        u[:] = 0.0
        return sn.fc2d_driver(problem, r, u, options)

    return call, r


def main(solver, tolerance, path):
    """Time all problems of the file."""
    method = {"lemke": by_lemke, "gauss-seidel": by_gauss_seidel}[solver]
    found = []
    with np.load(path) as stored:
        for i in range(sum(name.startswith("q_") for name in stored.files)):
            mu = stored[f"mu_{i}"] if f"mu_{i}" in stored.files else None
            call, point = method(stored[f"M_{i}"], stored[f"q_{i}"], mu, tolerance)
            flag = int(call())
            found.append({"seconds": seconds_of(call), "point": point.tolist(), "flag": flag})
    print()
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3])
