"""Objects that no database ever holds. Every function makes one."""

import numpy as np

from item import item
from prints import Atlas, Print
from shapes import box, ellipsoid, extrude, lathe, loft, spline, tube

WHITE, BLACK, STEEL = (244, 242, 236), (26, 26, 28), (168, 172, 178)
YELLOW, ORANGE, RED, GREEN, BLUE = (248, 206, 40), (236, 112, 24), (196, 42, 38), (52, 140, 84), (42, 92, 170)


def duck():
    """A bath duck, its bill towards -x."""
    body = loft([(0.002, 0, 0.000, 0.038, 0.030), (0, 0, 0.012, 0.062, 0.047), (0.002, 0, 0.035, 0.070, 0.053),
                 (0.010, 0, 0.058, 0.064, 0.046), (0.016, 0, 0.075, 0.044, 0.028), (0.018, 0, 0.082, 0.018, 0.010)], 40)
    tail = tube(spline([(0.040, 0, 0.052), (0.070, 0, 0.068), (0.086, 0, 0.090)], 10),
                np.linspace(0.024, 0.006, 10), 16, squash=1.4)
    neck = tube(np.array([(-0.022, 0, z) for z in np.linspace(0.060, 0.095, 6)]), 0.026, 24)
    head = ellipsoid((-0.024, 0, 0.112), (0.036, 0.034, 0.034), 36, 22)
    bill = ellipsoid((-0.064, 0, 0.106), (0.018, 0.017, 0.0065), 24, 12)
    eyes = [ellipsoid((-0.045, y, 0.122), (0.006, 0.005, 0.007), 14, 10) for y in (-0.024, 0.024)]
    wings = [ellipsoid((0.018, y, 0.045), (0.036, 0.014, 0.020), 24, 14) for y in (-0.046, 0.046)]
    atlas = Atlas(256)
    for part in (body, tail, neck, head):
        atlas.paint(part, rest=YELLOW)
    atlas.paint(bill, rest=ORANGE)
    for part in eyes:
        atlas.paint(part, rest=BLACK)
    atlas.paint(wings[0], rest=(236, 176, 20))
    atlas.paint(wings[1], rest=(236, 176, 20))
    return item(atlas, [body, tail, neck, head, bill, *eyes, *wings], 0.3, 50)


def watering_can():
    """The spout with its rose towards -x, the handle over the top."""
    bands = Print(340, 110, GREEN).rect(0, 78, 340, 92, WHITE)
    for k in range(5):
        bands.disc(40 + 65 * k, 40, 15, WHITE).disc(40 + 65 * k, 40, 7, (ORANGE, RED, BLUE, YELLOW, RED)[k])
    body = lathe([(0, 0.002), (0.048, 0.002, "foot"), (0.050, 0, "foot"), (0.055, 0, "foot"), (0.055, 0.108, "side"),
                  (0.050, 0.116, "top"), (0.030, 0.118, "top"), (0.030, 0.112, "hole"), (0, 0.112, "hole")],
                 radius=0.0015, n=44)
    spout = tube(spline([(-0.050, 0, 0.030), (-0.075, 0, 0.050), (-0.100, 0, 0.100), (-0.118, 0, 0.130)], 14),
                 np.linspace(0.013, 0.008, 14), 16)
    rose = lathe([(0, 0), (0.008, 0), (0.024, 0.020, "cone"), (0.024, 0.025, "rim"), (0, 0.028, "holes")], 0.001, n=28)
    rose = rose.turned("y", -40).moved([-0.114, 0, 0.124])
    handle = tube(spline([(-0.030, 0, 0.110), (-0.022, 0, 0.150), (0.015, 0, 0.170), (0.060, 0, 0.150), (0.080, 0, 0.100),
                          (0.072, 0, 0.055), (0.050, 0, 0.040)], 30), 0.006, 14, squash=1.4)
    atlas = Atlas()
    atlas.paint(body, side=(bands, "around"), hole=(18, 40, 28), rest=(36, 104, 62))
    atlas.paint(spout, rest=GREEN)
    atlas.paint(rose, holes=BLACK, rest=ORANGE)
    atlas.paint(handle, rest=ORANGE)
    return item(atlas, [body, spout, rose, handle], 0.2, 30)


