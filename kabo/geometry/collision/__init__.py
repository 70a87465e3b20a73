"""Bounded predicates on convex parts: collision, distance, inclusion and swept motion, one-sided by epsilon [K Def. 1]."""
