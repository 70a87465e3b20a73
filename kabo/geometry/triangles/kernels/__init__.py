"""Array kernels of triangles: trees, crossings, exact orientation."""
