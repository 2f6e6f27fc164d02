"""Problems in files, families with known answers, and comparisons of solvers."""
