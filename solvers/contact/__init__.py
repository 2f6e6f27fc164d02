"""Contact problems with Coulomb friction: their data and forms, and methods that work contact by contact.

:class:`.problem.ContactProblem` is what a user poses; :class:`.memory.ContactData` is the same inside compiled
steppers, solved by :func:`.compiled.solve_contacts`. To add a method that runs there: a file with its solver class and
its kernel, and an entry and a branch in :mod:`.methods`.
"""
