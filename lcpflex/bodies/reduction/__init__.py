"""From a mesh to few coordinates: eigenmodes, component modes, interfaces, damping, geometric stiffening.

To add a reduction: its basis in :mod:`.bases`, its public function in :mod:`.component_modes`.
"""
