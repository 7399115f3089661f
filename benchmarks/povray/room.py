"""Rooms: floor, walls with windows and a door, lamps, sun, furniture along the walls."""
import math

import numpy as np

from . import floors
from .camera import vector
from .materials import linear, muted, paint, rgb
from .things import block, cable, furniture, papers, placed


class Lamp:
    def __init__(self, rng, place, soft):
        self.place, self.soft = np.array(place), soft
        self.width = rng.uniform(0.3, 1.2) if soft else 0.1
        warm = rng.uniform(-1, 1)
        self.colour = np.array([1 + 0.12 * warm, 1, 1 - 0.18 * warm])
        self.power = rng.uniform(0.5, 1.0)

    def pov(self, level=1.0):
        light = self.colour * self.power * level * 0.35
        spread = f"area_light <{self.width:.3f},0,0>, <0,{self.width:.3f},0>, 4, 4 adaptive 0" if self.soft else ""
        half = self.width / 2
        panel = block(self.place + [-half, -half, 0.02], self.place + [half, half, 0.04], f"pigment {{ rgb 1 }} finish {{ diffuse 0 emission {level:.3f} }} no_shadow")
        return f"light_source {{ {vector(self.place)} {rgb(light)} fade_distance 2.5 fade_power 2 {spread} }}\n{panel}\n"


