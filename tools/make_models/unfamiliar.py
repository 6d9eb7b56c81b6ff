"""Objects that no database ever holds. Every function makes one."""

import numpy as np

from item import item
from prints import Atlas, Print
from shapes import box, ellipsoid, extrude, lathe, loft, spline, tube

WHITE, BLACK, STEEL = (244, 242, 236), (26, 26, 28), (168, 172, 178)
YELLOW, ORANGE, RED = (248, 206, 40), (236, 112, 24), (196, 42, 38)
GREEN, BLUE, PLUM = (52, 140, 84), (42, 92, 170), (150, 44, 96)
AMBER, TAPE, VIOLET = (236, 150, 40), (226, 206, 150), (106, 64, 140)


def duck():
    """A bath duck, its bill towards -x."""
    body = loft([(0.002, 0, 0.000, 0.038, 0.030), (0, 0, 0.012, 0.062, 0.047),
                 (0.002, 0, 0.035, 0.070, 0.053), (0.010, 0, 0.058, 0.064, 0.046),
                 (0.016, 0, 0.075, 0.044, 0.028), (0.018, 0, 0.082, 0.018, 0.010)], 40)
    tail = tube(spline([(0.040, 0, 0.052), (0.070, 0, 0.068), (0.086, 0, 0.090)], 10),
                np.linspace(0.024, 0.006, 10), 16, squash=1.4)
    neck = tube(np.array([(-0.022, 0, z) for z in np.linspace(0.060, 0.095, 6)]), 0.026, 24)
    head = ellipsoid((-0.024, 0, 0.112), (0.036, 0.034, 0.034), 36, 22)
    bill = ellipsoid((-0.064, 0, 0.106), (0.018, 0.017, 0.0065), 24, 12)
    eyes = [ellipsoid((-0.045, y, 0.122), (0.006, 0.005, 0.007), 14, 10) for y in (-0.024, 0.024)]
    wings = [ellipsoid((0.018, y, 0.045), (0.036, 0.014, 0.020), 24, 14) for y in (-0.046, 0.046)]
    atlas = Atlas(256)
    parts = [atlas.paint(part, rest=YELLOW) for part in (body, tail, neck, head)]
    parts += [atlas.paint(part, rest=(236, 176, 20)) for part in wings]
    parts += [atlas.paint(part, rest=BLACK) for part in eyes]
    parts += [atlas.paint(bill, rest=ORANGE)]
    return item(atlas, parts, 0.3, 50)


def watering_can():
    """The spout with its rose towards -x, the handle over the top."""
    bands = Print(340, 110, GREEN).rect(0, 78, 340, 92, WHITE)
    for k, color in enumerate((ORANGE, RED, BLUE, YELLOW, RED)):
        bands.disc(40 + 65 * k, 40, 15, WHITE).disc(40 + 65 * k, 40, 7, color)
    body = lathe([(0, 0.002), (0.048, 0.002, "foot"), (0.050, 0, "foot"), (0.055, 0, "foot"),
                  (0.055, 0.108, "side"), (0.050, 0.116, "top"), (0.030, 0.118, "top"),
                  (0.030, 0.112, "hole"), (0, 0.112, "hole")],
                 radius=0.0015, n=44)
    spout = tube(spline([(-0.050, 0, 0.030), (-0.075, 0, 0.050), (-0.100, 0, 0.100),
                         (-0.118, 0, 0.130)], 14), np.linspace(0.013, 0.008, 14), 16)
    rose = lathe([(0, 0), (0.008, 0), (0.024, 0.020, "cone"), (0.024, 0.025, "rim"),
                  (0, 0.028, "holes")], 0.001, n=28)
    rose = rose.turned("y", -40).moved([-0.114, 0, 0.124])
    handle = tube(spline([(-0.030, 0, 0.110), (-0.022, 0, 0.150), (0.015, 0, 0.170),
                          (0.060, 0, 0.150), (0.080, 0, 0.100), (0.072, 0, 0.055),
                          (0.050, 0, 0.040)], 30), 0.006, 14, squash=1.4)
    atlas = Atlas()
    atlas.paint(body, side=(bands, "around"), hole=(18, 40, 28), rest=(36, 104, 62))
    atlas.paint(spout, rest=GREEN)
    atlas.paint(rose, holes=BLACK, rest=ORANGE)
    atlas.paint(handle, rest=ORANGE)
    return item(atlas, [body, spout, rose, handle], 0.2, 30)


