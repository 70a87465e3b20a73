"""Array kernels of bounding meshes and decompositions: contraction, nearness, visibility."""
