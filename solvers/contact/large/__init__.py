"""Contact problems of many bodies, solved in the velocities of the bodies: time and memory linear in contacts.

    v = free + J x,   x = J^T p,   0 <= v_N _|_ p_N >= 0,   p_T in -mu p_N Sign(v_T),   v = 0 in joint rows

x are the changes of the velocities of the bodies in coordinates in which the matrix of the step is the identity
(A = L L^T, J = W^T L^-T, u = u_free + L^-T x): no Delassus operator is formed, and nothing depends on the units of the
coordinates. Contacts and joint rows are *units* of up to two rows, each measured by its own diagonal:

    D_k = max of the diagonal of J_k J_k^T,   q = p sqrt(D),   y = v / sqrt(D)

The parts, from the bottom: :mod:`memory` (structs), :mod:`packing` (rows to units), :mod:`judging` (residuals),
:mod:`sweeping` (Gauss-Seidel), :mod:`ordering` and :mod:`fronts` (sparse factor), :mod:`newton` (and the convex start),
:mod:`tracing` (paths), :mod:`solving` (who is tried when), :mod:`least` (least impulses of the same effect).
"""
