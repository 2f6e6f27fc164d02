"""The ground floor: checked arguments, options of frozen values, files written whole, wall time.

It knows no mechanics. To add a check of an argument that several rooms need: :mod:`lcpflex.basics.arguments`.
"""
