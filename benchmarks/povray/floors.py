"""Pictures of floors, as they look from above: planks, carpet, stone, tiles, concrete."""
import math

import cv2
import numpy as np

from .materials import linear, muted

per_metre = 200  # pixels
kinds = ("wood", "carpet", "stone", "tiles", "concrete")


def patches(rng, shape, scale):
    """Smooth random field, mean 0, deviation 1; `scale` in metres."""
    coarse = [max(2, int(n / (scale * per_metre)) + 2) for n in shape]
    field = cv2.resize(rng.normal(0, 1, coarse).astype(np.float32), shape[::-1], interpolation=cv2.INTER_CUBIC)
    return field / (field.std() + 1e-9)


def cells(rng, shape, length, width, shifted):
    """Number of the plank or tile at each pixel, and how far its nearest edge is (m)."""
    y, x = np.mgrid[0:shape[0], 0:shape[1]] / per_metre
    row = np.floor(y / width).astype(int)
    offset = rng.uniform(0, length, row.max() + 1)[row] if shifted else 0
    column = np.floor((x + offset) / length).astype(int)
    along = (x + offset) % length
    across = y % width
    edge = np.minimum(np.minimum(along, length - along), np.minimum(across, width - across))
    return row * 1009 + column, edge


def toned(rng, number, spread):
    """A brightness factor for each cell."""
    return np.exp(spread * rng.normal(0, 1, 5003)[number % 5003])


def wood(rng, shape):
    colour = linear(rng.uniform(0.05, 0.1), rng.uniform(0.3, 0.65), rng.uniform(0.3, 0.8))
    number, edge = cells(rng, shape, rng.uniform(0.7, 1.8), rng.uniform(0.07, 0.2), True)
    grain = patches(rng, (shape[0], max(8, shape[1] // 20)), 0.008)
    grain = cv2.resize(grain.astype(np.float32), shape[::-1])
    light = toned(rng, number, rng.uniform(0.05, 0.2)) * np.exp(0.1 * grain) * np.where(edge < 0.002, 0.45, 1)
    return light[:, :, None] * colour


def carpet(rng, shape):
    colour = np.array(linear(rng.random(), rng.uniform(0.05, 0.6), rng.uniform(0.2, 0.7)))
    light = np.exp(0.12 * rng.normal(0, 1, shape) + 0.05 * patches(rng, shape, 0.7))
    if rng.random() < 0.4:  # squares laid in turns
        number, edge = cells(rng, shape, 0.5, 0.5, False)
        light = light * np.where(number % 2, rng.uniform(0.85, 1.15), 1) * np.where(edge < 0.003, 0.85, 1)
    return light[:, :, None] * colour


def stone(rng, shape):
    colour = np.array(muted(rng, 0.35, 0.85))
    speckle = sum(patches(rng, shape, s) for s in (0.008, 0.02, 0.05)) * rng.uniform(0.05, 0.14) + 0.07 * patches(rng, shape, 0.4)
    vein = np.exp(-(np.abs(patches(rng, shape, 0.35) + 0.3 * patches(rng, shape, 0.06)) / 0.04) ** 2)
    light = np.exp(speckle - rng.uniform(0, 0.5) * vein)
    if rng.random() < 0.6:
        side = rng.uniform(0.4, 0.8)
        number, edge = cells(rng, shape, side, side, False)
        light *= np.where(edge < 0.003, 0.6, 1) * toned(rng, number, 0.06)
    return light[:, :, None] * colour


def tiles(rng, shape):
    colour = np.array(muted(rng, 0.4, 0.95, 0.4))
    side = rng.uniform(0.15, 0.6)
    number, edge = cells(rng, shape, side * rng.choice([1, 1, 2]), side, rng.random() < 0.3)
    light = toned(rng, number, rng.uniform(0.01, 0.08)) * np.exp(0.03 * patches(rng, shape, 0.03))
    if rng.random() < 0.25:
        light *= np.where(number % 2, rng.uniform(0.3, 0.7), 1)
    grout = np.array(muted(rng, 0.2, 0.8))
    joint = (edge < rng.uniform(0.002, 0.006))[:, :, None]
    return np.where(joint, grout, light[:, :, None] * colour)


def concrete(rng, shape):
    colour = np.array(muted(rng, 0.4, 0.75, 0.12))
    field = 0.1 * patches(rng, shape, 0.8) + 0.06 * patches(rng, shape, 0.15) + 0.05 * patches(rng, shape, 0.01)
    light = np.exp(field)
    for _ in range(rng.integers(0, 6)):  # stains
        y, x = np.mgrid[0:shape[0], 0:shape[1]] / per_metre
        middle, radius = rng.uniform(0, 1, 2) * np.array(shape) / per_metre, rng.uniform(0.05, 0.4)
        light *= 1 - rng.uniform(0.05, 0.3) * np.exp(-((y - middle[0]) ** 2 + (x - middle[1]) ** 2) / radius**2)
    return light[:, :, None] * colour


def write_floor(rng, kind, length, width, file):
    """A picture of the floor, encoded as sRGB is; its lower left corner is the map's origin."""
    shape = (math.ceil(width * per_metre), math.ceil(length * per_metre))
    light = np.clip(globals()[kind](rng, shape), 0, 1)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    cv2.imwrite(str(file), np.round(255 * encoded[:, :, ::-1]).astype(np.uint8), [cv2.IMWRITE_PNG_COMPRESSION, 1])
