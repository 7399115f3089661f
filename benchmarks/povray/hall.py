"""A session: a hall with two or three fixed cameras, five or six robots of three kinds, some alike, and a person."""
import concurrent.futures
import json
import math
import pathlib
import tempfile

import numpy as np
import yaml

from . import drive, things
from .camera import Camera, random_lens
from .robots import kinds, random_robot
from .room import Room
from .sensor import Sensor

rate, odometry_rate = 10, 20  # Hz
start = 10.0                  # s, time of the first frame
empty_frames = 10


class Hall:
    def __init__(self, seed, duration, folder, scratch):
        self.rng = np.random.default_rng([seed, 7])
        self.folder, self.scratch, self.duration = folder, scratch, duration
        rng = self.rng
        length, width, ceiling = rng.uniform(7, 9), rng.uniform(5.5, 7), rng.uniform(3.2, 4.2)
        self.door = rng.uniform(0.3, 0.7) * length
        self.room = Room(rng, length, width, ceiling, scratch, lamps=3, door=self.door)
        if rng.random() < 0.5:
            self.room.add_windows(rng, rng.random() < 0.5)
        self.cameras = self.hang_cameras(2 if rng.random() < 0.6 else 3)
        self.room.furnish(rng, 3, [(self.door, 0, 1.2), *[(*c.position[:2], 0.8) for c in self.cameras.values()]])
        self.room.litter(rng)
        self.sensors = {name: self.webcam() for name in self.cameras}
        self.robots = self.choose_robots()
        self.person = things.Person(rng)
        self.person_from = start + duration * rng.uniform(0.3, 0.45)
        dim = start + duration * rng.uniform(0.5, 0.65)
        self.lamp = (dim, dim + duration * 0.25)
        self.dimmed, self.lowest = int(rng.integers(3)), rng.uniform(0.4, 0.65)
        self.ways = self.drive()

    def hang_cameras(self, count):
        room, cameras = self.room, {}
        places = [(0.2, 0.2), (room.length - 0.2, room.width - 0.2), (room.length - 0.2, 0.2)]
        for name, (x, y) in zip(("left", "right", "third"), places[:count]):
            position = [x, y, self.rng.uniform(2.5, room.ceiling - 0.15)]
            target = [*(np.array([room.length, room.width]) * self.rng.uniform(0.42, 0.58, 2)), 0]
            while True:
                size, _, centre, distortion = random_lens(self.rng)
                camera = Camera(size, round(self.rng.uniform(380, 470), 1), centre, distortion, position, target, self.rng.normal(0, 0.01))
                if camera.lens_is_usable():
                    break
            cameras[name] = camera
        return cameras

    def webcam(self):
        sensor = Sensor(self.rng, (480, 640))
        sensor.grey, sensor.jpeg = False, int(self.rng.integers(75, 93))
        return sensor

    def choose_robots(self):
        """Three kinds, none of them larger than 0.8 m across: name to robot."""
        chosen = list(self.rng.permutation([k for k in kinds if k != "cart"])[:2]) + ["cart"]
        counts = [3, 2, 1] if self.rng.random() < 0.5 else [2, 2, 1]
        robots = {}
        for kind, count in zip(chosen, counts):
            while True:
                robot = random_robot(self.rng, str(kind), kind in ("vacuum", "torso"))
                if 0.16 < robot.radius < 0.45:
                    break
            for n in range(count):
                robots[f"{kind}{n + 1}" if count > 1 else str(kind)] = robot
        return robots

    def drive(self):
        radii = [robot.radius for robot in self.robots.values()]
        return drive.drive(self.rng, self.room, radii, self.duration, odometry_rate, self.person_from - start, self.door)

    def pose(self, n, time):
        """Of robot n (the person comes last), at a moment that was simulated."""
        return self.ways[round((time - start) * odometry_rate), n]

    def levels(self, time):
        """Of the lamps: one goes down, stays there and comes back."""
        levels = [1.0] * len(self.room.lamps)
        begin, end = self.lamp
        ramp = (end - begin) / 4
        depth = np.clip(min((time - begin) / ramp, (end - time) / ramp), 0, 1)
        levels[self.dimmed] = float(1 - depth * (1 - self.lowest))
        return levels

    def person_inside(self, time):
        return time >= self.person_from and self.pose(-1, time)[1] > 0.1

    def added(self, time):
        text = "".join(robot.pov(self.pose(n, time)) for n, robot in enumerate(self.robots.values()))
        if time >= self.person_from:
            x, y, yaw = self.pose(-1, time)
            text += self.person.pov(x, y, yaw, 2 * math.pi * (time - start) * 0.9)
        return text

    def write_backgrounds(self):
        for name, camera in self.cameras.items():
            light = camera.picture(self.room.scene(), self.scratch)
            self.sensors[name].expose(light)
            for n in range(empty_frames):
                picture = self.sensors[name].picture(light, self.rng)
                self.sensors[name].write(self.folder / "background" / name / f"{(n + 1) * 10**8}.jpg", picture)

    def write_frame(self, name, number):
        time = start + number / rate
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / self.room.floor_file.name).symlink_to(self.room.floor_file)
            light = self.cameras[name].picture(self.room.scene(self.added(time), self.levels(time)), folder)
        noise = np.random.default_rng([number, *name.encode()])
        self.sensors[name].write(self.folder / "frames" / name / f"{round(time * 10) * 10**8}.jpg", self.sensors[name].picture(light, noise))

    def write_frames(self):
        jobs = [(name, n) for n in range(round(self.duration * rate)) for name in self.cameras]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for done, _ in enumerate(pool.map(lambda job: self.write_frame(*job), jobs)):
                if done % 20 == 19:
                    print(f"{done + 1} of {len(jobs)} frames", flush=True)

    def write_truth(self):
        lines = ["time,robot,x,y,yaw"]
        for number in range(round(self.duration * rate)):
            time = start + number / rate
            for n, name in enumerate(self.robots):
                x, y, yaw = self.pose(n, time)
                lines.append(f"{time:.3f},{name},{x:.6f},{y:.6f},{wrapped(yaw):.6f}")
            if self.person_inside(time):
                x, y, _ = self.pose(-1, time)
                lines.append(f"{time:.3f},unknown-1,{x:.6f},{y:.6f},")
        (self.folder / "truth.csv").write_text("\n".join(lines) + "\n")

    def write_odometry(self):
        """Dead reckoning with a scale error of 2 % and a gyro that drifts, each robot in a frame of its own."""
        lines = []
        for n, name in enumerate(self.robots):
            scale, turn, drift = 1 + self.rng.normal(0, 0.02), 1 + self.rng.normal(0, 0.01), self.rng.normal(0, 0.01)
            x, y, yaw, way = 0.0, 0.0, 0.0, self.ways[:, n]
            for k in range(len(way)):
                if k:
                    step = way[k] - way[k - 1]
                    middle = (way[k, 2] + way[k - 1, 2]) / 2
                    ahead = (step[0] * math.cos(middle) + step[1] * math.sin(middle)) * scale * (1 + self.rng.normal(0, 0.01))
                    swing = step[2] * turn + drift / odometry_rate + self.rng.normal(0, 2e-4)
                    x, y, yaw = x + ahead * math.cos(yaw + swing / 2), y + ahead * math.sin(yaw + swing / 2), yaw + swing
                lines.append((k, n, f"{start + k / odometry_rate:.3f},{name},{x:.5f},{y:.5f},{wrapped(yaw):.5f}"))
        (self.folder / "odometry.csv").write_text("\n".join(["time,robot,x,y,yaw"] + [text for *_, text in sorted(lines)]) + "\n")

    def floor_points(self, camera):
        points = []
        for x in np.arange(0.9, self.room.length - 0.5, 1.5):
            for y in np.arange(0.9, self.room.width - 0.5, 1.2):
                if camera.sees([[x, y, 0]], 8)[0]:
                    pixel = camera.project([[x, y, 0]])[0] + self.rng.normal(0, 0.5, 2)
                    points.append({"pixel": [round(float(p), 2) for p in pixel], "map": [round(float(x), 3), round(float(y), 3)]})
        return points

    def write_site(self):
        cameras = {name: {"source": f"frames/{name}", "background": f"background/{name}", **camera.site_entry(), "floor_points": self.floor_points(camera)}
                   for name, camera in self.cameras.items()}
        walls = [[[round(float(v), 3) for v in corner] for corner in self.room.walls()]]
        site = {"roomfix": 1, "site": {"name": self.folder.name, "walls": walls}, "cameras": cameras,
                "robots": {name: {**robot.bounding(), "drive": "differential"} for name, robot in self.robots.items()}}
        (self.folder / "site.yaml").write_text(yaml.safe_dump(site, sort_keys=False, default_flow_style=None, width=160))
        world = {"person_from": self.person_from, "lamp": self.lamp, "floor": self.room.floor_kind, "robots": {name: robot.kind for name, robot in self.robots.items()},
                 "cameras": {name: {**c.site_entry(), "pose": {"position": c.position.tolist(), "quaternion": [float(q) for q in c.quaternion()]}}
                             for name, c in self.cameras.items()}}
        (self.folder / "world.json").write_text(json.dumps(world, indent=0))


def wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def write_hall(folder, seed, duration):
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        hall = Hall(seed, duration, folder, pathlib.Path(scratch))
        hall.write_site()
        hall.write_truth()
        hall.write_odometry()
        hall.write_backgrounds()
        hall.write_frames()
