"""Bounding meshes and bounding decompositions: convex parts that enclose a mesh, by less than epsilon [K ch. 4]."""
