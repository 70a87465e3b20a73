"""Preparation: the convex parts of all links and bodies of a scene, made before planning starts, in parallel, and told.

Parts are made in processes that can be killed; what is done stays in kabo's cache, so that a run which was cut off
goes on from there. Parts that nobody prepared are still made when they are first used.
"""
