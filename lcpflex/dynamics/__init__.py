"""Mechanics at a state: inertia, forces, Delassus operators, and contact problems at three levels.

The levels are acceleration (:mod:`.acceleration`), impulse (:mod:`.impulse`) and position (:mod:`.position`). To add a
law of impact: :mod:`.impact_laws`, and no other file.
"""
