"""From the objects of a spatial scene to the arrays of a model."""
