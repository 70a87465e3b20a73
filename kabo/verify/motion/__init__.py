"""Checks of a plan's motions: joint limits, collisions of original meshes, constraints, attachments."""
