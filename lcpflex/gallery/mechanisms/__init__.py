"""The scenes of the gallery, by what they are made of.

To add a scene: its function here, its entry in :func:`lcpflex.gallery.scenes`, its check in :mod:`..acceptance`.
"""
