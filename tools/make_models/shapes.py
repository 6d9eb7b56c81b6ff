"""Closed surfaces: revolved, extruded, swept along a path, lofted. All lengths in metres.

Edges are rounded and followed by a narrow strip, so that normals averaged at the vertices look
right: flat faces stay flat, and the light catches the edge.
"""

import numpy as np

from mesh import weld


def skin(rings, labels=None, loop=False):
    """The surface through `rings` (m, k, 3): closed polygons, counter-clockwise about the direction
    in which they follow each other. `labels` names the m - 1 strips between them. Ends that aren't
    a point are closed by a fan ("start", "end"); `loop` joins the last ring to the first."""
    rings = np.asarray(rings, float)
    if loop:
        rings = np.concatenate([rings, rings[:1]])
    m, k, _ = rings.shape
    labels = ["side"] * (m - 1) if labels is None else list(labels)
    points = [rings.reshape(-1, 3)]
    i, j = np.meshgrid(np.arange(m - 1), np.arange(k), indexing="ij")
    a, b = (i * k + j).ravel(), (i * k + (j + 1) % k).ravel()
    faces = [np.stack([a, b, b + k], 1), np.stack([a, b + k, a + k], 1)]
    names = [np.repeat(labels, k)] * 2
    if not loop:
        around, after = np.arange(k), (np.arange(k) + 1) % k
        last = (m - 1) * k
        points += [rings[0].mean(axis=0)[None], rings[-1].mean(axis=0)[None]]
        faces += [np.stack([np.full(k, m * k), after, around], 1),
                  np.stack([np.full(k, m * k + 1), last + around, last + after], 1)]
        names += [["start"] * k, ["end"] * k]
    return weld(np.concatenate(points), np.concatenate(faces), np.concatenate(names))


def spline(points, n):
    """n points on the Catmull-Rom curve through `points`, evenly spread over its pieces."""
    p = np.asarray(points, float)
    p = np.concatenate([[2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]])
    s = np.linspace(0, len(p) - 3, n)
    i = np.minimum(s.astype(int), len(p) - 4)
    t = (s - i)[:, None]
    a, b, c, d = p[i], p[i + 1], p[i + 2], p[i + 3]
    return 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2
                  + (3 * b - a - 3 * c + d) * t**3)


def _rounded_corner(before, at, after, radius):
    """The points that replace a polyline's corner, in order: half belong to the side before it."""
    u, v = before - at, after - at
    lu, lv = np.linalg.norm(u), np.linalg.norm(v)
    u, v = u / lu, v / lv
    if np.dot(u, v) < -0.82:  # a turn below 35 degrees: a curve, not a corner
        return [at, at]
    cut = min(radius / np.tan(np.arccos(np.clip(np.dot(u, v), -1, 1)) / 2), 0.3 * lu, 0.3 * lv)
    strip = 1.5 * cut
    start, end = at + cut * u, at + cut * v
    middle = 0.25 * start + 0.5 * at + 0.25 * end
    return [at + strip * u, start, middle, middle, end, at + strip * v]


