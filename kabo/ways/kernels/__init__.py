"""Array kernels of the search for ways: edges, trees, shortcuts, and the search that calls them."""
