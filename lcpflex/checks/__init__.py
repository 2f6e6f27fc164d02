"""What a finished run is checked for: steps, modes, meshes and laws that were not fine enough for what happened.

To add a check: a module with a function of the compiled scene and the result that returns clauses, called by
:mod:`lcpflex.runs.simulate`.
"""
