"""From the objects of a scene to the arrays of a model, with every check that needs the whole scene."""
