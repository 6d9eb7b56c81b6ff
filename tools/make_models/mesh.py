"""A triangle mesh with texture coordinates per face corner, and what must hold for one."""

from dataclasses import dataclass

import numpy as np

DECIMALS = 5  # of a written coordinate [m]; vertices that round alike are one vertex


@dataclass
class Mesh:
    """vertices (n, 3) [m]; faces (t, 3) indices, counter-clockwise seen from outside; labels (t,)
    names of surface sections, which only painting looks at; uv (t, 3, 2) atlas coordinates with v
    upwards, NaN until painted."""

    vertices: np.ndarray
    faces: np.ndarray
    labels: np.ndarray
    uv: np.ndarray

    def moved(self, by):
        return Mesh(self.vertices + np.asarray(by, float), self.faces, self.labels, self.uv)

    def turned(self, axis, degrees):
        """Rotated about the origin's "x", "y" or "z" axis, right-handed."""
        return Mesh(self.vertices @ rotation(axis, degrees).T, self.faces, self.labels, self.uv)

    def corners(self):
        """The positions of the triangles' corners, (t, 3, 3)."""
        return self.vertices[self.faces]

    def normals(self):
        """The triangles' normals, their length twice the area, (t, 3)."""
        a, b, c = self.corners().transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def volume(self):
        a, b, c = self.corners().transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def rotation(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def weld(vertices, faces, labels):
    """A mesh in which points that round alike are one vertex; triangles that vanish are dropped."""
    _, first, index = np.unique(
        np.round(vertices, DECIMALS), axis=0, return_index=True, return_inverse=True)
    faces = index.reshape(-1)[faces]
    keep = ((faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
            & (faces[:, 2] != faces[:, 0]))
    faces = faces[keep]
    return Mesh(vertices[first], faces, np.asarray(labels)[keep],
                np.full((len(faces), 3, 2), np.nan))


def join(parts):
    """One mesh of several closed parts. The parts may overlap; they share no vertices."""
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return Mesh(np.concatenate([part.vertices for part in parts]),
                np.concatenate([part.faces + offset for part, offset in zip(parts, offsets)]),
                np.concatenate([part.labels for part in parts]),
                np.concatenate([part.uv for part in parts]))


def turned(parts, axis, degrees):
    """All parts rotated about the origin's axis."""
    return [part.turned(axis, degrees) for part in parts]


def grounded(parts):
    """All parts moved alike so that the lowest point has z = 0 and the footprint is centred."""
    points = np.concatenate([part.vertices for part in parts])
    low, high = points.min(axis=0), points.max(axis=0)
    by = [-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]]
    return [part.moved(by) for part in parts]


def validate(name, parts):
    """Raises ValueError naming the first part of object `name` that is not a painted solid."""
    for number, part in enumerate(parts):
        where = f"{name}, part {number} ({part.labels[0]})"
        if not np.isfinite(part.vertices).all():
            raise ValueError(f"{where}: a vertex is not finite")
        edges = part.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        directed = {(int(a), int(b)) for a, b in edges}
        if len(directed) != len(edges):
            raise ValueError(f"{where}: an edge is used twice in the same direction")
        open_edges = [edge for edge in directed if edge[::-1] not in directed]
        if open_edges:
            a, b = part.vertices[list(min(open_edges))]
            raise ValueError(f"{where}: {len(open_edges)} open edges, one from {a} to {b}")
        if part.volume() <= 0:
            raise ValueError(f"{where}: volume {part.volume():.3g} m^3; the surface is inside out")
        if not ((part.uv >= 0) & (part.uv <= 1)).all():
            bad = part.labels[~((part.uv >= 0) & (part.uv <= 1)).all(axis=(1, 2))]
            raise ValueError(f"{where}: no texture coordinates in [0, 1] for sections "
                             f"{', '.join(sorted(set(bad)))}")
    whole = join(parts)
    extent = whole.vertices.max(axis=0) - whole.vertices.min(axis=0)
    if extent.min() < 0.03 or extent.max() > 0.40:
        raise ValueError(f"{name}: extent {extent} m; 0.03 to 0.40 m expected")
    if abs(whole.vertices[:, 2].min()) > 1e-6:
        raise ValueError(f"{name}: lowest point at z = {whole.vertices[:, 2].min()} m, not on 0")
    if not 1000 <= len(whole.faces) <= 8000:
        raise ValueError(f"{name}: {len(whole.faces)} triangles; 1000 to 8000 expected")
