"""Work against precision: runs by several methods against a reference, and what an accuracy costs."""
