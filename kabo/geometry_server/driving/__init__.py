"""Robots whose base drives: the floor as something to collide with, and where the base may stand to reach a target."""
