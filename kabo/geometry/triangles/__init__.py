"""Triangle meshes as arrays: solids, crossings of faces, trees of triangles, convex hulls."""
