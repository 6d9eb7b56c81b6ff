"""Household objects that the object databases know. Every function makes one."""

import numpy as np

from item import item
from mesh import turned
from prints import Atlas, Print
from shapes import box, extrude, lathe, spline, tube

WHITE, BLACK, CREAM = (245, 243, 238), (24, 24, 26), (240, 224, 188)
RED, GREEN, BLUE, YELLOW = (198, 44, 38), (44, 122, 62), (36, 84, 168), (246, 196, 44)


def _carton(front, back, left, right, top, bottom, size):
    atlas = Atlas()
    sides = {"front": front, "back": back, "left": left, "right": right, "top": top,
             "bottom": bottom}
    tallest_first = sorted(sides, key=lambda side: -sides[side].height)
    carton = atlas.paint(box(*size), **{side: (sides[side], side) for side in tallest_first})
    return item(atlas, [carton])


def oat_box():
    """A carton like rice_box in all but its print."""
    orange, brown = (232, 128, 30), (92, 50, 22)
    front = Print(190, 240, CREAM).rect(0, 0, 190, 78, orange).text(95, 30, "OAT", 50, WHITE)
    front.text(95, 62, "MORNING", 19, brown).disc(95, 160, 66, YELLOW)
    front.poly([(30, 152), (160, 152), (140, 205), (118, 222), (72, 222), (50, 205)], (176, 46, 34))
    front.disc(95, 152, 65, WHITE, 14).disc(95, 152, 56, (226, 200, 150), 10)
    for x, y in ((70, 150), (88, 155), (104, 148), (120, 154), (84, 146), (110, 158)):
        front.disc(x, y, 5, brown, 3)
    back = Print(190, 240, CREAM).rect(0, 0, 190, 34, brown)
    back.text(95, 17, "GOOD FROM THE FIELD", 14, CREAM)
    back.lines_of_text(16, 52, 90, 14, brown).rect(118, 50, 176, 132, orange)
    back.text(147, 90, "1 kg", 24, WHITE).leaf(60, 186, 90, 34, -25, GREEN)
    back.bar_code(112, 190, 64, 36)
    left = Print(60, 240, orange).text(30, 120, "MORNING OAT", 28, WHITE, 90)
    right = Print(60, 240, brown).rect(8, 20, 52, 130, CREAM).lines_of_text(13, 28, 34, 16, brown)
    right.disc(30, 190, 20, YELLOW)
    top = Print(190, 60, orange).text(70, 30, "OAT", 34, WHITE).rect(140, 0, 190, 60, brown)
    bottom = Print(190, 60, CREAM).bar_code(20, 14, 60, 32)
    return _carton(front, back, left, right, top, bottom, (0.19, 0.06, 0.24))


def rice_box():
    """A carton like oat_box in all but its print."""
    navy, sky = (22, 46, 110), (120, 186, 226)
    front = Print(190, 240, sky).rect(0, 170, 190, 240, GREEN).text(95, 46, "RICE", 56, navy)
    front.poly([(0, 170), (60, 96), (104, 170)], (92, 112, 150))
    front.poly([(44, 116), (60, 96), (72, 117)], WHITE)
    front.poly([(70, 170), (130, 82), (190, 170)], navy)
    front.poly([(111, 110), (130, 82), (149, 110)], WHITE)
    for row in range(4):
        front.line([(0, 182 + 16 * row), (190, 176 + 18 * row)], 5, (150, 196, 70))
    front.disc(158, 206, 26, RED).text(158, 206, "5 min", 15, WHITE)
    back = Print(190, 240, WHITE).rect(0, 0, 26, 240, navy).text(108, 24, "HILL TERRACE", 20, navy)
    back.lines_of_text(40, 48, 130, 9, navy).disc(74, 156, 32, sky).disc(142, 156, 28, navy)
    back.text(74, 156, "1", 40, navy).text(142, 156, "2", 36, WHITE).bar_code(40, 198, 70, 32)
    left = Print(60, 240, navy).text(30, 120, "HILL RICE", 32, WHITE, 90).rect(0, 0, 60, 22, RED)
    right = Print(60, 240, sky).rect(0, 150, 60, 240, GREEN).disc(30, 60, 22, WHITE)
    right.text(30, 60, "2 kg", 16, navy)
    right.lines_of_text(10, 98, 40, 8, navy)
    top = Print(190, 60, navy).text(112, 30, "RICE", 38, WHITE).rect(0, 0, 44, 60, RED)
    bottom = Print(190, 60, WHITE).bar_code(110, 14, 60, 32)
    return _carton(front, back, left, right, top, bottom, (0.19, 0.06, 0.24))


