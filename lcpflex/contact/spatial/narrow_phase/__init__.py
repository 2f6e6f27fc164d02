"""What touches in space: the sides of an entry, and how the feature of each kind of pair turns, a kind a file.

Of every kind, with the places v_rel is measured at frozen in the material of both sides,

    gdot_d = d.v_rel,   w_d = ddot.v_rel + d.b_rel   for d = n, t1, t2,

where b_rel is the rate of v_rel at udot = 0. What differs is how the foot slides and the normal turns.
"""
