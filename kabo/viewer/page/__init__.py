"""The one HTML file: its template, style and JavaScript modules, and the program that puts a document into them."""
