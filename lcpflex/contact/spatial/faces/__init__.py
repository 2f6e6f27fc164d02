"""Open faces of solids, by the shape functions of their elements: nodes and areas of one on faces of the other."""
