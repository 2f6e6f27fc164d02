"""Contact problems of many bodies, solved in the velocities of the bodies: time and memory linear in contacts.

    v = free + J x,   x = J^T p,   each contact under its law,   v = 0 in joint rows

x are the changes of the velocities of the bodies in coordinates in which the matrix of the step is the identity
(A = L L^T, J = W^T L^-T, u = u_free + L^-T x): no Delassus operator is formed, and nothing depends on the units of the
coordinates. Contacts and joint rows become units of a group (:mod:`solving`) over the operator
:class:`~lcpflex.solvers.contact.operators.bodies.Bodies`; who is tried when is said in
:mod:`lcpflex.solvers.contact.strategy`; :mod:`least` finds the least impulses of the same effect.
"""
