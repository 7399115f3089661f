"""How robots and a person move through a hall without running into one another: along their heading, smoothly."""
import math

import numpy as np

clearance = 0.12  # m, at least, between any two and from what stands there


class Mover:
    def __init__(self, x, y, yaw, radius, fastest, quick):
        self.x, self.y, self.yaw, self.radius, self.fastest, self.quick = x, y, yaw, radius, fastest, quick
        self.speed = self.turn = 0.0
        self.goal, self.until, self.pause = None, -1.0, -1.0

    def gap(self, x, y, radius):
        return math.hypot(self.x - x, self.y - y) - self.radius - radius


def step(mover, obstacles, time, dt):
    """Towards the goal, away from what is near, slower before what lies ahead."""
    want = np.array(mover.goal) - [mover.x, mover.y]
    want = want / (np.linalg.norm(want) + 1e-9)
    free = 10.0
    for x, y, radius in obstacles:
        gap = mover.gap(x, y, radius)
        away = np.array([mover.x - x, mover.y - y]) / (math.hypot(mover.x - x, mover.y - y) + 1e-9)
        side = np.array([-away[1], away[0]])
        want = want + (1.6 * away + 0.5 * side) * math.exp(-max(gap, 0) / 0.18)
        bearing = math.atan2(-away[1], -away[0]) - mover.yaw
        if math.cos(bearing) > 0.3:
            free = min(free, gap)
    error = (math.atan2(want[1], want[0]) - mover.yaw + math.pi) % (2 * math.pi) - math.pi
    speed = 0.0 if time < mover.pause else mover.fastest * max(0.0, math.cos(error)) * min(1.0, max(0.0, (free - clearance - 0.08) / 0.5))
    turn = 0.0 if time < mover.pause else max(-1.3, min(1.3, 1.8 * error)) * mover.quick
    brake = 2.5 if speed < mover.speed else 0.8
    mover.speed += max(-brake * dt, min(0.8 * dt, speed - mover.speed))
    mover.turn += max(-4 * dt, min(4 * dt, turn - mover.turn))
    middle = mover.yaw + mover.turn * dt / 2
    mover.x += mover.speed * dt * math.cos(middle)
    mover.y += mover.speed * dt * math.sin(middle)
    mover.yaw += mover.turn * dt


def wall_points(room, mover, door):
    """The nearest points of the four walls, as obstacles; the door's wall is none to whom is outside or in the door."""
    points = [(0, mover.y, 0), (room.length, mover.y, 0), (mover.x, room.width, 0)]
    if not (abs(mover.x - door) < 0.3 and mover.y < 0.6):
        points.append((mover.x, 0, 0))
    return points


def choose_goal(rng, mover, room, time):
    reached = mover.goal is not None and math.hypot(mover.goal[0] - mover.x, mover.goal[1] - mover.y) < 0.35
    if mover.goal is not None and time < mover.until and not reached:
        return
    margin = mover.radius + 0.4
    for _ in range(100):
        goal = rng.uniform([margin, margin], [room.length - margin, room.width - margin])
        if room.is_free(*goal, mover.radius + 0.2) and math.hypot(goal[0] - mover.x, goal[1] - mover.y) > 1.2:
            break
    mover.goal, mover.until = goal, time + rng.uniform(4, 9)
    if reached and rng.random() < 0.3 and mover.quick == 1.0:
        mover.pause = time + rng.uniform(0.5, 2)


def start_places(rng, room, radii):
    movers = []
    for radius in radii:
        for _ in range(2000):
            x, y = rng.uniform([1.2, 1.2], [room.length - 1.2, room.width - 1.2])
            if room.is_free(x, y, radius + 0.2) and all(m.gap(x, y, radius) > 0.4 for m in movers):
                break
        movers.append(Mover(x, y, rng.uniform(-math.pi, math.pi), radius, rng.uniform(0.4, 0.8), 1.0))
    return movers


def attempt(rng, room, radii, duration, hertz, person_at, door):
    """Poses by moment and mover, the person last; nothing if two came too close."""
    movers = start_places(rng, room, radii)
    person = Mover(door, -1.0, math.pi / 2, 0.32, 1.0, 2.0)
    person.goal, person.until = (door, 1.3), 1e9
    everyone, dt = [*movers, person], 1 / hertz
    for mover in movers:
        mover.speed = mover.fastest / 2
    poses, closest = [], 10.0
    for k in range(round(duration * hertz) + 1):
        time = k * dt
        poses.append([[m.x, m.y, m.yaw] for m in everyone])
        for n, mover in enumerate(everyone):
            if mover is person and time < person_at:
                continue
            if mover is not person or person.y > 0.9:
                choose_goal(rng, mover, room, time)
            others = [(m.x, m.y, m.radius) for m in everyone if m is not mover]
            step(mover, others + room.blocked + wall_points(room, mover, door), time, dt)
            closest = min([closest] + [mover.gap(*o) for o in others + room.blocked])
            if mover is not person or mover.y > 1:
                closest = min(closest, mover.x - mover.radius, mover.y - mover.radius, room.length - mover.radius - mover.x, room.width - mover.radius - mover.y)
    moved = [np.hypot(*np.diff(np.array(poses)[:, n, :2], axis=0).T).sum() for n in range(len(radii))]
    return np.array(poses) if closest > clearance / 3 and min(moved) > 0.15 * duration else None


def drive(rng, room, radii, duration, hertz, person_at, door):
    for _ in range(200):
        poses = attempt(rng, room, radii, duration, hertz, person_at, door)
        if poses is not None:
            return poses
    raise RuntimeError("no way found on which nobody touches: take another seed")
