"""Whether steps of fixed length were short enough for the dampers of a run, and for the damping of its modes.

A step answers a velocity u by -h A^-1 C u, with A = M + theta h C_d + (theta h)^2 K (C_d: the part of C that the scheme
takes implicitly, the diagonal one of the modes). Where an eigenvalue x of h A^-1 C is above one, what damping takes
away in a step is more than there was: the velocity changes its sign with each step, decays by 1 - x instead of
exp(-h c / m), and grows beyond two. Forces and reactions, which are differences of velocities, ring with it. It counts
where all such velocities, as far as dampers resist them, change together by more than a hundredth of the largest speed,
measured by kinetic energies: a light body that its damper takes along has none. Where nothing moves, they are measured
by what forces do in a step.
"""

from __future__ import annotations

import numpy as np

from lcpflex.basics import libs
from lcpflex.checks.grown import has_grown
from lcpflex.checks.loads_in_time import place_name, resisted
from lcpflex.checks.run_scales import masses_and_joints
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.mass_matrix import elastic_matrices, held_inverse
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.results.energy_balance import held_energy
from lcpflex.results.result import Result

__all__ = ["ringing_dampers"]

TURNS = 1.0  # eigenvalue beyond which a damped velocity changes its sign from step to step
MATTERS = 0.01  # of the largest speed, speeds measured by kinetic energies
WEAK = 0.3  # share of the velocity of a mode that its damping takes in a step: what is less does not ring
HALVINGS = 40  # of a step, until one is short enough


def ringing_dampers(result: Result, step: float, stepper: object) -> tuple[str, ...]:
    """A warning where dampers are too strong for steps of ``step`` [s] of ``stepper``.

    None of generalised-alpha, whose steps solve for the forces of dampers, and say where they could not.
    """
    compiled, theta = result.compiled, _weight(stepper)
    if theta is None or compiled is None or len(result.times) < 2 or has_grown(result):
        return ()
    if not _strong(compiled, step):
        return ()
    for q in (result.q[0], result.q[-1]):  # a damper whose ends meet has no direction there
        if found := _ringing_at(result, _Damping(compiled, theta, q), step):
            return (found,)
    return ()


def _ringing_at(result: Result, damping: _Damping, step: float) -> str:
    """The warning of what rings by the damping at one place, where that matters in all of the run."""
    strengths, velocities = damping.ringing(step)
    if not strengths.size:
        return ""
    changes = np.linalg.norm(np.ptp(damping.damped(result.u, velocities), axis=0))
    if not changes > MATTERS * max(np.sqrt(2.0 * result.energies.kinetic.max()), _taken(result, step)):
        return ""
    shorter = step
    for _ in range(HALVINGS):
        shorter *= 0.5
        if not damping.ringing(shorter)[0].size:
            break
    name, of_modes = damping.named(velocities[:, -1])
    damped = "; theta=1 lets it die out" if of_modes and 0.0 < damping.theta < 1.0 else ""
    return (
        f"{name} takes {strengths[-1]:.3g} times the velocity that there is out of it in a "
        f"step of {step:.3g} s: it changes its sign from step to step, and forces and reactions with it: a step of "
        f"{shorter:.2g} s would follow it{damped}"
    )


def _taken(result: Result, step: float) -> float:
    """What loads and contacts do to the lightest body in a step, by its kinetic energy y^2 / 2: the unit at rest."""
    compiled = result.compiled
    assert compiled is not None
    force = held_energy(compiled, result.times, result.impulse) / compiled.size
    return float(step * force / np.sqrt(compiled.model.bodies.mass.min()))


def _weight(stepper: object) -> float | None:
    """Weight of the end of a step in what ``stepper`` takes implicitly; None where it solves for dampers, too."""
    named: float | None = getattr(stepper, "theta", None)
    return {"MasslessBoundary": 0.5, "Smooth": 0.0}.get(type(stepper).__name__) if named is None else named


def _strong(compiled: CompiledScene, step: float) -> bool:
    """Whether it is worth to look: there are dampers, or modes that lose a good part of their speed in a step."""
    model = compiled.model
    lost = step * float(model.bodies.damping.max(initial=0.0))
    return lost > WEAK or bool((model.loads.spring_value[:, 1] > 0.0).any()) or model.bodies.cross_damping.size > 0


class _Damping:
    """All damping of a scene at q: C = columns columns^T."""

    def __init__(self, compiled: CompiledScene, theta: float, q: FloatArray) -> None:
        model = compiled.model
        self._compiled, self.theta = compiled, theta
        self.M, self._J = masses_and_joints(compiled, q)
        self._K, C = elastic_matrices(model, q)
        self._C_d = np.diag(np.diag(C))
        self._dampers = [k for k, c in enumerate(model.loads.spring_value[:, 1]) if c > 0.0]
        self.columns = np.hstack([_factor(C), *(self._column(k, q) for k in self._dampers)])

    def _column(self, k: int, q: FloatArray) -> FloatArray:
        row = resisted(pack(self._compiled.model), q, k)
        return np.asarray(np.sqrt(float(self._compiled.model.loads.spring_value[k, 1])) * row[:, None])

    def ringing(self, step: float) -> tuple[FloatArray, FloatArray]:
        """Eigenvalues of h A^-1 C above one while joints hold, the largest last, and their velocities (ndof, r)."""
        lean = self.theta * step
        H = held_inverse(self.M + lean * self._C_d + lean * lean * self._K, self._J)
        answers = H @ self.columns
        values, vectors = np.linalg.eigh(step * self.columns.T @ answers)
        rings = values > TURNS
        return values[rings], answers @ vectors[:, rings]

    def damped(self, u: FloatArray, velocities: FloatArray) -> FloatArray:
        """(m, r) the part of u (m, ndof) along ``velocities`` (ndof, r) that dampers resist, of kinetic energy y^2 / 2.

        What carries a body along with its damper is none. The velocities are orthogonal in C, and their r coordinates
        V^T C u / V^T C V, by those of an orthonormal base of the masses.
        """
        resisted_by = self.columns.T @ velocities
        shares = (u @ self.columns) @ (resisted_by / (resisted_by**2).sum(axis=0))
        base = np.linalg.qr(np.linalg.cholesky(self.M).T @ velocities)[1]
        return np.asarray(shares @ base.T)

    def named(self, velocity: FloatArray) -> tuple[str, bool]:
        """The damper that takes most power out of ``velocity``, or the body whose modes do, and whether it is that."""
        powers = (self.columns.T @ velocity) ** 2
        first = len(powers) - len(self._dampers)
        if powers[first:].sum() > 0.5 * powers.sum():
            k = self._dampers[int(powers[first:].argmax())]
            P, Q = self._compiled.model.loads.spring_point[k].tolist()
            return f"the damper between {place_name(self._compiled, P)} and {place_name(self._compiled, Q)}", False
        modes = np.abs(self._C_d @ velocity)
        body = int(np.searchsorted(self._compiled.model.bodies.dof, int(modes.argmax()), side="right")) - 1
        return f"the damping of the modes of {self._compiled.layout.bodies[body]}", True


def _factor(C: FloatArray) -> FloatArray:
    """(ndof, r) B with B B^T = C, of the rows that are damped."""
    rows = np.flatnonzero(np.abs(C).sum(axis=1))
    values, vectors = libs.linalg.eigh(C[np.ix_(rows, rows)])
    B = np.zeros((len(C), len(rows)))
    B[rows] = vectors * np.sqrt(np.maximum(values, 0.0))
    return B
