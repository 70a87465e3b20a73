"""What makes everything under meshes/ and all pictures, from parameters: `python -m scripts.generate_meshes`."""
