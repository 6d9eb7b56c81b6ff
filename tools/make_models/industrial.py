"""Industrial objects that the object databases know. Every function makes one."""

import numpy as np

from item import item
from mesh import turned
from prints import Atlas, Print
from shapes import arc, box, lathe, loft, rod, tube

STEEL, GRAPHITE, RUBBER = (168, 172, 178), (62, 66, 72), (36, 36, 40)
WHITE, YELLOW, ORANGE = (244, 242, 236), (244, 190, 30), (234, 112, 24)
RED, BLUE = (196, 40, 36), (34, 86, 172)


def _directions(*degrees):
    """Cosine and sine of each angle."""
    return [(np.cos(a), np.sin(a)) for a in np.radians(degrees)]


def power_drill():
    """Pistol-shaped; stands on its battery, the chuck towards -x."""
    def grooves(theta, r, z):
        return 1 - 0.03 * (np.cos(12 * theta) > 0.3) * (r > 0.015)

    motor = lathe([(0, 0), (0.022, 0, "cap"), (0.0285, 0.008, "cap"), (0.0285, 0.022, "cap"),
                   (0.0300, 0.024, "shell"), (0.0300, 0.105, "shell"), (0.0245, 0.118, "gear"),
                   (0.0245, 0.135, "gear"), (0, 0.135, "gear")],
                  radius=0.003, n=34)
    chuck = lathe([(0, 0.13), (0.0195, 0.13), (0.0205, 0.150), (0.0165, 0.166), (0.0095, 0.178),
                   (0, 0.178)],
                  radius=0.0015, n=32, shape=grooves)
    bit = rod((0, 0, 0.170), (0, 0, 0.205), 0.0035, 10)
    atlas = Atlas()
    shell = Print(188, 81, YELLOW).rect(0, 26, 34, 81, RUBBER).rect(154, 26, 188, 81, RUBBER)
    shell.rect(70, 0, 118, 81, (228, 168, 16)).text(52, 42, "D18", 18, RUBBER, 270)
    shell.text(136, 42, "D18", 18, RUBBER, 90)
    shell.rect(84, 8, 104, 40, RED)
    atlas.paint(motor, shell=(shell, "around"), cap=RUBBER, gear=GRAPHITE)
    atlas.paint(chuck, rest=(44, 44, 48))
    atlas.paint(bit, rest=STEEL)
    barrel = [part.turned("z", 90).turned("y", -90).moved([0.075, 0, 0.165])
              for part in (motor, chuck, bit)]
    grip = loft([(0.042, 0, 0.045, 0.024, 0.017), (0.038, 0, 0.070, 0.020, 0.0155),
                 (0.030, 0, 0.105, 0.019, 0.0155), (0.024, 0, 0.145, 0.024, 0.018)], 28, 2.6)
    grip_print = Print(40, 90, YELLOW).rect(20, 0, 40, 90, RUBBER)
    trigger = box(0.016, 0.014, 0.030, 0.003, 5).turned("y", 12).moved([0.008, 0, 0.106])
    battery = box(0.098, 0.066, 0.040, 0.005, 8).moved([0.030, 0, 0])
    collar = box(0.084, 0.052, 0.014, 0.004, 6).moved([0.034, 0, 0.038])
    mark = Print(98, 40, RUBBER).rect(8, 10, 70, 32, RED).text(38, 21, "18 V", 17, WHITE)
    other = Print(98, 40, RUBBER).rect(30, 8, 90, 18, WHITE).rect(30, 24, 60, 32, YELLOW)
    atlas.paint(grip, side=(grip_print, "front"), rest=RUBBER)
    atlas.paint(trigger, rest=RED)
    atlas.paint(battery, front=(mark, "front"), back=(other, "back"), left=RED, rest=RUBBER)
    atlas.paint(collar, rest=GRAPHITE)
    return item(atlas, barrel + [grip, trigger, battery, collar], 0.25, 40)


