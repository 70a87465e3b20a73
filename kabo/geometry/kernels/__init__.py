"""Array kernels of the geometry room: numbers in, numbers out; no objects, no files, no errors."""
