"""Checks the motions of a plan against the original meshes: limits, collisions, constraints, what is taken and let go."""
