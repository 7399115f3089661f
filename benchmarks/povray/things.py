"""What stands and lies in rooms besides robots: people, cartons, chairs, papers, furniture. As POV-Ray's words, places in the map."""
import math

import numpy as np

from .camera import vector
from .materials import any_colour, any_paint, linear, muted, paint


def placed(bodies, x, y, yaw=0.0):
    return f"union {{ {' '.join(bodies)} rotate z*{math.degrees(yaw):.5f} translate {vector([x, y, 0])} }}\n"


def block(low, high, texture):
    return f"box {{ {vector(low)}, {vector(high)} {texture} }}"


def rod(start, end, radius, texture):
    return f"cylinder {{ {vector(start)}, {vector(end)}, {radius:.4f} {texture} }}"


class Person:
    def __init__(self, rng):
        self.height = rng.uniform(1.55, 1.9)
        self.trousers, self.shirt = paint(any_colour(rng, 0.08, 0.6)), paint(any_colour(rng, 0.1, 0.9))
        self.skin = paint(linear(rng.uniform(0.04, 0.08), rng.uniform(0.3, 0.6), rng.uniform(0.35, 0.9)))
        self.hair, self.shoes = paint(linear(rng.uniform(0.03, 0.12), 0.5, rng.uniform(0.05, 0.6))), paint(any_colour(rng, 0.05, 0.4))
        self.girth = rng.uniform(0.9, 1.2)

    def pov(self, x, y, yaw, phase=0.5):
        """`phase` of the walk, rad; 0 is standing with the legs together."""
        swing = 0.22 * math.sin(phase)
        bodies = []
        for side in (-1, 1):
            foot = side * swing
            lift = 0.06 * max(0, math.cos(phase) * side) * abs(math.sin(phase))
            bodies += [f"sphere {{ 0, 1 scale <0.13,0.05,0.045> translate {vector([foot + 0.05, side * 0.1, 0.045 + lift])} {self.shoes} }}",
                       f"cone {{ {vector([foot, side * 0.1, 0.07 + lift])}, 0.055, {vector([foot * 0.4 + 0.03, side * 0.1, 0.47])}, 0.07 {self.trousers} }}",
                       f"cone {{ {vector([foot * 0.4 + 0.03, side * 0.1, 0.47])}, 0.07, {vector([0, side * 0.085, 0.88])}, 0.1 {self.trousers} }}",
                       f"cone {{ {vector([-0.02, side * 0.22, 1.36])}, 0.055, {vector([-foot * 0.5, side * 0.27, 1.1])}, 0.045 {self.shirt} }}",
                       f"cone {{ {vector([-foot * 0.5, side * 0.27, 1.1])}, 0.042, {vector([0.12 - foot * 0.7, side * 0.26, 0.9])}, 0.033 {self.skin} }}",
                       f"sphere {{ {vector([0.14 - foot * 0.7, side * 0.26, 0.86])}, 0.05 {self.skin} }}"]
        bodies += [f"sphere {{ 0, 1 scale <{0.12 * self.girth:.3f},0.19,0.14> translate z*0.92 {self.trousers} }}",
                   f"cone {{ z*0.92, 0.15, z*1.3, 0.18 scale <{0.75 * self.girth:.3f},1,1> {self.shirt} }}",
                   f"sphere {{ 0, 1 scale <{0.13 * self.girth:.3f},0.23,0.15> translate z*1.3 {self.shirt} }}",
                   f"cylinder {{ z*1.4, z*1.52, 0.055 {self.skin} }}",
                   f"sphere {{ 0, 1 scale <0.1,0.08,0.12> translate <0.01,0,1.6> {self.skin} }}",
                   f"sphere {{ 0, 1 scale <0.1,0.085,0.11> translate <-0.02,0,1.635> {self.hair} }}"]
        return f"union {{ {' '.join(bodies)} scale {self.height / 1.745:.4f} rotate z*{math.degrees(yaw):.4f} translate {vector([x, y, 0])} }}\n"


def carton(rng, x, y):
    size = rng.uniform([0.25, 0.25, 0.25], [0.6, 0.5, 0.8])
    brown = paint(linear(0.08 + rng.normal(0, 0.01), rng.uniform(0.3, 0.55), rng.uniform(0.4, 0.75)))
    tape = paint(linear(0.1, 0.3, rng.uniform(0.5, 0.9)))
    bodies = [block([-size[0] / 2, -size[1] / 2, 0], [size[0] / 2, size[1] / 2, size[2]], brown),
              block([-size[0] / 2 - 0.001, -0.03, size[2] - 0.08], [size[0] / 2 + 0.001, 0.03, size[2] + 0.001], tape)]
    return placed(bodies, x, y, rng.uniform(0, math.pi))


