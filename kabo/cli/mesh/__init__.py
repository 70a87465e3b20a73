"""`kabo bound` and `kabo decompose`: meshes in, simpler meshes out, with what both have in common."""
