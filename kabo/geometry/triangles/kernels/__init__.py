"""Kernels on arrays of triangles: trees, crossings, exact orientation."""
