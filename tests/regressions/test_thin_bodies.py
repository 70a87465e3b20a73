"""A flat body of eight vertices whose inner mesh once came out inside out.

The last contraction moved a vertex through the one face that the star did not contain: nothing crossed, since the faces
share edges, and all distances held, but the surface that was left wound the other way, outside of the body.
"""

import numpy as np

from kabo.geometry import bounding_mesh
from kabo.meshes import Mesh

VERTICES = np.array(
    [
        [1.2266702234406546, 1.3744787706300035, -0.004322018289040635],
        [0.2572062919523208, 0.5415751800198795, -0.002718103271323178],
        [-0.20598285685278642, -0.591241268522443, -0.0014695802534369718],
        [0.09983791875120036, 0.35491221503810033, -0.011454593583920581],
        [-0.43402712972999297, 2.6083207475399206, -0.0008154565491338722],
        [-0.7397690834793035, 0.5040638214061032, -0.0021370486790810456],
        [1.0519290419987857, -0.059111584090754996, 0.0004380393332858408],
        [-0.5372024323331666, 0.5613082099690744, 0.009166077503631135],
    ]
)
FACES = np.array(
    [
        *([7, 4, 5], [2, 7, 5], [6, 7, 2], [5, 4, 3], [3, 2, 5], [6, 2, 3]),
        *([6, 3, 0], [0, 7, 6], [4, 7, 0], [1, 3, 4], [4, 0, 1], [1, 0, 3]),
    ]
)


def volume(vertices, faces):
    corners = vertices[faces]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def test_an_inner_mesh_of_a_thin_body_keeps_a_positive_volume():
    made = bounding_mesh(Mesh(VERTICES, FACES), 1.0, "inner")
    assert 0.0 < volume(made.vertices, made.faces) <= volume(VERTICES, FACES)
