"""URDF files as text: elements with their places, checks of all of them, xacro, and what C++ libraries say of them."""
