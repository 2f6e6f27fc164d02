"""The right size of a model: how many modes and elements an answer needs."""