def tea_box():
    """A small carton on its long side."""
    green, pale, gold = (26, 92, 60), (206, 224, 176), (214, 166, 62)
    front = Print(150, 80, green).leaf(36, 44, 60, 28, -40, pale)
    front.leaf(56, 50, 40, 18, 30, (120, 176, 84))
    front.text(104, 34, "TEA", 34, WHITE).rect(72, 58, 138, 66, gold)
    back = Print(150, 80, pale).rect(0, 0, 150, 18, green).lines_of_text(10, 26, 80, 8, green)
    back.bar_code(98, 34, 44, 34)
    left = Print(80, 80, gold).disc(40, 40, 28, green).text(40, 40, "20", 28, WHITE)
    right = Print(80, 80, green).poly([(0, 80), (80, 0), (80, 80)], pale)
    right.leaf(52, 54, 40, 18, -45, green)
    top = Print(150, 80, green).rect(6, 6, 144, 74, pale).text(60, 42, "MEADOW", 20, green)
    top.leaf(122, 40, 50, 22, 80, (84, 150, 70))
    bottom = Print(150, 80, WHITE).lines_of_text(10, 10, 90, 10, green)
    return _carton(front, back, left, right, top, bottom, (0.15, 0.08, 0.08))


def soup_can():
    """A tin whose label alone tells how it is turned."""
    metal = (176, 178, 182)
    label = Print(238, 100, RED).rect(0, 0, 238, 26, WHITE).text(119, 13, "GARDEN", 20, RED)
    label.disc(119, 62, 34, CREAM).disc(119, 66, 22, (232, 98, 24))
    label.leaf(119, 40, 26, 12, -60, GREEN)
    label.leaf(108, 42, 22, 10, -130, GREEN).text(188, 52, "SOUP", 26, WHITE)
    label.rect(0, 26, 62, 100, (250, 214, 90)).lines_of_text(8, 34, 44, 10, BLACK)
    label.rect(214, 26, 238, 100, BLACK)
    body = lathe([(0, 0.002), (0.034, 0.002, "rim"), (0.034, 0, "rim"), (0.0375, 0, "rim"),
                  (0.0375, 0.004, "rim"), (0.038, 0.005, "rim"), (0.038, 0.105, "label"),
                  (0.0375, 0.106, "rim"), (0.0375, 0.110, "rim"), (0.034, 0.110, "rim"),
                  (0.034, 0.107, "rim"), (0.026, 0.107, "lid"), (0.025, 0.1062, "lid"),
                  (0, 0.1062, "lid")],
                 radius=0.0008, n=40)
    lid = Print(64, 64, metal).ring(32, 32, 29, 3, (110, 112, 118))
    lid.rect(27, 8, 37, 30, (90, 92, 98))
    lid.ring(32, 14, 8, 3, (70, 72, 78))
    atlas = Atlas()
    atlas.paint(body, label=(label, "around"), lid=(lid, "top"), rest=metal)
    return item(atlas, [body], 0.3, 50)


def mug():
    """A hollow mug, the handle towards +x."""
    teal = (18, 122, 128)
    outside = Print(267, 88, WHITE).rect(0, 0, 267, 8, teal).rect(0, 69, 267, 88, teal)
    outside.star(112, 40, 27, (236, 120, 28), 8, 0.62).disc(112, 40, 13, YELLOW)
    for x, y in ((30, 24), (52, 48), (18, 56), (70, 20)):
        outside.disc(x, y, 8, RED)
    outside.poly([(170, 62), (195, 18), (222, 62)], BLUE)
    body = lathe([(0, 0.002), (0.030, 0.002, "foot"), (0.032, 0, "foot"), (0.036, 0, "foot"),
                  (0.0425, 0.008, "outside"), (0.0425, 0.095, "outside"), (0.0385, 0.095, "rim"),
                  (0.0385, 0.010, "inside"), (0.034, 0.006, "inside"), (0, 0.006, "inside")],
                 radius=0.002, n=44)
    path = spline([(0.0421, 0, 0.078), (0.056, 0, 0.082), (0.073, 0, 0.070), (0.074, 0, 0.045),
                   (0.060, 0, 0.026), (0.0419, 0, 0.024)], 22)
    handle = tube(path, 0.0055, 14, squash=1.25)
    atlas = Atlas()
    atlas.paint(body, outside=(outside, "around"), rim=teal, rest=(224, 232, 230))
    atlas.paint(handle, rest=teal)
    return item(atlas, [body, handle], 0.35, 60)


