"""Modules shared by robot stages: paths of arms, motion constraints, targets, costs of motion."""
