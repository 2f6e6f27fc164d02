"""Planar contact with Coulomb friction as a complementarity problem, in two forms: the kernels that lay them.

Contact velocities (or accelerations) are v = G lambda + free, rows ordered [normals; tangents of frictional contacts].

* Three unknowns a frictional contact, lambda_N, lambda_R = lambda_T + mu lambda_N, xi_L (Glocker & Studer 2005): small,
  but its matrix is not copositive: Lemke's path may end on a ray although a solution exists.
* Four unknowns, lambda_N, beta_+, beta_-, sigma (Stewart & Trinkle 1996; Anitescu & Potra 1997): copositive, so that a
  solution exists and Lemke finds it whenever q.v >= 0 for every v that solves the problem with q = 0.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["assemble_copositive_lcp", "assemble_friction_lcp", "from_copositive", "split_friction_solution"]


@kernel
def assemble_friction_lcp(
    G: FloatArray,
    free: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    M: FloatArray,
    q: FloatArray,
) -> int:
    """The LCP of planar Coulomb contact with three unknowns a frictional contact and one a frictionless contact.

    G (cap, cap): Delassus matrix, the leading block of order n_normal + n_tangent, normals first; free (cap,):
    velocity or acceleration of the contacts without contact forces; mu (>= n_normal,): friction coefficients [-];
    tangent (>= n_tangent,): row j of the tangents belongs to normal contact tangent[j]. Out: M (cap', cap') and
    q (cap',), of which the leading n = n_normal + 2 n_tangent are written; n is returned. Unknowns
    [lambda_N, lambda_R, xi_L] with lambda_R = lambda_T + mu lambda_N and the tangential velocity xi_R - xi_L
    (Glocker & Studer 2005).
    """
    n = n_normal + 2 * n_tangent
    m = n_normal + n_tangent
    for i in range(m):
        for j in range(m):
            M[i, j] = G[i, j]
        for k in range(n_tangent):
            j = tangent[k]
            M[i, j] -= G[i, n_normal + k] * mu[j]
            M[i, m + k] = 0.0
        q[i] = free[i]
    for k in range(n_tangent):
        for j in range(n):
            M[m + k, j] = 0.0
        M[n_normal + k, m + k] = 1.0
        M[m + k, n_normal + k] = -1.0
        M[m + k, tangent[k]] = 2.0 * mu[tangent[k]]
        q[m + k] = 0.0
    return n


@kernel
def assemble_copositive_lcp(
    M: FloatArray,
    q: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    M4: FloatArray,
    q4: FloatArray,
) -> int:
    """The four-unknown form from the three-unknown one, M and q of :func:`assemble_friction_lcp`.

    Out: M4 (cap'', cap''), q4 (cap'',), of which the leading n = n_normal + 3 n_tangent are written; n is returned.
    Unknowns [lambda_N, beta_+, beta_-, sigma] with lambda_T = beta_+ - beta_- (Stewart & Trinkle 1996).
    """
    m = n_normal + n_tangent
    n = n_normal + 3 * n_tangent
    for i in range(n):
        for j in range(n):
            M4[i, j] = 0.0
        q4[i] = 0.0
    for i in range(m):
        q4[i] = q[i]
        for j in range(m):
            M4[i, j] = M[i, j]
        for k in range(n_tangent):
            M4[i, tangent[k]] += M[i, n_normal + k] * mu[tangent[k]]
            M4[i, m + k] = -M[i, n_normal + k]
    for k in range(n_tangent):
        plus, minus, sigma = n_normal + k, m + k, m + n_tangent + k
        q4[minus] = -q4[plus]
        for j in range(m + n_tangent):
            M4[minus, j] = -M4[plus, j]
        M4[plus, sigma] = 1.0
        M4[minus, sigma] = 1.0
        M4[sigma, tangent[k]] = mu[tangent[k]]
        M4[sigma, plus] = -1.0
        M4[sigma, minus] = -1.0
    return n


@kernel
def from_copositive(
    z4: FloatArray,
    M: FloatArray,
    q: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    z: FloatArray,
) -> None:
    """z (cap',) of the three-unknown form M, q from a solution z4 of :func:`assemble_copositive_lcp`."""
    m = n_normal + n_tangent
    for i in range(n_normal):
        z[i] = z4[i]
    for k in range(n_tangent):
        z[n_normal + k] = max(z4[n_normal + k] - z4[m + k] + mu[tangent[k]] * z4[tangent[k]], 0.0)
        z[m + k] = 0.0
    for k in range(n_tangent):
        slip = q[n_normal + k]
        for j in range(m):
            slip += M[n_normal + k, j] * z[j]
        z[m + k] = max(-slip, 0.0)


@kernel
def split_friction_solution(
    z: FloatArray,
    mu: FloatArray,
    tangent: IntArray,
    n_normal: int,
    n_tangent: int,
    lambda_normal: FloatArray,
    lambda_tangent: FloatArray,
) -> None:
    """Contact forces (or impulses) from the unknowns of :func:`assemble_friction_lcp`.

    Out: lambda_normal (>= n_normal,) and lambda_tangent (>= n_tangent,) = lambda_R - mu lambda_N, kept inside
    the cone |lambda_T| <= mu lambda_N, which rounding may leave.
    """
    for i in range(n_normal):
        lambda_normal[i] = z[i]
    for k in range(n_tangent):
        bound = mu[tangent[k]] * z[tangent[k]]
        lambda_tangent[k] = min(max(z[n_normal + k] - bound, -bound), bound)