def rounded(points, radius, labels=None, closed=False, step=None):
    """A polyline (n, 2) with its corners rounded and its sides cut to at most `step`; and the label
    of every side of the result, given those of the input's sides."""
    p = np.asarray(points, float)
    count = len(p) if closed else len(p) - 1
    labels = list(labels) if labels is not None else ["side"] * count
    ends = [_rounded_corner(p[i - 1], p[i], p[(i + 1) % len(p)], radius)
            if closed or 0 < i < len(p) - 1 else [p[i], p[i]] for i in range(len(p))]
    out, names = [], []
    for i in range(count):
        here, there = ends[i], ends[(i + 1) % len(p)]
        side = here[len(here) // 2:] + there[:len(there) // 2]
        for a, b in zip(side[:-1], side[1:]):
            pieces = max(1, int(np.ceil(np.linalg.norm(b - a) / step - 1e-9))) if step else 1
            out += [a + (b - a) * k / pieces for k in range(pieces)]
            names += [labels[i]] * pieces
    if not closed:
        out.append(p[-1])
    return np.array(out), names


def lathe(profile, radius=0.0015, n=48, step=0.02, shape=None):
    """Revolves a profile about z: a list of (r, z) or (r, z, label of the side that leads here),
    from the bottom's centre outwards, up, and back to the axis (or into the vessel). The seam is at
    +y. `shape(theta, r, z)` scales r, e.g. for ribs; theta runs counter-clockwise from +y."""
    labels = [point[2] if len(point) > 2 else "side" for point in profile[1:]]
    points, names = rounded([point[:2] for point in profile], radius, labels, step=step)
    theta = 2 * np.pi * np.arange(n) / n
    r, z = points[:, :1], np.repeat(points[:, 1:], n, axis=1)
    r = r * (shape(theta[None, :], r, z) if shape else np.ones((1, n)))
    return skin(np.stack([-r * np.sin(theta), r * np.cos(theta), z], axis=2), names)


def box(x, y, z, radius=0.002, cells=8):
    """A box with rounded edges on z = 0, centred in x and y. Sections: front (-y), back, left (-x),
    right, top, bottom."""
    half = np.array([x, y, z]) / 2
    faces = {"front": (0, 2, 1, -1), "back": (0, 2, 1, 1), "left": (1, 2, 0, -1),
             "right": (1, 2, 0, 1), "bottom": (0, 1, 2, -1), "top": (0, 1, 2, 1)}
    points, triangles, labels = [], [], []
    for name, (a, b, c, sign) in faces.items():
        ticks = [np.concatenate([[-h, -h + radius / 2], np.linspace(-h + radius, h - radius, cells),
                                 [h - radius / 2, h]]) for h in (half[a], half[b])]
        grid = np.zeros((len(ticks[0]), len(ticks[1]), 3))
        grid[..., a], grid[..., b] = ticks[0][:, None], ticks[1][None, :]
        grid[..., c] = sign * half[c]
        inner = np.clip(grid, -half + radius, half - radius)
        away = grid - inner
        grid = inner + radius * away / np.linalg.norm(away, axis=2, keepdims=True)
        m, k = grid.shape[:2]
        i, j = np.meshgrid(np.arange(m - 1), np.arange(k - 1), indexing="ij")
        q = sum(len(p) for p in points) + (i * k + j).ravel()
        quads = np.concatenate([np.stack([q, q + k, q + k + 1], 1),
                                np.stack([q, q + k + 1, q + 1], 1)])
        right_handed = (a, b, c) in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        triangles.append(quads if right_handed == (sign > 0) else quads[:, ::-1])
        points.append(grid.reshape(-1, 3))
        labels.append(np.full(len(quads), name))
    mesh = weld(np.concatenate(points), np.concatenate(triangles), np.concatenate(labels))
    return mesh.moved([0, 0, half[2]])


def _ears(polygon):
    """Triangles (indices) of a simple counter-clockwise polygon, by ear clipping."""
    def cross(o, a, b):
        return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])

    left, triangles = list(range(len(polygon))), []
    while len(left) > 3:
        best = None
        for k in range(len(left)):
            i, j, l = left[k - 1], left[k], left[(k + 1) % len(left)]
            a, b, c = polygon[i], polygon[j], polygon[l]
            if cross(a, b, c) <= 1e-12:
                continue
            others = [polygon[o] for o in left if o not in (i, j, l)]
            if any(min(cross(a, b, q), cross(b, c, q), cross(c, a, q)) >= 0 for q in others):
                continue
            longest = max(np.linalg.norm(b - a), np.linalg.norm(c - b), np.linalg.norm(a - c))
            quality = cross(a, b, c) / longest**2
            if best is None or quality > best[0]:
                best = (quality, k, (i, j, l))
        if best is None:
            raise ValueError("the polygon crosses itself or runs clockwise")
        triangles.append(best[2])
        del left[best[1]]
    return triangles + [tuple(left)]


def extrude(polygon, height, radius=0.002, labels=None, step=0.02, layers=4):
    """A counter-clockwise polygon (n, 2), corners rounded, drawn from z = 0 to `height`; its rims
    are rounded too. Sections: one a side of the polygon, "bottom" and "top"."""
    p, names = rounded(polygon, radius, labels, closed=True, step=step)
    ahead, behind = np.roll(p, -1, axis=0) - p, p - np.roll(p, 1, axis=0)
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    behind = behind / np.linalg.norm(behind, axis=1, keepdims=True)
    inward = np.stack([-(ahead + behind)[:, 1], (ahead + behind)[:, 0]], axis=1)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    levels = [(1.0, 0.0), (0.3, 0.3), (0.0, 1.0)]
    heights = ([(inset, rise * radius) for inset, rise in levels]
               + [(0.0, z) for z in np.linspace(2 * radius, height - 2 * radius, layers)]
               + [(inset, height - rise * radius) for inset, rise in levels[::-1]])
    k, m = len(p), len(heights)
    rings = [np.column_stack([p + inset * radius * inward, np.full(k, z)]) for inset, z in heights]
    i, j = np.meshgrid(np.arange(m - 1), np.arange(k), indexing="ij")
    a, b = (i * k + j).ravel(), (i * k + (j + 1) % k).ravel()
    ears = np.array(_ears(rings[0][:, :2]))
    faces = [np.stack([a, b, b + k], 1), np.stack([a, b + k, a + k], 1),
             ears[:, ::-1], ears + (m - 1) * k]
    around = np.tile(names, m - 1)
    tags = [around, around, ["bottom"] * len(ears), ["top"] * len(ears)]
    return weld(np.concatenate(rings), np.concatenate(faces), np.concatenate(tags))


