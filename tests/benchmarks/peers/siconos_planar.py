"""Siconos' Gauss-Seidel for planar friction on its own files.

    /usr/bin/python3 siconos_planar.py TOLERANCE SWEEPS FILE.dat ...

prints one line of JSON: for each file the seconds of a call (least of five loops, one where a call takes a second), the
flag (0 where its own error is within the tolerance) and the impulses, normal and tangent of each contact in turn. Files
must hold their matrix in blocks. Needs no lcpflex.
"""

import json
import sys
import time

import numpy as np
import siconos.numerics as sn


def solved(path, tolerance, sweeps):
    """What one file takes."""
    problem = sn.frictionContact_new_from_filename(path)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = sweeps
    r, u = np.zeros(2 * problem.numberOfContacts), np.zeros(2 * problem.numberOfContacts)

    def call():
        r[:] = 0.0
        u[:] = 0.0
        return sn.fc2d_driver(problem, r, u, options)

    began = time.perf_counter()
    flag = int(call())
    once = time.perf_counter() - began
    least = once
    repeats = max(1, int(2e-3 / max(once, 1e-7)))
    for _ in range(0 if once > 1.0 else 5):
        began = time.perf_counter()
        for _ in range(repeats):
            call()
        least = min(least, (time.perf_counter() - began) / repeats)
    return {"seconds": least, "flag": flag, "point": r.tolist()}


if __name__ == "__main__":
    results = [solved(path, float(sys.argv[1]), int(sys.argv[2])) for path in sys.argv[3:]]
    print()
    print(json.dumps(results))
