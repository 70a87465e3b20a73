"""What a page or a picture shows, as the view document `kabo-view/1`: plain data and arrays, no HTML."""
