"""What a unit does: states that laws tell, and by which their derivatives are told apart."""

OPEN, STICKING = 0, 1  # without force; held: rows of joints, too
FORTH, BACK = 2, 3  # slides, in the plane with a friction force along the tangent or against it
SLIDING = FORTH  # slides, in space
EDGE_FORTH, EDGE_BACK = 4, 5  # on the edge of its cone, under the convex law
EDGE = EDGE_FORTH  # the same in space
LEAST = 6  # added to what it does along its tangents: its normal force is the least that it carries
