"""Single pictures of one robot, whose site file knows only its bounding box, in random rooms with one camera each."""
import json
import math
import pathlib
import tempfile

import numpy as np
import yaml

from . import things
from .camera import Camera, random_lens
from .robots import kinds, random_robot
from .room import Room
from .sensor import Sensor

empty_pictures = 5


def random_camera(rng, room):
    """High up beside a wall, looking into the room."""
    height = min(rng.uniform(1.8, 4.0), room.ceiling - 0.15)
    corner = np.array([rng.choice([0.25, room.length - 0.25]), rng.uniform(0.25, room.width - 0.25)])
    if rng.random() < 0.5:
        corner = np.array([rng.uniform(0.25, room.length - 0.25), 0.25])
    middle = np.array([room.length, room.width]) / 2
    target = corner + (middle - corner) * rng.uniform(0.6, 1.1) + rng.normal(0, 0.3, 2)
    while True:
        size, focal, centre, distortion = random_lens(rng, rng.random() < 0.25)
        camera = Camera(size, focal, centre, distortion, [*corner, height], [*target, rng.uniform(0, 0.5)], rng.normal(0, 0.02))
        if camera.lens_is_usable():
            return camera


def random_room(rng, folder):
    length, width, ceiling = rng.uniform(4, 9), rng.uniform(3.5, 7), rng.uniform(2.4, 4.3)
    room = Room(rng, length, width, ceiling, folder)
    if rng.random() < 0.6:
        room.add_windows(rng, rng.random() < 0.7)
    return room


