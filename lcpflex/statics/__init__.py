"""Where a scene rests: the path to a place of rest, the forces there, and what can be said of the place.

Forces and rows of a configuration (``balance``), how large they are in metres and newtons (``scales``), the path
(``path``) and its last steps (``refinement``), forces that are not unique (``shared_forces``), stability and
neighbouring places (``stability``), and what the user gets (``rest``, ``equilibrium``).
"""