def chair(rng, x, y):
    seat, frame = any_paint(rng), paint(muted(rng, 0.1, 0.8))
    bodies = [block([-0.21, -0.21, 0.43], [0.21, 0.21, 0.47], seat), block([-0.22, -0.2, 0.62], [-0.19, 0.2, 0.9], seat)]
    bodies += [rod([i * 0.19, j * 0.19, 0], [i * 0.19, j * 0.19, 0.44], 0.014, frame) for i in (-1, 1) for j in (-1, 1)]
    bodies += [rod([-0.2, j * 0.19, 0.44], [-0.205, j * 0.19, 0.88], 0.014, frame) for j in (-1, 1)]
    return placed(bodies, x, y, rng.uniform(-math.pi, math.pi))


def papers(rng, x, y):
    """A few sheets on the floor."""
    sheets = ""
    for n in range(rng.integers(2, 7)):
        white = paint(linear(rng.random(), 0.05 if rng.random() < 0.7 else 0.5, rng.uniform(0.7, 0.97)))
        at = rng.normal(0, 0.3, 2)
        low = 0.0006 * (n + 1)
        sheets += placed([block([-0.148, -0.105, low], [0.148, 0.105, low + 0.0004], white)], x + at[0], y + at[1], rng.uniform(0, math.pi))
    return sheets


def cable(rng, start, end):
    """On the floor, in bends."""
    start, end = np.array(start), np.array(end)
    count = 7
    points = [start + (end - start) * t + rng.normal(0, 0.12, 2) * (0 < t < 1) for t in np.linspace(0, 1, count)]
    points = [points[0] - (points[1] - points[0])] + points + [points[-1] + (points[-1] - points[-2])]
    radius = rng.uniform(0.003, 0.007)
    knots = ", ".join(f"{vector([*p, radius])}, {radius:.4f}" for p in points)
    return f"sphere_sweep {{ cubic_spline {len(points)}, {knots} tolerance 0.001 {paint(any_colour(rng, 0.03, 0.9))} }}\n"


def table(rng, size):
    top, legs = any_paint(rng, muted(rng, 0.25, 0.95, 0.6)), paint(muted(rng, 0.1, 0.7))
    a, b = size[0] / 2, size[1] / 2
    bodies = [block([-a, -b, 0.71], [a, b, 0.74], top)]
    bodies += [block([i * (a - 0.05) - 0.025, j * (b - 0.05) - 0.025, 0], [i * (a - 0.05) + 0.025, j * (b - 0.05) + 0.025, 0.71], legs) for i in (-1, 1) for j in (-1, 1)]
    bodies.append(block([-0.2, -0.1, 0.74], [0.2, -0.05, 1.05], paint((0.02, 0.02, 0.02), "gloss")))
    return bodies


def shelf(rng, size):
    wood = any_paint(rng, muted(rng, 0.3, 0.9, 0.6))
    a, b, tall = size[0] / 2, size[1] / 2, rng.uniform(0.8, 1.9)
    bodies = [block([s * a - 0.012, -b, 0], [s * a + 0.012, b, tall], wood) for s in (-1, 1)]
    for level in np.arange(0.05, tall, 0.36):
        bodies.append(block([-a, -b, level], [a, b, level + 0.02], wood))
        for x in np.arange(-a + 0.05, a - 0.15, 0.13):
            if rng.random() < 0.6:
                bodies.append(block([x, -b * 0.8, level + 0.02], [x + rng.uniform(0.04, 0.12), b * 0.8, level + rng.uniform(0.15, 0.3)], paint(any_colour(rng))))
    return bodies


def cabinet(rng, size):
    a, b, tall = size[0] / 2, size[1] / 2, rng.uniform(0.6, 1.8)
    colour = muted(rng, 0.25, 0.95, 0.6)
    return [block([-a, -b, 0], [a, b, tall], any_paint(rng, colour)), block([-0.004, -b - 0.003, 0.05], [0.004, b + 0.003, tall - 0.04], paint((0.03, 0.03, 0.03)))]


def plant(rng, size):
    pot, leaf = paint(muted(rng, 0.3, 0.8, 0.7)), linear(rng.uniform(0.22, 0.38), 0.6, rng.uniform(0.25, 0.5))
    bodies = [f"cone {{ 0, 0.12, z*0.3, 0.17 {pot} }}"]
    for _ in range(14):
        tip = np.array([*rng.normal(0, 0.16, 2), rng.uniform(0.45, 1.2)])
        bodies.append(f"cone {{ z*0.28, 0.008, {vector(tip)}, 0.012 {paint(leaf)} }}")
        bodies.append(f"sphere {{ 0, 1 scale <0.11,0.05,0.02> rotate z*{rng.uniform(0, 360):.1f} translate {vector(tip)} {paint(leaf)} }}")
    return bodies


furniture = {"table": (table, (1.2, 0.7)), "shelf": (shelf, (0.9, 0.32)), "cabinet": (cabinet, (0.9, 0.45)), "plant": (plant, (0.4, 0.4))}
