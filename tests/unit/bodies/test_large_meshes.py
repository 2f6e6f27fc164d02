"""Meshes of 1e5 nodes: their reductions fit in 4 GiB, as whole commands, and are right."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

GIB = 2.0**30
JOB = """
import json, sys
from pathlib import Path
import numpy as np
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.reduction.component_modes import craig_bampton, free_interface, residual_compliance

rectangle = Continuum(meshes.rectangle(2.0, 1.0, 446, 223, order=1), 7800.0, 2e11, 0.3)
mesh = rectangle.finite_elements()
contact = mesh.sets["left"][:100]
if sys.argv[1] == "free_interface":
    body = free_interface(rectangle, 20)
elif sys.argv[1] == "craig_bampton":
    body = craig_bampton(rectangle, contact, 20)
else:
    body = residual_compliance(rectangle, contact, 20)
# that of ``resource`` begins with what the process had that started this one
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
memory = 1024.0 * float(status["VmHWM"].split()[0])
x, y = mesh.places[contact[50]]
phi = body.locate(float(x), float(y)).phi
print(json.dumps({
    "nodes": len(mesh.places),
    "modes": body.modes,
    "memory": memory,
    "frequencies": body.frequencies()[:4].tolist(),
    "compliance": float(phi[:, 0] @ (phi[:, 0] / body.stiffness)),
}))
"""


@pytest.mark.slow
def test_memory_and_frequencies_of_1e5_nodes() -> None:
    found = {}
    for name in ("free_interface", "craig_bampton", "residual_compliance"):
        shown = subprocess.run([sys.executable, "-c", JOB, name], capture_output=True, text=True, check=True).stdout
        found[name] = json.loads(shown)
        print(name, found[name])
        assert found[name]["nodes"] == 447 * 224
        assert found[name]["memory"] < 4.0 * GIB
    free, held, residual = found.values()
    assert [body["modes"] for body in found.values()] == [20, 200 + 20 - 3, 20 + 200]
    coarse = coarse_frequencies()
    assert free["frequencies"] == pytest.approx(coarse, rel=2e-3)
    assert residual["frequencies"] == pytest.approx(free["frequencies"], rel=1e-12)
    above = [one / other for one, other in zip(held["frequencies"], free["frequencies"], strict=True)]
    assert all(1.0 < ratio < 1.002 for ratio in above)
    assert held["compliance"] == pytest.approx(residual["compliance"], rel=2e-2)  # the former without some inertia
    assert free["compliance"] < 0.9 * residual["compliance"]


def coarse_frequencies() -> list[float]:
    from lcpflex.bodies.continuum import Continuum
    from lcpflex.bodies.fem import meshes
    from lcpflex.bodies.reduction.component_modes import free_interface

    mesh = meshes.rectangle(2.0, 1.0, 20, 10)
    return free_interface(Continuum(mesh, 7800.0, 2e11, 0.3), 4).frequencies().tolist()
