"""Contact problems with Coulomb friction: their data and forms, and methods that work contact by contact.

:class:`.problem.ContactProblem` is what a user poses; :class:`.memory.ContactData` is the same inside compiled
steppers, solved by :func:`.compiled.solve_contacts`, or by solvers in Python as :mod:`.posed` hands it to them. What
else is asked of one: :mod:`.least_forces`, :mod:`.several_motions`. Nobody but solvers reads the LCP in between.
"""
