"""Prints: flat pictures painted with Pillow, and the atlas that packs those of an object."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

OVERSAMPLING = 4  # prints are painted larger and averaged down, which smooths their edges


class Print:
    """A picture of `width` x `height` pixels (one pixel a millimetre on most objects). Coordinates
    are pixels from the top left corner."""

    def __init__(self, width, height, color):
        self.width, self.height = int(round(width)), int(round(height))
        self.image = Image.new("RGB", (self.width * OVERSAMPLING, self.height * OVERSAMPLING),
                               color)
        self.draw = ImageDraw.Draw(self.image)

    def _scaled(self, values):
        return [float(value) * OVERSAMPLING for value in np.ravel(values)]

    def rect(self, x0, y0, x1, y1, color):
        x0, y0, x1, y1 = self._scaled([x0, y0, x1, y1])
        self.draw.rectangle([x0, y0, x1 - 1, y1 - 1], fill=color)
        return self

    def disc(self, x, y, radius, color, radius_y=None):
        ry = radius if radius_y is None else radius_y
        self.draw.ellipse(self._scaled([x - radius, y - ry, x + radius, y + ry]), fill=color)
        return self

    def ring(self, x, y, radius, width, color):
        self.draw.ellipse(self._scaled([x - radius, y - radius, x + radius, y + radius]),
                          outline=color, width=int(width * OVERSAMPLING))
        return self

    def poly(self, points, color):
        self.draw.polygon(self._scaled(points), fill=color)
        return self

    def line(self, points, width, color):
        self.draw.line(self._scaled(points), fill=color, width=int(width * OVERSAMPLING),
                       joint="curve")
        return self

    def star(self, x, y, radius, color, points=5, inner=0.45, turn=0.0):
        angle = np.pi * np.arange(2 * points) / points - np.pi / 2 + turn
        r = np.where(np.arange(2 * points) % 2 == 0, radius, inner * radius)
        return self.poly(np.stack([x + r * np.cos(angle), y + r * np.sin(angle)], 1), color)

    def leaf(self, x, y, length, width, degrees, color):
        t = np.linspace(0, 2 * np.pi, 40)
        along, across = length / 2 * np.cos(t), width / 2 * np.sin(t) * np.sin(t / 2)**0.7
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        return self.poly(np.stack([x + c * along - s * across, y + s * along + c * across], 1),
                         color)

    def text(self, x, y, text, size, color, turn=0):
        """Bold lettering centred at (x, y), turned by `turn` degrees (a multiple of 90,
        counter-clockwise)."""
        font = ImageFont.load_default(size * OVERSAMPLING)
        stroke = max(1, size * OVERSAMPLING // 22)
        left, top, right, bottom = font.getbbox(text, stroke_width=stroke)
        mask = Image.new("L", (int(right - left) + 2, int(bottom - top) + 2), 0)
        ImageDraw.Draw(mask).text((1 - left, 1 - top), text, 255, font, stroke_width=stroke)
        mask = mask.rotate(turn, expand=True)
        corner = (int(x * OVERSAMPLING - mask.width / 2), int(y * OVERSAMPLING - mask.height / 2))
        self.image.paste(Image.new("RGB", mask.size, color), corner, mask)
        return self

    def lines_of_text(self, x, y, width, rows, color, pitch=6, weight=2):
        """Bars that look like small print from afar; no two rows are equally long."""
        for row in range(rows):
            length = width * (0.55 + 0.45 * ((row * 37 + 11) % 17) / 16)
            self.rect(x, y + row * pitch, x + length, y + row * pitch + weight, color)
        return self

    def bar_code(self, x, y, width, height):
        self.rect(x, y, x + width, y + height, (255, 255, 255))
        for bar in range(int(width) // 3 - 2):
            if (bar * 29 + 7) % 5 < 3:
                left = x + 3 + 3 * bar
                self.rect(left, y + 3, left + 1 + bar % 2, y + height - 3, (0, 0, 0))
        return self

    def reduced(self):
        return self.image.reduce(OVERSAMPLING)


class Atlas:
    """Packs prints into one square texture in rows; each gets a border of its own edge colours, so
    that filtering doesn't mix neighbours."""

    MARGIN = 2

    def __init__(self, size=512):
        self.size = size
        self.image = Image.new("RGB", (size, size), (128, 128, 128))
        self.x = self.y = self.row = 0
        self.swatches = {}

    def add(self, print_):
        """Places a print; returns its rectangle (x0, y0, x1, y1) in pixels from the top left."""
        picture, m = print_.reduced(), self.MARGIN
        padded = Image.fromarray(np.pad(np.asarray(picture), ((m, m), (m, m), (0, 0)), mode="edge"))
        if self.x + padded.width > self.size:
            self.x, self.y, self.row = 0, self.y + self.row, 0
        if self.y + padded.height > self.size or padded.width > self.size:
            raise ValueError(f"a print of {picture.size} px does not fit into what is left of the "
                             f"{self.size} px atlas; at x = {self.x}, y = {self.y}")
        self.image.paste(padded, (self.x, self.y))
        corner = (self.x + m, self.y + m)
        self.x, self.row = self.x + padded.width, max(self.row, padded.height)
        return (*corner, corner[0] + picture.width, corner[1] + picture.height)

    def swatch(self, color):
        """The rectangle of a small plain patch of `color`; the same colour is placed once."""
        if color not in self.swatches:
            x0, y0, x1, y1 = self.add(Print(6, 6, color))
            self.swatches[color] = ((x0 + x1) / 2, (y0 + y1) / 2, (x0 + x1) / 2, (y0 + y1) / 2)
        return self.swatches[color]

    def paint(self, mesh, **sections):
        """Paints a mesh's sections by name; `rest` paints all others. Each is a plain colour, or a
        pair of a print and how it lies on the surface: around, or seen from front, back, left,
        right, top or bottom. Returns the mesh."""
        for name, how in sections.items():
            named = np.isin(mesh.labels, list(sections))
            chosen = ~named if name == "rest" else mesh.labels == name
            if not chosen.any():
                raise ValueError(f"no section '{name}'; the mesh has "
                                 f"{', '.join(sorted(set(mesh.labels)))}")
            plain = not isinstance(how[0], Print)
            rect = self.swatch(how) if plain else self.add(how[0])
            local = _seen("top" if plain else how[1], mesh.corners()[chosen])
            x0, y0, x1, y1 = rect
            mesh.uv[chosen, :, 0] = (x0 + local[..., 0] * (x1 - x0)) / self.size
            mesh.uv[chosen, :, 1] = 1 - (y1 - local[..., 1] * (y1 - y0)) / self.size
        return mesh


def _seen(how, corners):
    """Coordinates (t, 3, 2) in [0, 1] of triangle corners on a print, x to the right, y upwards."""
    if how == "around":
        around = _angle(corners.mean(axis=1, keepdims=True))
        near = _angle(corners)
        near += 2 * np.pi * np.round((around - near) / (2 * np.pi))
        on_axis = np.hypot(corners[..., 0], corners[..., 1]) < 1e-9
        u = np.where(on_axis, np.broadcast_to(around, near.shape), near) / (2 * np.pi)
        return np.stack([np.clip(u, 0, 1), _spread(corners[..., 2])], axis=2)
    right, up, flip = {"front": (0, 2, False), "back": (0, 2, True), "right": (1, 2, False),
                       "left": (1, 2, True), "top": (0, 1, False), "bottom": (0, 1, True)}[how]
    u = _spread(corners[..., right])
    return np.stack([1 - u if flip else u, _spread(corners[..., up])], axis=2)


def _angle(points):
    """The angle about z, counter-clockwise from +y, in [0, 2 pi)."""
    return np.mod(np.arctan2(-points[..., 0], points[..., 1]), 2 * np.pi)


def _spread(values):
    return (values - values.min()) / max(np.ptp(values), 1e-12)
