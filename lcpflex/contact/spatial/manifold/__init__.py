"""Contact of two convex bodies: one manifold a pair, which has no jump in how they lie.

A separating axis over faces picks one face of each body; the one is clipped exactly by the sides of the other, and each
corner of the patch becomes an entry by what made it: a vertex of the one over the face of the other, either way, or the
crossing of two edges. Where an edge of each is nearer than any face, their crossing is the only entry. Sources:
Gottschalk, Lin & Manocha 1996 (separating axes); Gregorius, The Separating Axis Test (2013); Sutherland & Hodgman 1974.
"""
