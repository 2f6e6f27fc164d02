"""Says when a body is made of a mesh that is too stiff, and how much: by its lowest modes.

The error of stiffness is that of omega^2, the largest of the three lowest elastic modes; those of a slender body are
bending. Elements that lock in bending (a linear field cannot bend without shear) or in change of volume show there.
"""

from __future__ import annotations

import warnings
from weakref import WeakKeyDictionary

import numpy as np

from lcpflex.basics.stack import outside
from lcpflex.bodies.fem.finite_elements import FiniteElements
from lcpflex.bodies.reduction.eigenmodes import FreeMesh, ritz
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray

__all__ = ["TOLERATED", "stiffness_error", "warn_if_too_stiff"]

MODES = 3  # lowest ones, that are judged
TOLERATED = 0.1  # of stiffness, 0.05 of a frequency
PURE = 1e-3  # of its stiffness, the residual of what is taken for a mode: 1e-4 with 20 fixed modes, .1 of static shapes


_judged: WeakKeyDictionary[FiniteElements, tuple[FloatArray, FloatArray]] = WeakKeyDictionary()  # omega2, excess


def warn_if_too_stiff(mesh: FiniteElements, shapes: FloatArray) -> None:
    """Warn of a mesh whose lowest modes are too stiff by more than ``TOLERATED``, as far as its elements are known.

    Parameters
    ----------
    mesh : the mesh, not prestressed
    shapes : (f, n) the basis of the body, in ascending order of its frequencies
    """
    count = min(MODES, shapes.shape[1])
    if mesh.excess is None or not count:
        return
    values, vectors = ritz(mesh.stiffness, mesh.mass, shapes[:, :count])  # of a prestressed basis without the stress
    if not _are_modes(mesh, vectors):  # but static shapes
        values, vectors = FreeMesh.of(mesh).modes(count)
    if mesh not in _judged or not np.array_equal(_judged[mesh][0], values):
        _judged[mesh] = values, mesh.excess(values, vectors)
    excess = _judged[mesh][1]
    worst = int(excess.argmax())
    if excess[worst] <= TOLERATED:
        return
    times = int(np.ceil(np.sqrt(excess[worst] / TOLERATED)))  # of linear elements; it falls with their size squared
    quadratic = "quadratic elements" if mesh.dimension == 3 else "quadratic elements, lcpflex.meshes.quadratic(mesh)"
    warnings.warn(
        f"mesh: its stiffness in bending or change of volume is about {100.0 * excess[worst]:.0f} % too high (elastic "
        f"mode {worst + 1}, {np.sqrt(values[worst]) / (2.0 * np.pi):.4g} Hz), because its elements are too large or "
        f"lock, expected at most {100.0 * TOLERATED:.0f} %: {quadratic}, or such "
        f"ones {times} times smaller",
        ModelWarning,
        stacklevel=outside(),
    )


def stiffness_error(mesh: FiniteElements) -> float:
    """Largest omega^2 / omega_f^2 - 1 [-] of the three lowest elastic modes, omega_f: those of the next finer mesh.

    Raises
    ------
    ModelError
        For a mesh whose elements are not known, or too large a finer one.
    """
    if mesh.finer is None:
        raise ModelError("model: a mesh without elements was given, expected a Continuum, SolidOfRevolution or Solid")
    count = min(MODES, len(mesh.dofs) - mesh.rigid.shape[1])
    own, reference = (FreeMesh.of(one).modes(count)[0] for one in (mesh, mesh.finer()))
    return float((own / reference).max() - 1.0)


def _are_modes(mesh: FiniteElements, vectors: FloatArray) -> bool:
    """Whether K v - omega^2 M v is small, in the norm of the diagonal of K."""
    stiff, heavy = mesh.stiffness @ vectors, mesh.mass @ vectors
    energy = (vectors * stiff).sum(axis=0)
    left = stiff - energy / (vectors * heavy).sum(axis=0) * heavy
    return bool(((left**2 / mesh.stiffness.diagonal()[:, None]).sum(axis=0) <= PURE * energy).all())
