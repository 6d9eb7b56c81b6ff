"""Training images made worse: what light, clutter and a bad view do to a crop.

Each function takes an RGB image (uint8) and a numpy Generator and returns a new image.
"""

import cv2
import numpy as np

INPUT_PX = 128


def clipped(image):
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def foreground(image):
    """The object in the crop by GrabCut, its border taken for background: [height, width] bool."""
    height, width = image.shape[:2]
    margin = (max(1, width // 20), max(1, height // 20))
    box = (*margin, width - 2 * margin[0], height - 2 * margin[1])
    mask = np.zeros((height, width), np.uint8)
    if min(box[2:]) < 8:
        return np.ones((height, width), bool)
    cv2.setRNGSeed(1)
    cv2.grabCut(image, mask, box, np.zeros((1, 65)), np.zeros((1, 65)), 3, cv2.GC_INIT_WITH_RECT)
    inside = (mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)
    share = inside.mean()
    return inside if 0.15 < share < 0.9 else np.ones((height, width), bool)


def on_other_background(image, mask, background, rng):
    height, width = image.shape[:2]
    if rng.random() < 0.3:
        scene = np.full(image.shape, rng.integers(0, 256, 3), np.uint8)
    else:
        scene = cv2.resize(background, (width, height))
    soft = cv2.GaussianBlur(mask.astype(np.float32), (3, 3), 0)[..., None]
    return clipped(soft * image + (1 - soft) * scene)


def turned_and_cropped(image, rng):
    """Rotated by up to 40 degrees, scaled by up to 15 %, shifted by up to 8 %, perhaps mirrored."""
    height, width = image.shape[:2]
    turn = rng.uniform(-40, 40) if rng.random() < 0.6 else 0.0
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), turn, rng.uniform(0.9, 1.2))
    matrix[:, 2] += rng.uniform(-0.08, 0.08, 2) * (width, height)
    image = cv2.warpAffine(image, matrix, (width, height), borderMode=cv2.BORDER_REPLICATE)
    return image[:, ::-1] if rng.random() < 0.5 else image


def shrunk(image, rng):
    longest = max(image.shape[:2])
    scale = min(1.0, rng.uniform(45, 110) / longest)
    return cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def in_other_light(image, rng):
    """Colour cast, exposure and contrast."""
    cast = rng.uniform(0.8, 1.2, 3)
    exposure = rng.uniform(0.35, 1.0) if rng.random() < 0.4 else rng.uniform(0.8, 1.2)
    return clipped((image * cast * exposure - 128) * rng.uniform(0.8, 1.2) + 128)


def lit_from_a_side(image, rng):
    """Brighter on one side than on the other, as under a lamp."""
    height, width = image.shape[:2]
    azimuth = rng.uniform(0, 2 * np.pi)
    across = (np.linspace(-1, 1, width)[None, :] * np.cos(azimuth) +
              np.linspace(-1, 1, height)[:, None] * np.sin(azimuth))
    return clipped(image * (1 + rng.uniform(0, 0.5) * across)[..., None])


def half_covered(image, rng):
    image = image.copy()
    height, width = image.shape[:2]
    share = rng.uniform(0.3, 0.55)
    cover = rng.choice([0, 255, rng.integers(0, 256)])
    side = rng.integers(4)
    if side == 0:
        image[:round(share * height)] = cover
    elif side == 1:
        image[height - round(share * height):] = cover
    elif side == 2:
        image[:, :round(share * width)] = cover
    else:
        image[:, width - round(share * width):] = cover
    return image


def corner_covered(image, other, rng):
    """Another image over a corner: its own corner as something in front would show, or all of it."""
    image = image.copy()
    height, width = image.shape[:2]
    rows, columns = np.maximum(1, (rng.uniform(0.35, 0.65, 2) * (height, width)).astype(int))
    top = 0 if rng.random() < 0.5 else height - rows
    left = 0 if rng.random() < 0.5 else width - columns
    if rng.random() < 0.7:
        patch = cv2.resize(other, (width, height))[top:top + rows, left:left + columns]
    else:
        patch = cv2.resize(other, (columns, rows))
    image[top:top + rows, left:left + columns] = patch
    return image


def brighter_or_darker(image, rng):
    return clipped(image.astype(float) + rng.choice([-1, 1]) * rng.uniform(40, 150))


def noisy(image, rng):
    return clipped(image + rng.normal(0, rng.uniform(5, 30), image.shape))


def blurred(image, rng):
    size = int(rng.choice([3, 5, 7, 9]))
    return cv2.GaussianBlur(image, (size, size), 0)


def spoilt(image, other, rng):
    """One distortion of the kinds in Hoseini 2021, 5.2, or none."""
    kind = rng.choice(6, p=[0.12, 0.24, 0.28, 0.14, 0.11, 0.11])
    if kind == 1:
        return half_covered(image, rng)
    if kind == 2:
        return corner_covered(image, other, rng)
    return (image, None, None, brighter_or_darker(image, rng), noisy(image, rng),
            blurred(image, rng))[kind]


def resized(image):
    """As the classifier's input: [128, 128, 3]."""
    return cv2.resize(image, (INPUT_PX, INPUT_PX), interpolation=cv2.INTER_LINEAR)


def augmented(image, mask, background, other, rng):
    if mask is not None and rng.random() < 0.5:
        image = on_other_background(image, mask, background, rng)
    image = shrunk(turned_and_cropped(image, rng), rng)
    if rng.random() < 0.5:
        image = lit_from_a_side(image, rng)
    return resized(spoilt(in_other_light(image, rng), shrunk(other, rng), rng))
