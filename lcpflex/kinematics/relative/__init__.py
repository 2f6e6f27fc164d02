"""Relative coordinates of two material points P and Q: what joints prescribe, and what springs resist.

A file a kind: its value, and its gradient and bias. To add one: its file here, and its name and two branches in
:mod:`.coordinate`; from then on joints and springs can name it.
"""
