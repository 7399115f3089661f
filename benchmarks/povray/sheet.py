"""A sheet of the ten worst pictures, with the truth's outline in green and the fix's in red."""
import json
import math

import cv2
import numpy as np
import yaml

green, red, blue = (0, 200, 0), (0, 0, 255), (255, 120, 0)
tile = (480, 360)


class View:
    """A camera by its exact pose, from world.json."""

    def __init__(self, entry):
        lens = entry["intrinsics"]
        self.matrix = np.array([[lens["fx"], 0, lens["cx"]], [0, lens["fy"], lens["cy"]], [0, 0, 1.0]])
        self.distortion = np.array(entry["distortion"])
        x, y, z, w = entry["pose"]["quaternion"]
        angle = 2 * math.acos(max(-1, min(1, w)))
        axis = np.array([x, y, z]) / max(1e-12, math.sin(angle / 2))
        self.turn = cv2.Rodrigues(axis * angle)[0].T
        self.shift = -self.turn @ np.array(entry["pose"]["position"])

    def pixels(self, points):
        points = np.asarray(points, float)
        behind = (points @ self.turn.T + self.shift)[:, 2] < 0.1
        pixels = cv2.projectPoints(points, cv2.Rodrigues(self.turn)[0], self.shift, self.matrix, self.distortion)[0].reshape(-1, 2)
        return None if behind.any() or np.abs(pixels).max() > 5000 else pixels


def footprint(x, y, yaw, size):
    """Corners of the description's outline on the floor."""
    if len(size) == 2:
        angles = np.arange(24) * math.pi / 12
        return np.column_stack([x + size[0] / 2 * np.cos(angles), y + size[0] / 2 * np.sin(angles)])
    c, s = math.cos(yaw or 0), math.sin(yaw or 0)
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array(size[:2]) / 2
    return half @ np.array([[c, s], [-s, c]]) + [x, y]


def draw(picture, view, pose, size, colour):
    """Floor and top of the outline."""
    flat = footprint(*pose, size)
    for z, width in ((0, 2), (size[-1], 1)):
        pixels = view.pixels(np.column_stack([flat, np.full(len(flat), z)]))
        if pixels is not None:
            cv2.polylines(picture, [np.round(pixels * 16).astype(np.int32)], True, colour, width, cv2.LINE_AA, 4)


def labelled(picture, text):
    scale = min(tile[0] / picture.shape[1], tile[1] / picture.shape[0])
    picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    picture = cv2.copyMakeBorder(picture, 0, tile[1] - picture.shape[0], 0, tile[0] - picture.shape[1], cv2.BORDER_CONSTANT)
    cv2.rectangle(picture, (0, 0), (tile[0], 20), (0, 0, 0), -1)
    cv2.putText(picture, text, (4, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (255, 255, 255), 1, cv2.LINE_AA)
    return picture


def write(pictures, file):
    while len(pictures) < 10:
        pictures.append(np.zeros((tile[1], tile[0], 3), np.uint8))
    cv2.imwrite(str(file), np.vstack([np.hstack(pictures[n:n + 2]) for n in range(0, 10, 2)]))


def badness(row):
    """False fixes and misses are as bad as 60 and 40 cm."""
    if "x" not in row:
        return 0.6 if row["found"] else -1
    return 0.4 if row["error"] is None else row["error"]


def pictures(rows, site, file):
    worst = sorted(rows, key=badness, reverse=True)[:10]
    drawn = []
    for row in worst:
        size = yaml.safe_load(open(row["folder"] / "site.yaml"))["robots"]["r"]["size"]
        view = View(json.load(open(row["folder"] / "world.json"))["cameras"]["cam"])
        picture = cv2.imread(str(row["folder"] / row["image"]))
        if "x" in row:
            draw(picture, view, (row["x"], row["y"], row.get("yaw")), size, green)
        for fix in row["found"]:
            draw(picture, view, (fix["x"], fix["y"], fix["yaw"]), size, red)
        fate = "false fix" if "x" not in row else "not found" if row["error"] is None else f"{100 * row['error']:.0f} cm, NEES {row['nees']:.1f}"
        drawn.append(labelled(picture, f"{row['folder'].name} {row['image'].split('/')[-1]} {row['kind']} {row['what']}: {fate}"))
    write(drawn, file)


def frame_near(folder, camera, time):
    frames = list((folder / "frames" / camera).glob("*"))
    return min(frames, key=lambda f: abs(int(f.stem) / 1e9 - time))


def apart(rows, seconds=0.5):
    """The worst rows, of each robot one in half a second."""
    chosen = []
    for row in sorted(rows, key=lambda r: r["error"], reverse=True):
        if all(c["fix"]["robot"] != row["fix"]["robot"] or abs(c["fix"]["time"] - row["fix"]["time"]) > seconds for c in chosen):
            chosen.append(row)
        if len(chosen) == 10:
            break
    return chosen


def session(rows, folder, world, file):
    sizes = {robot: entry["size"] for robot, entry in yaml.safe_load(open(folder / "site.yaml"))["robots"].items()}
    drawn = []
    for row in apart(rows):
        fix, size = row["fix"], sizes[row["fix"]["robot"]]
        camera = next((c for c in fix["sources"] if c in world["cameras"]), next(iter(world["cameras"])))
        view = View(world["cameras"][camera])
        picture = cv2.imread(str(frame_near(folder, camera, fix["time"])))
        draw(picture, view, row["pose"], size, green)
        draw(picture, view, (fix["x"], fix["y"], fix["yaw"]), size, red)
        drawn.append(labelled(picture, f"{fix['time']:.1f} s {camera} {fix['robot']} {row['phase']}: {100 * row['error']:.0f} cm, NEES {row['nees']:.1f}"))
    write(drawn, file)
