"""Scene files: robots, bodies, features, poses, and the constraints between them, as data with places."""
