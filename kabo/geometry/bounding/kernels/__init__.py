"""Kernels on arrays for bounding meshes: contraction, nearness, visibility."""
