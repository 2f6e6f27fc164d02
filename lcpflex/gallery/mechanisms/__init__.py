"""The scenes of the gallery, by what they are made of.

To add a scene: its function here, its case in ``cases`` there, its name in :mod:`..collection`,
its check in :mod:`..acceptance`.
"""