def oil_filter():
    """A spin-on filter: facets for the wrench above, a printed shell below."""
    def facets(theta, r, z):
        depth = 0.045 * np.clip((z - 0.088) / 0.006, 0, 1) * (r > 0.03)
        return 1 - depth * np.abs(np.sin(7 * theta))

    label = Print(314, 84, ORANGE).rect(0, 0, 314, 16, WHITE).text(157, 46, "OIL FILTER", 34, WHITE)
    label.rect(0, 16, 60, 84, GRAPHITE).poly([(12, 74), (30, 26), (48, 74)], YELLOW)
    label.rect(250, 26, 304, 76, RUBBER)
    body = lathe([(0, 0.004), (0.020, 0.004, "thread"), (0.020, 0.002, "gasket"),
                  (0.040, 0.002, "gasket"), (0.041, 0, "gasket"), (0.047, 0, "gasket"),
                  (0.050, 0.004, "shell"), (0.050, 0.086, "label"), (0.050, 0.090, "shell"),
                  (0.049, 0.118, "shell"), (0.040, 0.128, "end"), (0.018, 0.130, "end"),
                  (0, 0.130, "end")], radius=0.0015, n=56, step=0.009, shape=facets)
    end = Print(90, 90, GRAPHITE).rect(38, 4, 52, 44, ORANGE).disc(45, 45, 14, WHITE)
    atlas = Atlas()
    atlas.paint(body, label=(label, "around"), end=(end, "top"), gasket=RUBBER, rest=GRAPHITE)
    return item(atlas, [body], 0.3, 50)


def valve():
    """A gate valve: flanged pipe body along x, bonnet, stem and hand-wheel."""
    bronze, green = (176, 122, 58), (44, 104, 84)
    atlas = Atlas(256)
    pipe = lathe([(0, 0.010), (0.020, 0.010, "bore"), (0.020, 0, "bore"), (0.040, 0, "flange"),
                  (0.040, 0.011, "flange"), (0.026, 0.012, "body"), (0.026, 0.028, "body"),
                  (0.033, 0.045, "body"), (0.035, 0.060, "body"), (0.033, 0.075, "body"),
                  (0.026, 0.092, "body"), (0.026, 0.108, "body"), (0.040, 0.109, "mark"),
                  (0.040, 0.120, "mark"), (0.020, 0.120, "bore"), (0.020, 0.110, "bore"),
                  (0, 0.110, "bore")],
                 radius=0.0015, n=30)
    atlas.paint(pipe, bore=(30, 30, 32), flange=green, mark=YELLOW, body=green)
    bolts = [rod((0.031 * c, 0.031 * s, z), (0.031 * c, 0.031 * s, z + 0.006), 0.005, 6)
             for z in (0.010, 0.104) for c, s in _directions(45, 135, 225, 315)]
    parts = [pipe] + [atlas.paint(bolt, rest=STEEL) for bolt in bolts]
    parts = [part.turned("y", 90).moved([-0.060, 0, 0.040]) for part in parts]
    bonnet = lathe([(0, 0.060), (0.024, 0.060), (0.022, 0.082), (0.030, 0.083, "seat"),
                    (0.030, 0.093, "seat"), (0.016, 0.096), (0.013, 0.114),
                    (0, 0.114)], radius=0.0015, n=24)
    stem = rod((0, 0, 0.112), (0, 0, 0.150), 0.005, 12)
    hub = lathe([(0, 0.132), (0.011, 0.132), (0.011, 0.148), (0, 0.148)], 0.002, n=20)
    wheel = tube(arc((0, 0, 0.140), 0.045, 0, 360, 41, "xy")[:-1], 0.0065, 10, loop=True)
    along = np.arctan2(wheel.corners()[..., 0], -wheel.corners()[..., 1]).min(axis=1)
    wheel.labels = np.where(np.abs(along) < 0.4, "mark", "rim")
    atlas.paint(bonnet, seat=bronze, rest=green)
    atlas.paint(stem, rest=STEEL)
    atlas.paint(hub, rest=GRAPHITE)
    atlas.paint(wheel, mark=WHITE, rest=RED)
    spokes = [rod((0.009 * c, 0.009 * s, 0.140), (0.041 * c, 0.041 * s, 0.140), 0.0042, 8)
              for c, s in _directions(30, 120, 210, 300)]
    parts += [bonnet, stem, hub, wheel] + [atlas.paint(spoke, rest=RED) for spoke in spokes]
    return item(atlas, parts, 0.3, 40)