class Room:
    """Length along x, width along y; the map's origin is one corner."""

    def __init__(self, rng, length, width, ceiling, folder, floor=None, lamps=None, door=None):
        self.length, self.width, self.ceiling = length, width, ceiling
        self.floor_kind = floor or str(rng.choice(floors.kinds))
        self.floor_file = folder / "floor.png"
        floors.write_floor(rng, self.floor_kind, length, width, self.floor_file)
        self.gloss = rng.uniform(0.05, 0.35) if self.floor_kind != "carpet" and rng.random() < 0.5 else 0.0
        self.ambient = rng.uniform(0.08, 0.22)
        self.wall, self.skirting = muted(rng, 0.6, 0.95), muted(rng, 0.1, 0.95)
        self.windows, self.door = [], door
        self.sun = None
        self.lamps = self._lamps(rng, lamps or int(rng.integers(1, 5)))
        self.blocked, self.things = [], ""  # circles where nothing else stands: x, y, radius

    def _lamps(self, rng, count):
        places = [(0.5, 0.5)] if count == 1 else [(i, j) for i in (0.27, 0.73) for j in (0.27, 0.73)]
        rng.shuffle(places)
        softs = [True] + [bool(rng.random() < 0.4) for _ in range(count - 1)] if rng.random() < 0.7 else [False] * count
        lamps = []
        for (i, j), soft in zip(places[:count], softs):
            at = [(i + rng.normal(0, 0.05)) * self.length, (j + rng.normal(0, 0.05)) * self.width, self.ceiling - 0.06]
            lamps.append(Lamp(rng, at, soft))
        return lamps

    def add_windows(self, rng, with_sun):
        """In the wall y = width; the sun shines in through them."""
        count = max(1, int(self.length / 3))
        for n in range(count):
            middle = self.length * (n + 0.5) / count + rng.normal(0, 0.1)
            wide = rng.uniform(0.8, 1.6)
            self.windows.append((middle - wide / 2, middle + wide / 2, rng.uniform(0.4, 1.0), min(self.ceiling - 0.3, rng.uniform(2.0, 2.4))))
        if with_sun:
            self.sun = [math.radians(rng.uniform(-130, -50)), math.radians(rng.uniform(28, 50))]  # where its light goes, how steeply
            self.sun_power = rng.uniform(0.5, 1.5)

    def furnish(self, rng, count, keep_free):
        """Furniture along the walls; `keep_free` are circles x, y, radius that stay empty."""
        for _ in range(count):
            make, size = furniture[str(rng.choice(list(furniture)))]
            size = np.array(size) * rng.uniform(0.85, 1.15, 2)
            wall = rng.integers(0, 4)
            along, yaw = (self.length, (0, math.pi)[wall // 2]) if wall % 2 == 0 else (self.width, (math.pi / 2, -math.pi / 2)[wall // 2])
            t, deep = rng.uniform(0.15, 0.85) * along, size[1] / 2 + 0.04
            x, y = [(t, self.width - deep), (deep, t), (t, deep), (self.length - deep, t)][wall]
            radius = np.hypot(*size) / 2
            if all(math.hypot(x - a, y - b) > radius + r for a, b, r in [*self.blocked, *keep_free]):
                self.things += placed(make(rng, size), x, y, yaw)
                self.blocked.append((x, y, radius))

    def litter(self, rng):
        """Cables and papers that lie there all the time."""
        for _ in range(rng.integers(0, 3)):
            ends = rng.uniform([0.2, 0.2], [self.length - 0.2, self.width - 0.2], (2, 2))
            self.things += cable(rng, *ends)
        if rng.random() < 0.4:
            self.things += papers(rng, *rng.uniform([0.6, 0.6], [self.length - 0.6, self.width - 0.6]))

    def walls(self):
        """Corners of the outline, for the site file."""
        return [[0, 0], [self.length, 0], [self.length, self.width], [0, self.width], [0, 0]]

    def slabs(self):
        """Walls around door and windows, and the ceiling, as plain boxes: far quicker to render than one with holes."""
        length, width, top, thick = self.length, self.width, self.ceiling, 0.2
        slabs = [([-thick, -thick, top], [length + thick, width + thick, top + thick]), ([-thick, -thick, -0.06], [0, width + thick, top]),
                 ([length, -thick, -0.06], [length + thick, width + thick, top])]
        doors = [(self.door - 0.5, self.door + 0.5, -0.05, 2.1)] if self.door else []
        for y, holes in ((-thick, doors), (width, self.windows)):
            left = -thick
            for a, b, low, high in holes:
                slabs += [([left, y, -0.06], [a, y + thick, top]), ([a, y, -0.06], [b, y + thick, low]), ([a, y, high], [b, y + thick, top])]
                left = b
            slabs.append(([left, y, -0.06], [length + thick, y + thick, top]))
        return slabs

    def solids(self):
        """All but the floor and the lights."""
        wall = f"texture {{ pigment {{ bozo scale 1.5 color_map {{ [0 {rgb(self.wall)}] [1 {rgb(np.array(self.wall) * 0.93)}] }} }} }}"
        text = "".join(block(low, high, wall) + "\n" for low, high in self.slabs())
        for low, high in (([0, 0, 0], [self.length, 0.012, 0.08]), ([0, self.width - 0.012, 0], [self.length, self.width, 0.08]),
                          ([0, 0, 0], [0.012, self.width, 0.08]), ([self.length - 0.012, 0, 0], [self.length, self.width, 0.08])):
            if not (self.door and low[1] == 0 and high[1] < 0.1):
                text += block(low, high, paint(self.skirting)) + "\n"
        frame = paint((0.8, 0.8, 0.8))
        for a, b, low, high in self.windows:
            middle = (a + b) / 2
            text += block([middle - 0.03, self.width + 0.05, low], [middle + 0.03, self.width + 0.1, high], frame)
            text += block([a, self.width + 0.05, (low + high) / 2 - 0.025], [b, self.width + 0.1, (low + high) / 2 + 0.025], frame) + "\n"
        return text + self.things

    def floor(self):
        gloss = f"reflection {{ 0.01, {self.gloss:.3f} fresnel on }} conserve_energy specular {self.gloss:.3f} roughness 0.02" if self.gloss else ""
        pigment = f'image_map {{ png "{self.floor_file.name}" gamma srgb interpolate 2 }} scale <{self.length:.4f},{self.width:.4f},1>'
        return (f"box {{ <-0.3,-1.5,-0.1>, <{self.length + 0.3:.3f},{self.width + 0.3:.3f},0> texture {{ pigment {{ {pigment} }} finish {{ diffuse 0.85 {gloss} }} }} "
                "interior { ior 1.5 } }\n")

    def lights(self, levels=None, sun=None):
        levels = levels or [1.0] * len(self.lamps)
        text = "".join(lamp.pov(level) for lamp, level in zip(self.lamps, levels))
        sun = sun or self.sun
        if sun:
            along = np.array([math.cos(sun[1]) * math.cos(sun[0]), math.cos(sun[1]) * math.sin(sun[0]), -math.sin(sun[1])])
            middle = np.array([self.length / 2, self.width, 1.2])
            text += f"light_source {{ {vector(middle - 50 * along)} {rgb(np.array([1.0, 0.9, 0.75]) * self.sun_power)} parallel point_at {vector(middle)} }}\n"
        return text

    def scene(self, added="", levels=None, sun=None):
        """The whole room, without a camera."""
        mean = 1.0 if levels is None else float(np.mean(levels))
        return ("#version 3.7; global_settings { assumed_gamma 1 max_trace_level 3 adc_bailout 0.015 }\n"
                f"#default {{ finish {{ ambient {0.25 * self.ambient * mean:.4f} diffuse 0.8 }} }}\n"
                f"background {{ {rgb(np.array(linear(0.58, 0.25, 0.95)) * (0.9 if self.windows else 0.1))} }}\n"
                + self.floor() + self.solids() + self.lights(levels, sun) + added)

    def is_free(self, x, y, radius):
        """Whether a circle is in the room and clear of what stands in it."""
        inside = radius + 0.05 < x < self.length - radius - 0.05 and radius + 0.05 < y < self.width - radius - 0.05
        return inside and all(math.hypot(x - a, y - b) > radius + r + 0.03 for a, b, r in self.blocked)
