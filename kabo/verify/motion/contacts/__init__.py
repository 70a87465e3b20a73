"""Checks the contacts that a plan's motions need: grasps, supports, mates, and the strokes to and from them."""