def connector():
    """A big round plug, lying along x; its pins look towards -x, a key runs along its top."""
    atlas = Atlas()
    sleeve = Print(220, 60, BLUE).rect(0, 0, 40, 60, WHITE).rect(180, 0, 220, 60, (24, 60, 130))
    sleeve.text(60, 26, "32 A", 19, WHITE, 90).text(160, 26, "32 A", 19, WHITE, 270)
    body = lathe([(0, 0.020), (0.027, 0.020, "face"), (0.027, 0, "bore"), (0.0305, 0, "rim"),
                  (0.0305, 0.044, "shroud"), (0.0355, 0.046, "ring"), (0.0355, 0.060, "ring"),
                  (0.031, 0.062, "ring"), (0.030, 0.066, "sleeve"), (0.024, 0.108, "sleeve"),
                  (0.017, 0.114, "gland"), (0.017, 0.132, "gland"), (0.011, 0.140, "gland"),
                  (0, 0.140, "gland")], radius=0.0015, n=44)
    face = Print(54, 54, (230, 230, 226)).disc(27, 12, 6, RED)
    atlas.paint(body, face=(face, "bottom"), bore=GRAPHITE, rim=BLUE, shroud=BLUE, ring=YELLOW,
                sleeve=(sleeve, "around"), gland=RUBBER)
    pins = [rod((0.014 * c, 0.014 * s, 0.018), (0.014 * c, 0.014 * s, 0.004), 0.0042, 12)
            for c, s in _directions(30, 150, 270)]
    key = box(0.010, 0.012, 0.046, 0.002, 5).moved([0, 0.0325, 0.001])
    parts = [body, atlas.paint(key, rest=WHITE)]
    parts += [atlas.paint(pin, rest=(206, 170, 90)) for pin in pins]
    return item(atlas, turned(turned(parts, "x", 90), "z", 90), 0.2, 30)


def screwdriver():
    """Lying along x, the blade towards -x and touching the ground."""
    def flutes(theta, r, z):
        along = np.clip((z - 0.012) / 0.01, 0, 1) * np.clip((0.085 - z) / 0.01, 0, 1)
        return 1 - 0.10 * along * (0.5 + 0.5 * np.cos(6 * theta)) * (r > 0.008)

    handle = lathe([(0, 0), (0.010, 0, "cap"), (0.0165, 0.006, "cap"), (0.0175, 0.020, "grip"),
                    (0.0170, 0.060, "grip"), (0.0150, 0.082, "grip"), (0.0100, 0.092, "neck"),
                    (0.0130, 0.104, "neck"), (0.0075, 0.108, "neck"),
                    (0, 0.108, "neck")], radius=0.003, n=36, step=0.006, shape=flutes)
    grip = Print(110, 76, RED).rect(0, 0, 28, 76, YELLOW).rect(56, 0, 82, 76, RUBBER)
    shaft = tube(np.array([(0, 0, z) for z in np.linspace(0.105, 0.205, 12)]), 0.004, 14)
    blade = loft([(0, 0, 0.200, 0.0040, 0.0040), (0, 0, 0.210, 0.0025, 0.0055),
                  (0, 0, 0.2185, 0.0010, 0.0050)], 14, 3)
    atlas = Atlas(256)
    atlas.paint(handle, cap=YELLOW, grip=(grip, "around"), neck=RUBBER)
    atlas.paint(shaft, rest=STEEL)
    atlas.paint(blade, rest=(110, 112, 118))
    return item(atlas, turned([handle, shaft, blade], "y", -90 - 5.3), 0.4, 70)
