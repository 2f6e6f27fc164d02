"""Contact problems with Coulomb friction: their data and forms, and methods that work contact by contact."""
