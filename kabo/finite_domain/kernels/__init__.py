"""Array kernels of the finite-domain room: numbers in, numbers out; no objects, no files, no errors."""
