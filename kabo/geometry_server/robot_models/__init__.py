"""Robots that somebody else described: what is wrong with their files, and what kabo needs to know beside them.

Findings for `kabo check`; and for `kabo robot` the pairs of links that always touch, a free home, groups of joints, the
gripper, and the text of a scene with all of it.
"""
