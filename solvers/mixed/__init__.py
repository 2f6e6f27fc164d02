"""Mixed and boxed complementarity problems, brought to the form of an LCP and back."""
