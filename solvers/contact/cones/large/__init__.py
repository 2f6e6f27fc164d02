"""Contact problems of many contacts in space, in the velocities of bodies: no Delassus operator is formed."""
