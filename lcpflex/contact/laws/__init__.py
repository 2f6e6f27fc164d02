"""Continuous contact-force laws: elastic, dissipative and friction laws, and what a contact under them remembers."""