def tube(path, radius, n=12, loop=False, squash=1.0):
    """A tube along `path` (m, 3). `radius` is a number or one a point; the cross-section is
    `squash` times as wide across the path's plane as in it. Open ends are domed; the domes
    are the sections "start" and "end"."""
    p = np.asarray(path, float)
    r = np.broadcast_to(np.asarray(radius, float), len(p)).copy()
    along = np.roll(p, -1, axis=0) - np.roll(p, 1, axis=0) if loop else np.gradient(p, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.linalg.svd(p - p.mean(axis=0))[2][2]  # normal of the plane that fits the path best
    if np.ptp(np.cross(along, along[0]), axis=0).max() < 1e-6:  # straight: any direction will do
        across = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    if not loop:
        dome = np.array([0.0, 0.55, 0.85])
        rise = 0.5 * np.sqrt(1 - dome**2)
        p = np.concatenate([p[0] - along[0] * (rise * r[0])[:, None], p,
                            (p[-1] + along[-1] * (rise * r[-1])[:, None])[::-1]])
        along = np.concatenate([[along[0]] * 3, along, [along[-1]] * 3])
        r = np.concatenate([dome * r[0], r, (dome * r[-1])[::-1]])
    side = across - along * (along @ across)[:, None]
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(along, side)
    phi = 2 * np.pi * np.arange(n) / n
    rings = (p[:, None] + r[:, None, None]
             * (squash * np.cos(phi)[None, :, None] * side[:, None]
                + np.sin(phi)[None, :, None] * up[:, None]))
    strips = len(p) - 1
    return skin(rings, None if loop else ["start"] * 3 + ["side"] * (strips - 6) + ["end"] * 3,
                loop)


def rod(start, end, radius, n=16):
    """A straight cylinder with slightly rounded ends."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    t = np.linspace(0, 1, 4)[:, None]
    return tube(start + (end - start) * t, radius, n)


def arc(center, radius, start_deg, end_deg, n=24, plane="xz"):
    """n points on a circle in the plane of two axes, from `start_deg` to `end_deg`."""
    a = np.radians(np.linspace(start_deg, end_deg, n))
    points = np.tile(np.asarray(center, float), (n, 1))
    points[:, "xyz".index(plane[0])] += radius * np.cos(a)
    points[:, "xyz".index(plane[1])] += radius * np.sin(a)
    return points


def ellipsoid(center, radii, n=32, m=20):
    """An ellipsoid with its poles on z."""
    t = np.linspace(-np.pi / 2, np.pi / 2, m)
    phi = 2 * np.pi * np.arange(n) / n
    unit = np.stack([np.cos(t)[:, None] * -np.sin(phi), np.cos(t)[:, None] * np.cos(phi),
                     np.repeat(np.sin(t)[:, None], n, axis=1)], axis=2)
    return skin(unit * np.asarray(radii, float)).moved(center)


def loft(sections, n=32, power=2.0):
    """A surface through upright super-ellipses: rows (x, y, z of the centre, half x, half y),
    bottom first, joined by a smooth curve; ends rounded off. `power` above 2 makes them squarer."""
    rows = spline(sections, 6 * len(sections))
    phi = 2 * np.pi * np.arange(n) / n
    c, s = np.cos(phi), np.sin(phi)
    c, s = np.sign(c) * np.abs(c)**(2 / power), np.sign(s) * np.abs(s)**(2 / power)
    shrink, rise = np.array([1, 1, 1, 0.93, 0.93]), np.array([0, 0, 0.0015, 0, 0])
    rows = np.concatenate([[rows[0] * shrink - rise], rows, [rows[-1] * shrink + rise]])
    return skin([np.stack([x + hx * c, y + hy * s, np.full(n, z)], axis=1)
                 for x, y, z, hx, hy in rows])
