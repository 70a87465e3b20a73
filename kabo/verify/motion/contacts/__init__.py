"""Checks the contacts of a plan's motions: grasps, supports, mates, and the strokes to and from them."""
