"""`kabo serve` and `kabo request`: both ends of a server."""