def book():
    """A book lying on its back, the spine towards -x."""
    wine, gold = (124, 24, 44), (228, 180, 80)
    cover = Print(210, 150, wine).rect(24, 0, 30, 150, gold).text(120, 34, "SECOND", 30, gold)
    cover.text(120, 66, "LOOK", 30, gold).disc(92, 112, 24, WHITE).disc(92, 112, 12, BLUE)
    cover.disc(92, 112, 5, BLACK).disc(160, 112, 24, WHITE).disc(152, 112, 12, BLUE)
    cover.disc(152, 112, 5, BLACK)
    back = Print(210, 150, gold).rect(14, 14, 196, 136, wine).lines_of_text(28, 30, 150, 14, CREAM)
    spine = Print(150, 35, wine).text(70, 17, "SECOND LOOK", 17, gold).rect(130, 0, 150, 35, gold)
    pages = Print(200, 30, (238, 230, 208))
    for row in range(7):
        pages.rect(0, 2 + row * 4, 200, 3 + row * 4, (196, 186, 160))
    outline = [(-0.105, 0), (0.105, 0), (0.105, 0.003), (-0.100, 0.003), (-0.100, 0.032),
               (0.105, 0.032), (0.105, 0.035), (-0.105, 0.035)]
    labels = ["back", "edge", "lining", "lining", "lining", "edge", "cover", "spine"]
    boards = extrude(outline, 0.150, 0.001, labels).turned("x", 90).moved([0, 0.075, 0])
    block = box(0.1990, 0.142, 0.0296, 0.001).moved([-0.0015, 0, 0.0027])
    atlas = Atlas()
    atlas.paint(boards, cover=(cover, "top"), back=(back, "bottom"), spine=(spine, "left"),
                rest=wine)
    atlas.paint(block, right=(pages, "right"), front=(pages, "front"), back=(pages, "back"),
                rest=CREAM)
    return item(atlas, [boards, block], 0.15, 30)


def bottle():
    """A bottle whose label alone tells how it is turned."""
    green, dark = (34, 116, 72), (16, 74, 46)
    label = Print(232, 76, CREAM).rect(0, 0, 232, 8, RED).rect(0, 68, 232, 76, RED)
    label.text(117, 26, "SPRING", 24, BLUE)
    label.line([(82, 52), (96, 44), (110, 54), (124, 44), (138, 54), (152, 46)], 6, BLUE)
    label.rect(0, 8, 46, 68, YELLOW).star(23, 38, 18, RED).lines_of_text(178, 16, 46, 8, BLACK)
    profile = [(0, 0.003), (0.028, 0.003, "glass"), (0.031, 0, "glass"), (0.035, 0, "glass"),
               (0.037, 0.006, "glass"), (0.037, 0.045, "glass"), (0.0372, 0.046, "label"),
               (0.0372, 0.122, "label"), (0.037, 0.123, "glass"), (0.037, 0.135, "glass")]
    shoulder = spline([(0.037, 0.137), (0.0345, 0.155), (0.025, 0.176), (0.0165, 0.195),
                       (0.0140, 0.213)], 14)
    profile += [(r, z, "glass") for r, z in shoulder]
    profile += [(0.0140, 0.215, "glass"), (0.0168, 0.2155, "cap"), (0.0168, 0.240, "cap"),
                (0, 0.240, "cap")]
    body = lathe(profile, radius=0.0012, n=40)
    atlas = Atlas()
    glass = Print(232, 150, green).rect(150, 0, 200, 150, dark).rect(20, 0, 34, 150, (80, 160, 112))
    atlas.paint(body, label=(label, "around"), glass=(glass, "around"), cap=RED)
    return item(atlas, [body], 0.4, 80)


def bowl():
    """A hollow bowl with a wall of 4 mm."""
    ring = Print(400, 60, (238, 232, 220)).rect(0, 4, 400, 12, BLUE)
    for k, color in enumerate((BLUE, BLUE, (226, 118, 36), BLUE, BLUE, BLUE, RED, RED)):
        ring.poly([(k * 50 + 4, 52), (k * 50 + 25, 18), (k * 50 + 46, 52)], color)
    inside = Print(100, 100, (238, 232, 220)).disc(50, 50, 18, BLUE)
    inside.disc(50, 50, 9, (238, 232, 220))
    inside.poly([(50, 4), (58, 22), (42, 22)], RED)
    outer = spline([(0.036, 0.002), (0.052, 0.012), (0.069, 0.034), (0.080, 0.069)], 14)
    inner = spline([(0.0762, 0.069), (0.065, 0.036), (0.048, 0.016), (0.030, 0.0075),
                    (0.012, 0.006), (0, 0.006)], 16)
    body = lathe([(0, 0.003), (0.030, 0.003, "foot"), (0.032, 0, "foot"), (0.035, 0, "foot")]
                 + [(r, z, "outside") for r, z in outer] + [(0.0781, 0.070, "rim")]
                 + [(r, z, "inside") for r, z in inner], radius=0.0012, n=48)
    atlas = Atlas()
    atlas.paint(body, outside=(ring, "around"), inside=(inside, "top"), rest=BLUE)
    return item(atlas, [body], 0.35, 60)


