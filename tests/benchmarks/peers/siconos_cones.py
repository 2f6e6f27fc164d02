"""Siconos' solvers of frictional contact in space on stored problems, within bounds of iterations.

    /usr/bin/python3 siconos_cones.py FILE.npz ITERATIONS...

reads for each problem i its contacts by block rows (first_i, column_i, block_i: 3 x 3), q_i, mu_i and start_i, and
prints one line of JSON: for each method, bound and problem the CPU seconds of a call, the forces found and the flag.
The methods: Gauss-Seidel (NSGS) with its default local solver, with errors judged in passing; semismooth Newton by
Alart and Curnier (NSN_AC). Matrices are sparse by blocks, as Siconos' time stepping has them. Needs no lcpflex.
"""

import json
import os
import sys
import tempfile
import time

import numpy as np
import siconos.numerics as sn

TOLERANCE = 1e-9
NEWTON = (10, 100)  # bounds of Newton's method


def text_of(first, column, block, q, mu):
    """The problem as Siconos reads it."""
    n = len(mu)
    ends = " ".join(str(3 * (i + 1)) for i in range(n))
    lines = ["3", str(n), "1", f"{3 * n} {3 * n}", str(len(column)), str(n), str(n), ends, ends]
    lines += [str(n + 1), str(len(column)), " ".join(map(str, first)), " ".join(map(str, column))]
    for k, values in enumerate(block):
        lines += [str(k), " ".join(f"{v:.17g}" for v in values.ravel(order="F"))]
    lines += [" ".join(f"{v:.17g}" for v in q), " ".join(f"{v:.17g}" for v in mu)]
    return "\n".join(lines) + "\n"


def read(stored, i):
    """The problem i as an object of Siconos."""
    text = text_of(*(stored[f"{name}_{i}"] for name in ("first", "column", "block", "q", "mu")))
    with tempfile.NamedTemporaryFile("w", suffix=".dat", delete=False) as file:
        file.write(text)
    problem = sn.frictionContact_new_from_filename(file.name)
    os.unlink(file.name)
    return problem


def options_of(name, bound):
    """Options of a method that may iterate so often."""
    options = sn.SolverOptions(sn.SICONOS_FRICTION_3D_NSGS if name == "NSGS" else sn.SICONOS_FRICTION_3D_NSN_AC)
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = bound
    options.dparam[sn.SICONOS_DPARAM_TOL] = TOLERANCE
    if name == "NSGS":
        options.iparam[sn.SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] = (
            sn.SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_LIGHT
        )
    return options


def main(path, bounds):
    """All methods on all problems of the file."""
    found = []
    with np.load(path) as stored:
        count = sum(name.startswith("q_") for name in stored.files)
        problems = [(read(stored, i), stored[f"start_{i}"]) for i in range(count)]
    for name, bound in [("NSGS", b) for b in bounds] + [("NSN_AC", b) for b in NEWTON]:
        for i, (problem, start) in enumerate(problems):
            options, r, u = options_of(name, bound), start.copy(), np.zeros(len(start))
            began = time.process_time()
            flag = int(sn.fc3d_driver(problem, r, u, options))
            seconds = time.process_time() - began
            found.append({"method": name, "bound": bound, "problem": i, "seconds": seconds, "flag": flag})
            found[-1]["force"] = r.tolist()
    print()
    print(json.dumps(found))


if __name__ == "__main__":
    main(sys.argv[1], [int(bound) for bound in sys.argv[2:]])
