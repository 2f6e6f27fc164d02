"""What nodes may touch, a kind of feature a file: whether a node is over it, the gap, the rows and their biases.

To add one: its file here, its name and branches in :mod:`.feature`, and the surfaces that are made of it in
:mod:`lcpflex.compile.contact_surfaces`.
"""