def tea_pot():
    """A closed pot, the spout towards -x, the handle towards +x."""
    blue, pale = (44, 78, 150), (232, 236, 240)
    glaze = Print(340, 110, pale).rect(0, 92, 340, 110, blue).rect(0, 0, 340, 10, blue)
    for x, color in ((170, RED), (0, blue), (340, blue)):
        for k in range(6):
            glaze.disc(x + 20 * np.cos(np.pi * k / 3), 52 + 20 * np.sin(np.pi * k / 3), 12, color)
        glaze.disc(x, 52, 11, YELLOW)
    glaze.leaf(124, 70, 44, 18, 20, GREEN).leaf(216, 70, 44, 18, -20, GREEN)
    curve = spline([(0.040, 0.003), (0.060, 0.020), (0.068, 0.050), (0.060, 0.085),
                    (0.042, 0.104)], 18)
    body = lathe([(0, 0.002), (0.034, 0.002, "foot"), (0.035, 0, "foot"), (0.039, 0, "foot")]
                 + [(r, z, "glaze") for r, z in curve] + [(0, 0.104, "neck")], radius=0.0012, n=44)
    dome = spline([(0.041, 0.108), (0.034, 0.118), (0.018, 0.125), (0.007, 0.128), (0.006, 0.132),
                   (0.011, 0.138), (0.010, 0.145), (0.004, 0.149), (0, 0.150)], 22)
    lid = lathe([(0, 0.103), (0.041, 0.103, "lid")] + [(r, z, "lid") for r, z in dome], 0.001, n=32)
    lid.labels[lid.corners()[..., 2].mean(axis=1) > 0.131] = "knob"
    path = spline([(-0.058, 0, 0.040), (-0.080, 0, 0.050), (-0.096, 0, 0.080), (-0.112, 0, 0.106)],
                  16)
    spout = tube(path, np.interp(np.linspace(0, 1, 16), [0, 0.4, 1], [0.019, 0.013, 0.0085]), 16)
    grip = tube(spline([(0.054, 0, 0.090), (0.078, 0, 0.098), (0.100, 0, 0.080), (0.098, 0, 0.050),
                        (0.080, 0, 0.030), (0.061, 0, 0.028)], 22), 0.0065, 14, squash=1.2)
    atlas = Atlas()
    atlas.paint(body, glaze=(glaze, "around"), rest=blue)
    atlas.paint(lid, knob=RED, rest=blue)
    atlas.paint(spout, end=BLACK, rest=pale)
    atlas.paint(grip, rest=blue)
    return item(atlas, [body, lid, spout, grip], 0.4, 70)


def whisk():
    """Eight wires of 2 mm, which a depth camera hardly sees, on a handle."""
    steel = (186, 190, 196)
    handle = lathe([(0, 0), (0.009, 0, "cap"), (0.0105, 0.006, "cap"), (0.0125, 0.05, "handle"),
                    (0.0115, 0.09, "handle"), (0.0125, 0.11, "ferrule"), (0.0095, 0.122, "ferrule"),
                    (0, 0.122, "ferrule")], radius=0.003, n=24)
    atlas = Atlas(256)
    grip = Print(80, 60, (236, 98, 30)).rect(0, 20, 80, 28, WHITE).rect(0, 40, 30, 60, BLACK)
    atlas.paint(handle, cap=BLACK, handle=(grip, "around"), ferrule=(120, 124, 130))
    parts = [handle]
    for k in range(4):
        reach = 0.262 + 0.0022 * k
        half = [(0.007, 0.116), (0.011, 0.14), (0.029, 0.195), (0.034, 0.225), (0.024, 0.250),
                (0, reach)]
        points = [(x, 0, z) for x, z in half] + [(-x, 0, z) for x, z in half[-2::-1]]
        wire = tube(spline(points, 54), 0.001, 7).turned("z", 22.5 + 45 * k)
        parts.append(atlas.paint(wire, rest=steel))
    return item(atlas, turned(parts, "y", 90 - 5.9), 0.6, 120)


