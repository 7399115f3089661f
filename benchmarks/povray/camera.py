"""Cameras: OpenCV's model (pixel (0, 0) is the middle of the top-left pixel, plumb_bob distortion) and the same view in POV-Ray.

POV-Ray renders a wider picture without distortion, in linear light, which is then warped to the lens.
"""
import math
import pathlib
import subprocess

import cv2
import numpy as np

oversampling = 1.0  # pixels of the wide picture per pixel of the camera, in the middle
full_scale = 3.0    # linear light 1 is a white wall well lit; brighter than this is cut off


class Camera:
    def __init__(self, size, focal, centre, distortion, position, target, roll=0.0):
        self.width, self.height = size
        self.matrix = np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1.0]])
        self.distortion = np.array(distortion, float)
        self.position = np.array(position, float)
        self.turn = looking(self.position, np.array(target, float), roll)  # columns: right, down, forward in the map
        self._plan()

    def _plan(self):
        """Size of the wide picture and where each pixel of the camera lies in it."""
        u, v = np.meshgrid(np.arange(self.width, dtype=float), np.arange(self.height, dtype=float))
        rays = self.rays(np.stack([u.ravel(), v.ravel()], 1))
        self.wide_focal = oversampling * self.matrix[0, 0]
        margin = 4 / self.wide_focal
        half = np.abs(rays).max(axis=0) + margin
        self.wide_size = [2 * math.ceil(self.wide_focal * h) for h in half]
        middle = (np.array(self.wide_size) - 1) / 2
        places = (rays * self.wide_focal + middle).astype(np.float32).reshape(self.height, self.width, 2)
        self.places = places

    def rays(self, pixels):
        """Ideal image coordinates (x / z, y / z) of pixels."""
        exact = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
        points = np.asarray(pixels, float).reshape(-1, 1, 2)
        return cv2.undistortPointsIter(points, self.matrix, self.distortion, None, None, exact).reshape(-1, 2)

    def lens_is_usable(self):
        """Whether the distortion can be undone everywhere and the wide picture stays small."""
        edge = [[u, v] for u in np.linspace(0, self.width - 1, 30) for v in (0, self.height - 1)]
        edge += [[u, v] for v in np.linspace(0, self.height - 1, 30) for u in (0, self.width - 1)]
        rays = self.rays(edge)
        there = self.turn @ np.column_stack([rays, np.ones(len(rays))]).T + self.position[:, None]
        wrong = np.abs(self.project(there.T) - edge).max()
        return wrong < 0.01 and self.wide_size[0] * self.wide_size[1] < 2.2 * self.width * self.height

    def vectors(self):
        """Rotation vector and translation of camera_from_map."""
        turn = self.turn.T
        return cv2.Rodrigues(turn)[0], -turn @ self.position

    def project(self, points):
        """Pixels of points in the map, one row each; far outside for those behind the camera."""
        points = np.asarray(points, float).reshape(-1, 3)
        turn, shift = self.vectors()
        pixels = cv2.projectPoints(points, turn, shift, self.matrix, self.distortion)[0].reshape(-1, 2)
        ideal = (points - self.position) @ self.turn
        outside = (ideal[:, 2] < 0.05) | (np.abs(ideal[:, :2]) > 3 * np.abs(ideal[:, 2:])).any(axis=1)
        pixels[outside] = -1e5
        return pixels

    def inside(self, points, margin=4.0):
        pixels = self.project(points)
        return bool((pixels > margin).all() and (pixels < [self.width - margin, self.height - margin]).all())

    def sees(self, points, margin=4.0):
        """For each point whether it is in the picture."""
        pixels = self.project(points)
        return ((pixels > margin) & (pixels < [self.width - margin, self.height - margin])).all(axis=1)

    def quaternion(self):
        """Of map_from_camera, [x, y, z, w]."""
        axis = cv2.Rodrigues(self.turn)[0].ravel()
        angle = np.linalg.norm(axis)
        return [*(axis / angle * math.sin(angle / 2)), math.cos(angle / 2)]

    def pov(self):
        """Coordinates are those of the map: the vector to the right makes POV-Ray's left-handed world right-handed."""
        across = self.turn[:, 0] * self.wide_size[0] / self.wide_focal
        up = -self.turn[:, 1] * self.wide_size[1] / self.wide_focal
        return f"camera {{ location {vector(self.position)} direction {vector(self.turn[:, 2])} right {vector(across)} up {vector(up)} }}\n"

    def picture(self, scene, folder, smooth=2):
        """Linear light (blue, green, red), as the lens sees it."""
        wide = render(self.pov() + scene, self.wide_size, folder, smooth)
        return np.maximum(cv2.remap(wide, self.places, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), 0)

    def site_entry(self):
        """What the site file says of the lens."""
        m = self.matrix
        return {"size": [self.width, self.height],
                "intrinsics": {"fx": float(m[0, 0]), "fy": float(m[1, 1]), "cx": float(m[0, 2]), "cy": float(m[1, 2])},
                "distortion": [float(d) for d in self.distortion]}


def vector(v):
    return "<" + ",".join(f"{x:.9g}" for x in v) + ">"


def looking(position, target, roll):
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    c, s = math.cos(roll), math.sin(roll)
    return np.column_stack([c * right + s * down, c * down - s * right, forward])


def random_lens(rng, big=False):
    """Size, focal length, principal point and distortion that go together."""
    size = (1280, 720) if big else (640, 480)
    focal = round(rng.uniform(600, 900) if big else rng.uniform(350, 620), 1)
    centre = [round((n - 1) / 2 + rng.uniform(-1, 1) * 0.01 * n, 1) for n in size]
    corner = math.hypot(*size) / 2 / focal  # the distortion bends the corner by up to 12 %
    bend = rng.uniform(-0.12, 0.04) / corner**2
    distortion = [round(bend, 4), round(-0.25 * bend / corner**2 * rng.uniform(0, 1), 4), *np.round(rng.uniform(-6e-4, 6e-4, 2), 5), 0.0]
    return size, focal, centre, distortion


def render(text, size, folder, smooth=2):
    """A scene's linear light by POV-Ray, float32. `folder` is for files that come and go; edges get finer grids with larger `smooth`, 0 for one ray a pixel."""
    folder = pathlib.Path(folder)
    scene, picture = folder / "scene.pov", folder / "scene.png"
    scene.write_text(text)
    edges = [f"+A{0.6 / smooth**2:.3f}", "+AM2", f"+R{smooth}"] if smooth else ["-A"]
    done = subprocess.run(["nice", "-n", "10", "povray", f"+I{scene.name}", f"+O{picture.name}", f"+W{size[0]}", f"+H{size[1]}", "+FN16", *edges, "-J", "-D", "-P",
                           "+WT1", "-V", "File_Gamma=1.0"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError("povray failed: " + done.stderr[-1500:])
    light = cv2.imread(str(picture), cv2.IMREAD_UNCHANGED)
    return light[:, :, :3].astype(np.float32) * (full_scale / 65535)