def hammer():
    """A rubber mallet, lying along x with its head towards -x."""
    head = lathe([(0, 0), (0.024, 0, "face"), (0.0275, 0.006, "head"), (0.0275, 0.030, "head"), (0.025, 0.034, "band"),
                  (0.025, 0.066, "band"), (0.0275, 0.070, "other"), (0.0275, 0.094, "other"), (0.024, 0.100, "face"),
                  (0, 0.100, "face")], radius=0.002, n=40)
    head = head.turned("x", 90).moved([-0.110, 0.050, 0.0275])
    wood = Print(90, 200, (204, 150, 84)).rect(0, 120, 90, 200, RED).rect(30, 0, 52, 120, (168, 112, 56))
    shaft = loft([(0, 0, 0, 0.014, 0.012), (0, 0, 0.030, 0.0160, 0.0135), (0, 0, 0.090, 0.0135, 0.0115),
                  (0, 0, 0.150, 0.0115, 0.0105), (0, 0, 0.215, 0.0115, 0.0105)], 24)
    atlas = Atlas()
    atlas.paint(head, face=(60, 60, 64), head=BLACK, other=(70, 70, 76), rest=YELLOW)
    atlas.paint(shaft, side=(wood, "front"), rest=(150, 98, 48))
    shaft = shaft.turned("y", -90).turned("y", -3.7).moved([0.118, 0, 0.0155])
    return item(atlas, [head, shaft], 0.15, 30)


def tape_dispenser():
    """A desk dispenser: a heavy base with a roll in it, the cutter towards -x."""
    outline = [(-0.080, 0), (0.070, 0), (0.076, 0.030), (0.060, 0.052), (0.040, 0.040), (0.000, 0.034), (-0.040, 0.036),
               (-0.066, 0.050), (-0.084, 0.046)]
    base = extrude(outline, 0.060, 0.003, step=0.008, layers=5).turned("x", 90).moved([0, 0.030, 0])
    flank = Print(160, 52, (106, 64, 140)).rect(0, 44, 160, 52, WHITE).text(84, 31, "TAPE", 20, WHITE)
    roll = lathe([(0, 0.004), (0.012, 0.004, "hub"), (0.013, 0, "core"), (0.019, 0, "core"), (0.020, 0.003, "core"),
                  (0.036, 0.003, "tape"), (0.036, 0.027, "tape"), (0.020, 0.027, "tape"), (0.019, 0.030, "core"),
                  (0.013, 0.030, "core"), (0.012, 0.026, "hub"), (0, 0.026, "hub")], radius=0.001, n=40)
    roll = roll.turned("x", 90).moved([0.014, 0.015, 0.062])
    strip = tube(np.array([(x, 0, z) for x, z in spline([(0.000, 0.095), (-0.030, 0.078), (-0.072, 0.054)], 10)]), 0.0012,
                 10, squash=9)
    blade = box(0.010, 0.044, 0.010, 0.001, 4).moved([-0.078, 0, 0.044])
    atlas = Atlas()
    atlas.paint(base, top=(flank, "front"), rest=(106, 64, 140))
    atlas.paint(roll, hub=BLACK, core=RED, tape=(226, 206, 150))
    atlas.paint(strip, rest=(226, 206, 150))
    atlas.paint(blade, rest=STEEL)
    return item(atlas, [base, roll, strip, blade], 0.3, 50)


def sugar_bowl():
    """An urn with two handles and a pointed lid."""
    wall = Print(300, 90, (226, 208, 214)).rect(0, 72, 300, 90, (150, 44, 96))
    for k in range(6):
        wall.poly([(k * 50 + 6, 64), (k * 50 + 25, 14), (k * 50 + 44, 64)], ((150, 44, 96), BLACK, (236, 150, 40), (150, 44, 96), GREEN, (236, 150, 40))[k])
    curve = spline([(0.022, 0.016), (0.038, 0.026), (0.051, 0.048), (0.050, 0.070), (0.043, 0.088)], 16)
    body = lathe([(0, 0.002), (0.034, 0.002, "foot"), (0.036, 0, "foot"), (0.038, 0.004, "foot"), (0.020, 0.012, "foot")]
                 + [(r, z, "wall") for r, z in curve] + [(0, 0.088, "neck")], radius=0.0012, n=44)
    cone = spline([(0.046, 0.091), (0.034, 0.101), (0.018, 0.114), (0.008, 0.126)], 12)
    lid = lathe([(0, 0.087), (0.046, 0.087)] + [(r, z) for r, z in cone]
                + [(0.011, 0.132, "knob"), (0.009, 0.141, "knob"), (0, 0.145, "knob")], 0.001, n=36)
    handles = [tube(spline([(s * 0.046, 0, 0.076), (s * 0.066, 0, 0.082), (s * 0.074, 0, 0.062), (s * 0.064, 0, 0.044),
                            (s * 0.047, 0, 0.044)], 18), 0.0055, 12) for s in (-1, 1)]
    atlas = Atlas()
    atlas.paint(body, wall=(wall, "around"), rest=(150, 44, 96))
    atlas.paint(lid, knob=(236, 150, 40), rest=(150, 44, 96))
    for handle in handles:
        atlas.paint(handle, rest=(236, 150, 40))
    return item(atlas, [body, lid, *handles], 0.35, 60)