def flask():
    """Dark and shiny: a vacuum flask that a depth camera sees in patches."""
    dark = Print(200, 180, (20, 20, 24)).rect(0, 146, 200, 152, (52, 52, 58))
    dark.rect(88, 60, 112, 66, (70, 66, 60))
    profile = [(0, 0.002), (0.034, 0.002, "body"), (0.035, 0, "body"), (0.041, 0, "body"),
               (0.0425, 0.004, "body"), (0.0425, 0.130, "body")]
    shoulder = spline([(0.0425, 0.132), (0.041, 0.142), (0.035, 0.152), (0.0315, 0.156)], 8)
    profile += [(r, z, "body") for r, z in shoulder]
    profile += [(0.0315, 0.160, "band"), (0.0335, 0.161, "cup"), (0.0325, 0.200, "cup"),
                (0.029, 0.206, "cup"), (0, 0.207, "cup")]
    body = lathe(profile, radius=0.0015, n=40)
    handle = tube(spline([(0.041, 0, 0.128), (0.060, 0, 0.122), (0.066, 0, 0.085),
                          (0.060, 0, 0.045), (0.041, 0, 0.036)], 20), 0.006, 12, squash=1.6)
    atlas = Atlas(256)
    atlas.paint(body, body=(dark, "around"), band=(90, 90, 96), cup=(16, 16, 20))
    atlas.paint(handle, rest=(22, 22, 26))
    return item(atlas, [body, handle], 0.8, 200)


def _block(outline, labels):
    """A block drawn along x from a side view (y, z) of its outline; sections by `labels`."""
    front = Print(100, 140, (62, 96, 140)).rect(10, 10, 90, 130, (214, 220, 226))
    front.disc(50, 48, 26, (232, 150, 30))
    front.poly([(22, 116), (50, 84), (78, 116)], (62, 96, 140))
    top = Print(100, 100, (214, 220, 226)).rect(0, 88, 100, 100, (62, 96, 140))
    top.disc(30, 60, 16, (62, 96, 140))
    left = Print(100, 140, (58, 132, 92)).poly([(0, 140), (100, 0), (100, 140)], CREAM)
    right = Print(100, 140, (170, 60, 52)).disc(50, 70, 32, CREAM)
    back = Print(100, 140, (222, 186, 70)).rect(0, 0, 34, 140, BLACK).rect(66, 70, 100, 140, BLACK)
    block = extrude(outline, 0.10, 0.0015, labels, step=0.010, layers=7)
    block = block.turned("x", 90).turned("z", 90).moved([-0.05, 0, 0])
    atlas = Atlas()
    atlas.paint(block, front=(front, "front"), back=(back, "back"), bottom=(left, "left"),
                top=(right, "right"), above=(top, "top"), rest=(120, 122, 126))
    return item(atlas, [block], 0.1, 20)


def block_plain():
    """The cuboid of the twins: seen from the front (-y) it is the same as block_notched."""
    return _block([(-0.05, 0), (0.05, 0), (0.05, 0.14), (-0.05, 0.14)],
                  ["below", "back", "above", "front"])


def block_notched():
    """The other twin: front, top and prints as block_plain, with a deep wedge cut from its back."""
    outline = [(-0.05, 0), (0.05, 0), (0.05, 0.018), (-0.015, 0.070), (0.05, 0.122), (0.05, 0.14),
               (-0.05, 0.14)]
    return _block(outline, ["below", "back", "back", "back", "back", "above", "front"])


def _canister(color):
    """A tin with a knob; its two colours are about equally light (L* 44)."""
    label = Print(298, 110, color).rect(0, 14, 298, 22, WHITE).rect(0, 88, 298, 96, WHITE)
    label.disc(149, 55, 26, WHITE).disc(149, 55, 17, color).star(40, 55, 24, WHITE)
    label.rect(224, 32, 268, 78, WHITE)
    body = lathe([(0, 0.001), (0.044, 0.001, "base"), (0.0475, 0, "base"), (0.0475, 0.110, "label"),
                  (0.0490, 0.110, "lid"), (0.0490, 0.124, "lid"), (0.044, 0.128, "lid"),
                  (0.009, 0.130, "lid"), (0.008, 0.138, "lid"), (0.013, 0.144, "lid"),
                  (0.012, 0.150, "lid"), (0, 0.152, "lid")],
                 radius=0.0015, n=44)
    atlas = Atlas()
    atlas.paint(body, label=(label, "around"), lid=(206, 202, 192), rest=color)
    return item(atlas, [body], 0.25, 40)


def canister_red():
    """Differs from canister_blue in colour only."""
    return _canister((200, 48, 42))


def canister_blue():
    """Differs from canister_red in colour only."""
    return _canister((44, 106, 178))
