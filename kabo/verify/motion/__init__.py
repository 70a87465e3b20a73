"""Checks the motions of a plan against the original meshes: limits, collisions, constraints, attachments of objects."""