class World:
    def __init__(self, seed, index, folder, scratch):
        self.rng = np.random.default_rng([seed, index])
        self.folder, self.scratch = folder, scratch
        self.robot = random_robot(self.rng, kinds[index % len(kinds)])
        while True:
            self.room = random_room(self.rng, scratch)
            self.camera = random_camera(self.rng, self.room)
            if len(self.floor_in_sight(40)) >= 25:
                break
        spot = self.camera.position[:2]
        self.room.furnish(self.rng, int(self.rng.integers(1, 7)), [(*spot, 0.8)])
        self.room.litter(self.rng)
        self.pillar = self.add_pillar() if self.rng.random() < 0.3 else None
        self.sensor = Sensor(self.rng, (self.camera.height, self.camera.width))
        self.truth, self.count = [], 0

    def floor_in_sight(self, count, tries=400):
        places = self.rng.uniform([0.3, 0.3], [self.room.length - 0.3, self.room.width - 0.3], (tries, 2))
        seen = self.camera.sees(np.column_stack([places, np.zeros(tries)]), 8)
        return places[seen][:count]

    def add_pillar(self):
        """In sight, from the floor to the ceiling; part of the background."""
        for x, y in self.floor_in_sight(20):
            near = math.hypot(x - self.camera.position[0], y - self.camera.position[1])
            if self.room.is_free(x, y, 0.2) and 1.5 < near < 4:
                half = self.rng.uniform(0.07, 0.16)
                self.room.things += things.block([x - half, y - half, 0], [x + half, y + half, self.room.ceiling], things.paint(self.room.wall)) + "\n"
                self.room.blocked.append((x, y, half * 1.42))
                return x, y, half, self.room.ceiling
        return None

    def place_robot(self, hidden, tries=1500):
        """Pose, occluder and the part of the robot that is seen: nearly all of it, or 35 to 80 %."""
        for n in range(tries):
            x, y = self.floor_in_sight(1)[0]
            pose = [float(x), float(y), float(self.rng.uniform(-math.pi, math.pi))]
            if not self.room.is_free(x, y, self.robot.radius) or not self.big_enough(pose):
                continue
            occluder = ("", "", None)
            if hidden:
                occluder = ("", "pillar", self.pillar) if self.pillar and n < tries // 2 else self.occluder(pose)
                if occluder is None or not 0.2 < self.part_covered(pose, occluder[2]) < 0.75:
                    continue
            seen = self.part_seen(pose, occluder[0])
            if (0.35 < seen < 0.8) if hidden else seen > 0.97:
                return pose, occluder, seen
        return None

    def big_enough(self, pose):
        outline = self.robot.outline(pose)
        pixels = self.camera.project(outline)
        return self.camera.inside(outline, 3) and np.ptp(pixels, axis=0).max() > 28 and np.ptp(pixels, axis=0).min() > 12

    def occluder(self, pose):
        """A carton or a person between the camera and the robot."""
        towards = self.camera.position[:2] - pose[:2]
        distance = np.linalg.norm(towards)
        across = np.array([-towards[1], towards[0]]) / distance
        person = self.rng.random() < 0.5
        radius = 0.3 if person else 0.38
        before = self.robot.radius + radius * 0.8 + self.rng.uniform(0.0, 1.0)
        at = pose[:2] + towards / distance * before + across * self.rng.normal(0, 0.25 + self.robot.radius / 2)
        if before > distance - 0.5 or not self.room.is_free(*at, radius) or math.hypot(*(at - pose[:2])) < self.robot.radius + radius:
            return None
        if person:
            walker = things.Person(self.rng).pov(*at, self.rng.uniform(-math.pi, math.pi), self.rng.uniform(-1.5, 1.5))
            return walker, "person", (*at, 0.2, 1.7)
        return things.carton(self.rng, *at), "carton", (*at, 0.25, 0.5)

    def part_covered(self, pose, upright):
        """Roughly, without rendering: corners behind an upright cylinder x, y, radius, height."""
        corners = np.vstack(self.robot.corners(pose))
        way = corners - self.camera.position
        t = ((np.array(upright[:2]) - self.camera.position[:2]) * way[:, :2]).sum(1) / (way[:, :2] ** 2).sum(1)
        nearest = self.camera.position + way * t[:, None]
        behind = (t > 0) & (t < 1) & (np.hypot(*(nearest[:, :2] - upright[:2]).T) < upright[2]) & (nearest[:, 2] < upright[3])
        return behind.mean()

    def part_seen(self, pose, occluder):
        whole = self.robot.mask(self.camera, pose, self.scratch).sum()
        return self.robot.mask(self.camera, pose, self.scratch, self.room.solids() + occluder).sum() / max(1, whole)

    def write_backgrounds(self):
        light = self.camera.picture(self.room.scene(), self.scratch)
        self.sensor.expose(light)
        for n in range(empty_pictures):
            self.sensor.write(self.folder / "background/cam" / f"{(n + 1) * 10**8}.{self.sensor.suffix}", self.sensor.picture(light, self.rng))

    def frame(self, row, light, gain=1.0, balance=(1, 1, 1)):
        name = f"frames/cam/{10**11 + self.count * 10**8}.{self.sensor.suffix}"
        self.sensor.write(self.folder / name, self.sensor.picture(light, self.rng, gain, balance))
        self.truth.append({"image": name, "camera": "cam", **row})
        self.count += 1

    def factor(self):
        """15 to 30 % up or down."""
        return float(1 + self.rng.choice([-1, 1]) * self.rng.uniform(0.15, 0.3))

    def changed_light(self):
        """Lamp levels, gain and balance of 15 to 30 % each, one or two of them changed."""
        levels, gain, balance, what = [1.0] * len(self.room.lamps), 1.0, np.ones(3), []
        for kind in self.rng.permutation(["exposure", "balance", "lamp"])[:self.rng.integers(1, 3)]:
            what.append(str(kind))
            if kind == "exposure":
                gain = self.factor()
            elif kind == "balance":
                balance[self.rng.choice([0, 2])] = self.factor()
            else:
                levels[self.rng.integers(len(levels))] = self.factor()
        return levels, gain, balance, what

    def robot_frame(self, kind):
        placed = self.place_robot(kind == "hidden")
        if not placed:
            kind = "plain"
            placed = self.place_robot(False)
        if not placed:
            return
        pose, (occluder, what, _), seen = placed
        levels, gain, balance, changes = self.changed_light() if kind == "light" else (None, 1.0, np.ones(3), [])
        light = self.camera.picture(self.room.scene(self.robot.pov(pose) + occluder, levels), self.scratch)
        row = {"x": pose[0], "y": pose[1], "kind": kind, "what": ", ".join(changes) or what, "seen": round(float(seen), 3),
               "distance": float(np.linalg.norm(self.camera.position[:2] - pose[:2])), "outline": self.camera.project(self.robot.outline(pose)).tolist()}
        if not self.robot.is_round:
            row["yaw"] = pose[2]
        self.frame(row, light, gain, balance)

    def empty_frame(self):
        """No robot, but something else."""
        what = str(self.rng.choice(["person", "papers", "chair"] + ["sun"] * (2 if self.room.sun else 0)))
        added, sun = "", None
        free = [p for p in self.floor_in_sight(100) if self.room.is_free(*p, 0.35)]
        if not free and what != "sun":
            what = "papers"
        x, y = free[0] if free else self.floor_in_sight(1)[0]
        if what == "sun":
            sun = [self.room.sun[0] + self.rng.choice([-1, 1]) * math.radians(self.rng.uniform(3, 15)), self.room.sun[1] + math.radians(self.rng.uniform(-6, 6))]
        elif what == "person":
            added = things.Person(self.rng).pov(x, y, self.rng.uniform(-math.pi, math.pi), self.rng.uniform(-1.5, 1.5))
        else:
            added = {"papers": things.papers, "chair": things.chair}[what](self.rng, x, y)
        self.frame({"kind": "empty", "what": what}, self.camera.picture(self.room.scene(added, sun=sun), self.scratch))

    def site(self, robot):
        points = []
        for x, y in self.floor_in_sight(int(self.rng.integers(6, 13))):
            pixel = self.camera.project([[x, y, 0]])[0] + self.rng.normal(0, 0.5, 2)
            points.append({"pixel": [round(float(p), 2) for p in pixel], "map": [float(x), float(y)]})
        return {"roomfix": 1, "site": {"name": self.folder.name},
                "cameras": {"cam": {"source": "frames/cam", "background": "background/cam", **self.camera.site_entry(), "floor_points": points}},
                "robots": {"r": robot}}

    def write_site(self):
        site = self.site(self.robot.bounding())
        (self.folder / "site.yaml").write_text(yaml.safe_dump(site, sort_keys=False, default_flow_style=None, width=160))
        site["robots"]["r"] = self.robot.true_parts()
        (self.folder / "site-parts.yaml").write_text(yaml.safe_dump(site, sort_keys=False, default_flow_style=None, width=160))

    def write_truth(self):
        pose = {"position": self.camera.position.tolist(), "quaternion": [float(q) for q in self.camera.quaternion()]}
        world = {"robot": self.robot.kind, "floor": self.room.floor_kind, "gloss": self.room.gloss, "lamps": len(self.room.lamps), "sun": bool(self.room.sun),
                 "grey": bool(self.sensor.grey), "cameras": {"cam": {**self.camera.site_entry(), "pose": pose}}}
        (self.folder / "truth.json").write_text(json.dumps(self.truth, indent=0))
        (self.folder / "world.json").write_text(json.dumps(world, indent=0))


def write_worlds(folder, count, seed):
    for index in range(count):
        with tempfile.TemporaryDirectory() as scratch:
            world = World(seed, index, folder / f"world-{index + 1:03d}", pathlib.Path(scratch))
            world.write_backgrounds()
            for kind in ["plain", "light", "hidden", str(world.rng.choice(["plain", "light", "hidden"]))]:
                world.robot_frame(kind)
            for _ in range(2):
                world.empty_frame()
            world.write_site()
            world.write_truth()
        print(f"world {index + 1} of {count}: {world.robot.kind} on {world.room.floor_kind}", flush=True)