def hammer():
    """A rubber mallet, lying along x with its head towards -x."""
    head = lathe([(0, 0), (0.024, 0, "face"), (0.0275, 0.006, "head"), (0.0275, 0.030, "head"),
                  (0.025, 0.034, "band"), (0.025, 0.066, "band"), (0.0275, 0.070, "other"),
                  (0.0275, 0.094, "other"), (0.024, 0.100, "face"),
                  (0, 0.100, "face")], radius=0.002, n=40)
    head = head.turned("x", 90).moved([-0.110, 0.050, 0.0275])
    wood = Print(90, 200, (204, 150, 84)).rect(0, 120, 90, 200, RED)
    wood.rect(30, 0, 52, 120, (168, 112, 56))
    shaft = loft([(0, 0, 0, 0.014, 0.012), (0, 0, 0.030, 0.0160, 0.0135),
                  (0, 0, 0.090, 0.0135, 0.0115), (0, 0, 0.150, 0.0115, 0.0105),
                  (0, 0, 0.215, 0.0115, 0.0105)], 24)
    atlas = Atlas()
    atlas.paint(head, face=(60, 60, 64), head=BLACK, other=(70, 70, 76), rest=YELLOW)
    atlas.paint(shaft, side=(wood, "front"), rest=(150, 98, 48))
    shaft = shaft.turned("y", -90 + 3.7).moved([0.118, 0, 0.0165])
    return item(atlas, [head, shaft], 0.15, 30)


def tape_dispenser():
    """A desk dispenser: a heavy base with a roll in it, the cutter towards -x."""
    outline = [(-0.080, 0), (0.070, 0), (0.076, 0.030), (0.060, 0.052), (0.040, 0.040),
               (0.000, 0.034), (-0.040, 0.036), (-0.066, 0.050), (-0.084, 0.046)]
    base = extrude(outline, 0.060, 0.003, step=0.008, layers=5).turned("x", 90).moved([0, 0.030, 0])
    flank = Print(160, 52, VIOLET).rect(0, 44, 160, 52, WHITE)
    flank.text(84, 31, "TAPE", 20, WHITE)
    roll = lathe([(0, 0.004), (0.012, 0.004, "hub"), (0.013, 0, "core"), (0.019, 0, "core"),
                  (0.020, 0.003, "core"), (0.036, 0.003, "tape"), (0.036, 0.027, "tape"),
                  (0.020, 0.027, "tape"), (0.019, 0.030, "core"), (0.013, 0.030, "core"),
                  (0.012, 0.026, "hub"), (0, 0.026, "hub")], radius=0.001, n=40)
    roll = roll.turned("x", 90).moved([0.014, 0.015, 0.062])
    path = spline([(0.000, 0, 0.095), (-0.030, 0, 0.078), (-0.072, 0, 0.054)], 10)
    strip = tube(path, 0.0012, 10, squash=9)
    blade = box(0.010, 0.044, 0.010, 0.001, 4).moved([-0.078, 0, 0.044])
    atlas = Atlas()
    atlas.paint(base, top=(flank, "front"), rest=VIOLET)
    atlas.paint(roll, hub=BLACK, core=RED, tape=TAPE)
    atlas.paint(strip, rest=TAPE)
    atlas.paint(blade, rest=STEEL)
    return item(atlas, [base, roll, strip, blade], 0.3, 50)


def sugar_bowl():
    """An urn with two handles and a pointed lid."""
    atlas = Atlas()
    wall = Print(300, 90, (226, 208, 214)).rect(0, 72, 300, 90, PLUM)
    for k, color in enumerate((PLUM, BLACK, AMBER, PLUM, GREEN, AMBER)):
        wall.poly([(k * 50 + 6, 64), (k * 50 + 25, 14), (k * 50 + 44, 64)], color)
    curve = spline([(0.022, 0.016), (0.038, 0.026), (0.051, 0.048), (0.050, 0.070),
                    (0.043, 0.088)], 16)
    body = lathe([(0, 0.002), (0.034, 0.002, "foot"), (0.036, 0, "foot"), (0.038, 0.004, "foot"),
                  (0.020, 0.012, "foot")]
                 + [(r, z, "wall") for r, z in curve] + [(0, 0.088, "neck")], radius=0.0012, n=44)
    cone = spline([(0.046, 0.091), (0.034, 0.101), (0.018, 0.114), (0.008, 0.126)], 12)
    lid = lathe([(0, 0.087), (0.046, 0.087)] + [(r, z) for r, z in cone]
                + [(0.011, 0.132, "knob"), (0.009, 0.141, "knob"), (0, 0.145, "knob")], 0.001, n=36)
    curve = [(0.046, 0, 0.076), (0.066, 0, 0.082), (0.074, 0, 0.062), (0.064, 0, 0.044),
             (0.047, 0, 0.044)]
    right = tube(spline(curve, 18), 0.0055, 12)
    handles = [atlas.paint(handle, rest=AMBER) for handle in (right, right.turned("z", 180))]
    atlas.paint(body, wall=(wall, "around"), rest=PLUM)
    atlas.paint(lid, knob=AMBER, rest=PLUM)
    return item(atlas, [body, lid, *handles], 0.35, 60)
