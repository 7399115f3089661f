"""Robots of several kinds, as solids that POV-Ray draws and as the parts of a site file."""
import math

import numpy as np

from .materials import any_colour, any_paint, dark_paint, mask_paint, paint
from .camera import vector

kinds = ("tracked", "rover", "vacuum", "cart", "mast", "torso")


class Part:
    """One convex solid: what POV-Ray draws, its entry in a site file, and corners that span it (m, robot frame)."""

    def __init__(self, solid, entry, corners, texture):
        self.solid, self.entry, self.corners, self.texture = solid, entry, np.array(corners, float), texture

    def moved(self, shift):
        entry = dict(self.entry)
        if "at" in entry:
            entry["at"] = rounded(np.array(entry["at"]) + shift)
        else:
            entry["points"] = [rounded(np.array(p) + shift) for p in entry["points"]]
        return Part(f"object {{ {self.solid} translate {vector(shift)} }}", entry, self.corners + shift, self.texture)


def rounded(values):
    return [round(float(v), 4) for v in values]


def ring(diameter, z, count=16):
    angles = np.arange(count) * 2 * math.pi / count
    return np.column_stack([diameter / 2 * np.cos(angles), diameter / 2 * np.sin(angles), np.full(count, z)])


def box(size, at, texture, yaw=0.0):
    half = np.array(size) / 2
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    corners = [turn @ (half * [i, j, k]) + at for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    entry = {"box": rounded(size), "at": rounded(at)}
    if yaw:
        entry["yaw_deg"] = round(math.degrees(yaw), 3)
    return Part(f"box {{ {vector(-half)}, {vector(half)} rotate z*{math.degrees(yaw):.5f} translate {vector(at)} }}", entry, corners, texture)


def cylinder(diameter, height, at, texture):
    low, high = np.array(at) - [0, 0, height / 2], np.array(at) + [0, 0, height / 2]
    corners = np.vstack([ring(diameter, low[2], 32), ring(diameter, high[2], 32)]) + [at[0], at[1], 0]
    return Part(f"cylinder {{ {vector(low)}, {vector(high)}, {diameter / 2:.5f} }}", {"cylinder": rounded([diameter, height]), "at": rounded(at)}, corners, texture)


def solid(text, points, texture):
    return Part(text, {"points": [rounded(p) for p in points]}, points, texture)


def cone(bottom, top, height, at, texture):
    """A round body that tapers; `at` is its lowest point's middle."""
    points = np.vstack([ring(bottom, 0, 30), ring(top, height, 30)]) + at
    end = np.array(at) + [0, 0, height]
    return solid(f"cone {{ {vector(at)}, {bottom / 2:.5f}, {vector(end)}, {top / 2:.5f} }}", points, texture)


def wheel(diameter, width, at, texture):
    circle = ring(diameter, 0, 24)
    flat = np.column_stack([circle[:, 0], np.zeros(len(circle)), circle[:, 1]])
    side = np.array([0, width / 2, 0])
    points = np.vstack([flat - side, flat + side]) + at
    return solid(f"cylinder {{ {vector(at - side)}, {vector(at + side)}, {diameter / 2:.5f} }}", points, texture)


def ball(radii, at, texture):
    rows = [(0.0, -1.0), (0.0, 1.0)]
    points = [[0, 0, sign] for _, sign in rows]
    for tilt in (-60, -30, 0, 30, 60):
        t = math.radians(tilt)
        points += [[math.cos(t) * math.cos(a), math.cos(t) * math.sin(a), math.sin(t)] for a in np.arange(12) * math.pi / 6]
    points = np.array(points) * radii + at
    return solid(f"sphere {{ 0, 1 scale {vector(radii)} translate {vector(at)} }}", points, texture)


def track(length, width, height, at, texture):
    """A belt around two wheels; `at` is its middle."""
    reach, radius = length / 2 - height / 2, height / 2
    angles = np.radians(np.linspace(-90, 90, 13))
    end = np.column_stack([reach + radius * np.cos(angles), np.zeros(13), radius * np.sin(angles)])
    outline = np.vstack([end, end * [-1, 1, 1]])
    side = np.array([0, width / 2, 0])
    points = np.vstack([outline - side, outline + side]) + at
    text = f"union {{ box {{ {vector([-reach, -width / 2, -radius])}, {vector([reach, width / 2, radius])} }}"
    for x in (-reach, reach):
        text += f" cylinder {{ {vector([x, -width / 2, 0])}, {vector([x, width / 2, 0])}, {radius:.5f} }}"
    return solid(f"{text} translate {vector(at)} }}", points, texture)


class Robot:
    def __init__(self, kind, parts, is_round):
        low = np.min([p.corners.min(axis=0) for p in parts], axis=0)
        high = np.max([p.corners.max(axis=0) for p in parts], axis=0)
        middle = np.zeros(2) if is_round else (low[:2] + high[:2]) / 2
        self.kind, self.is_round = kind, is_round
        self.parts = [p.moved(np.array([-middle[0], -middle[1], -low[2]])) for p in parts]
        reach = max(np.hypot(p.corners[:, 0], p.corners[:, 1]).max() for p in self.parts)
        self.size = rounded([2 * reach, high[2] - low[2]] if is_round else high - low)
        self.radius = float(reach)

    def bounding(self):
        return {"shape": "cylinder" if self.is_round else "box", "size": self.size}

    def true_parts(self):
        return {"parts": [p.entry for p in self.parts]}

    def pov(self, pose, texture=None):
        """At pose x, y, yaw; all of one texture if it is given."""
        bodies = "".join(f"object {{ {p.solid} {texture or p.texture} }}\n" for p in self.parts)
        return f"union {{ {bodies} rotate z*{math.degrees(pose[2]):.6f} translate {vector([pose[0], pose[1], 0])} }}\n"

    def corners(self, pose):
        """Of each part, in the map."""
        c, s = math.cos(pose[2]), math.sin(pose[2])
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        return [p.corners @ turn.T + [pose[0], pose[1], 0] for p in self.parts]

    def outline(self, pose):
        """Corners of the bounding box (or of a box around the cylinder) in the map, the lower four first."""
        length, width = (self.size[0], self.size[0]) if self.is_round else self.size[:2]
        c, s = math.cos(pose[2]), math.sin(pose[2])
        return np.array([[pose[0] + c * x - s * y, pose[1] + s * x + c * y, z] for z in (0, self.size[-1])
                         for x, y in ((length / 2, width / 2), (-length / 2, width / 2), (-length / 2, -width / 2), (length / 2, -width / 2))])

    def mask(self, camera, pose, folder, others=""):
        """Pixels of the picture in which the robot is seen; `others` (which must not shine) may stand before it."""
        scene = "#version 3.7; global_settings { assumed_gamma 1 ambient_light 0 } background { rgb 0 }\n"
        picture = camera.picture(scene + others + self.pov(pose, mask_paint), folder, smooth=0)
        return picture[:, :, 2] > 1.5


def random_robot(rng, kind, is_round=None):
    """`is_round`: described as a cylinder; by chance where not given."""
    round_kinds = {"vacuum": 1.0, "torso": 0.5}
    if is_round is None:
        is_round = rng.random() < round_kinds.get(kind, 0)
    return Robot(kind, globals()[kind](rng), is_round)


def tracked(rng):
    length, width = rng.uniform(0.3, 0.9), rng.uniform(0.65, 1.0)
    width *= length
    height, across = length * rng.uniform(0.22, 0.4), width * rng.uniform(0.14, 0.24)
    rubber, hull = dark_paint if rng.random() < 0.6 else any_paint(rng), any_paint(rng)
    side = width / 2 - across / 2
    parts = [track(length, across, height, np.array([0, y, height / 2]), rubber) for y in (-side, side)]
    low, high = height * rng.uniform(0.2, 0.4), height * rng.uniform(1.0, 1.7)
    parts.append(box([length * rng.uniform(0.7, 0.95), width - 2 * across, high - low], np.array([0, 0, (low + high) / 2]), hull))
    if rng.random() < 0.6:
        deck = np.array([length * rng.uniform(0.3, 0.5), width * rng.uniform(0.3, 0.6), length * rng.uniform(0.08, 0.3)])
        parts.append(box(deck, np.array([length * rng.uniform(-0.15, 0.15), 0, high + deck[2] / 2]), any_paint(rng)))
    if rng.random() < 0.5:
        parts += [box([length * 0.3, 0.04, 0.04], np.array([length * 0.45, y, high * 0.8]), any_paint(rng)) for y in (-width * 0.2, width * 0.2)]
    return parts


def rover(rng):
    length, width = rng.uniform(0.3, 1.0), rng.uniform(0.6, 0.9)
    width *= length
    tyre = length * rng.uniform(0.18, 0.32)
    across = tyre * rng.uniform(0.3, 0.6)
    axles = [-1, 1] if rng.random() < 0.6 else [-1, 0, 1]
    reach = length / 2 - tyre / 2
    rubber, hull = dark_paint if rng.random() < 0.7 else any_paint(rng), any_paint(rng)
    parts = [wheel(tyre * (1 if a else 0.98), across, np.array([a * reach, y * (width - across) / 2, tyre / 2 * (1 if a else 0.98)]), rubber) for a in axles for y in (-1, 1)]
    low, tall = tyre * rng.uniform(0.3, 0.7), length * rng.uniform(0.15, 0.35)
    parts.append(box([length * rng.uniform(0.8, 1.0), width - 2 * across - 0.01, tall], np.array([0, 0, low + tall / 2]), hull))
    top = low + tall
    if rng.random() < 0.7:
        deck = [length * rng.uniform(0.4, 0.9), width * rng.uniform(0.5, 0.95), length * rng.uniform(0.02, 0.12)]
        parts.append(box(deck, np.array([0, 0, top + deck[2] / 2]), any_paint(rng)))
        top += deck[2]
    if rng.random() < 0.6:
        parts.append(cylinder(0.03 + 0.03 * length, length * 0.3, np.array([length * 0.3, 0, top + length * 0.15]), paint((0.3, 0.3, 0.3))))
        parts.append(box([0.05, 0.12 * length + 0.03, 0.05], np.array([length * 0.3, 0, top + length * 0.3 + 0.025]), any_paint(rng)))
    return parts


def vacuum(rng):
    diameter = rng.uniform(0.25, 0.55)
    height, gap = rng.uniform(0.07, 0.16) + 0.2 * (diameter - 0.25), 0.012
    hull = any_paint(rng)
    parts = [wheel(0.06, 0.02, np.array([0, y * diameter * 0.35, 0.03]), dark_paint) for y in (-1, 1)]
    parts.append(cylinder(diameter, height * 0.75, np.array([0, 0, gap + height * 0.375]), hull))
    parts.append(cylinder(diameter * rng.uniform(0.85, 0.97), height * 0.25, np.array([0, 0, gap + height * 0.875]), any_paint(rng) if rng.random() < 0.5 else hull))
    top = gap + height
    if rng.random() < 0.7:
        parts.append(cylinder(diameter * rng.uniform(0.2, 0.35), 0.03, np.array([-diameter * rng.uniform(0, 0.2), 0, top + 0.015]), any_paint(rng)))
    parts.append(cylinder(0.04, 0.004, np.array([diameter * 0.3, 0, top + 0.002]), paint(any_colour(rng, 0.5))))
    return parts


def cart(rng):
    length, width = rng.uniform(0.5, 1.2), rng.uniform(0.45, 0.8)
    width *= length
    deck, thick, castor = rng.uniform(0.12, 0.22), rng.uniform(0.03, 0.06), 0.09
    parts = [wheel(castor, 0.03, np.array([x * (length / 2 - 0.09), y * (width / 2 - 0.06), castor / 2]), dark_paint) for x in (-1, 1) for y in (-1, 1)]
    parts += [box([0.06, 0.05, deck - 0.06], np.array([x * (length / 2 - 0.09), y * (width / 2 - 0.06), 0.06 + (deck - 0.06) / 2]), paint((0.2, 0.2, 0.2))) for x in (-1, 1) for y in (-1, 1)]
    parts.append(box([length, width, thick], np.array([0, 0, deck + thick / 2]), any_paint(rng)))
    top = deck + thick
    tall = rng.uniform(0.8, 1.05) if rng.random() < 0.7 else 0
    metal = paint((0.45, 0.45, 0.47), "metal" if rng.random() < 0.5 else "plastic")
    if tall:
        parts += [cylinder(0.03, tall - top, np.array([-length / 2 + 0.03, y * (width / 2 - 0.05), (tall + top) / 2]), metal) for y in (-1, 1)]
        parts.append(box([0.035, width - 0.06, 0.035], np.array([-length / 2 + 0.03, 0, tall]), metal))
    for _ in range(rng.integers(1, 4)):
        load = np.array([length * rng.uniform(0.3, 0.75), width * rng.uniform(0.4, 0.9), rng.uniform(0.1, 0.3)])
        room = (np.array([length - 0.1, width]) - load[:2]) / 2 * 0.9
        brown = (0.32, 0.19, 0.09) if rng.random() < 0.5 else any_colour(rng)
        parts.append(box(load, np.array([0.04 + rng.uniform(-1, 1) * room[0], rng.uniform(-1, 1) * room[1], top + load[2] / 2]), paint(brown)))
        top += load[2]
    return parts


def mast(rng):
    length, width, tall = rng.uniform(0.35, 0.6), rng.uniform(0.3, 0.5), rng.uniform(0.7, 1.2)
    foot = rng.uniform(0.12, 0.3)
    tyre = foot * rng.uniform(0.5, 0.9)
    parts = [wheel(tyre, 0.035, np.array([0, y * (width / 2 - 0.0175), tyre / 2]), dark_paint) for y in (-1, 1)]
    parts.append(ball(np.full(3, 0.03), np.array([-length / 2 + 0.06, 0, 0.03]), dark_paint))
    parts.append(box([length, width - 0.08, foot - 0.03], np.array([0, 0, 0.03 + (foot - 0.03) / 2]), any_paint(rng)))
    back = -length * rng.uniform(0, 0.3)
    pole = rng.uniform(0.03, 0.09)
    parts.append(cylinder(pole, tall - foot - 0.1, np.array([back, 0, (foot + tall - 0.1) / 2]), any_paint(rng)))
    if rng.random() < 0.5:
        parts.append(box([length * 0.6, width * 0.8, 0.02], np.array([0, 0, foot + (tall - foot) * rng.uniform(0.3, 0.6)]), any_paint(rng)))
    parts.append(box([0.05, rng.uniform(0.15, 0.28), 0.2], np.array([back, 0, tall - 0.1]), any_paint(rng)))
    return parts


def torso(rng):
    base, tall = rng.uniform(0.35, 0.55), rng.uniform(0.75, 1.2)
    foot = rng.uniform(0.12, 0.25)
    skin, second = any_paint(rng), any_paint(rng)
    parts = [wheel(0.08, 0.03, np.array([0, y * base * 0.3, 0.04]), dark_paint) for y in (-1, 1)]
    parts.append(cylinder(base, foot - 0.015, np.array([0, 0, 0.015 + (foot - 0.015) / 2]), second))
    waist, hip = base * rng.uniform(0.35, 0.55), tall * rng.uniform(0.4, 0.5)
    parts.append(cone(base * rng.uniform(0.6, 0.8), waist, hip - foot, np.array([0, 0, foot]), skin))
    neck = tall * 0.8
    parts.append(cone(waist, base * rng.uniform(0.6, 0.75), neck - hip, np.array([0, 0, hip]), skin))
    head = tall - neck
    parts.append(ball(np.array([head * 0.45, head * 0.42, head * 0.5]), np.array([0, 0, tall - head * 0.5]), second))
    if rng.random() < 0.7:
        shoulder = base * 0.42
        parts += [box([0.06, 0.05, neck - hip], np.array([0.02, y * shoulder, (neck + hip) / 2 - 0.03]), second) for y in (-1, 1)]
        parts += [box([base * 0.4, 0.045, 0.045], np.array([0.02 + base * 0.2, y * shoulder, hip]), second) for y in (-1, 1)]
    return parts
