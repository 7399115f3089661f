"""Checks that what POV-Ray shows lies where OpenCV's camera model says."""
import tempfile

import cv2
import numpy as np

from .camera import Camera, full_scale, random_lens, vector
from .robots import kinds, random_robot


def random_camera(rng, big):
    while True:
        size, focal, centre, distortion = random_lens(rng, big)
        camera = Camera(size, focal, centre, distortion, [0.3, 0.2, rng.uniform(1.8, 4)], [rng.uniform(2, 4), rng.uniform(2, 4), rng.uniform(0, 0.6)],
                        rng.uniform(-0.05, 0.05))
        if camera.lens_is_usable():
            return camera


def spheres(camera, rng, count=60):
    """Points in the room that are in the picture and apart from each other."""
    chosen, pixels = [], []
    for point in rng.uniform([0.5, 0.5, 0], [9, 9, 1.5], (4000, 3)):
        pixel = camera.project(point)[0]
        if camera.sees([point], 12)[0] and all(np.linalg.norm(pixel - p) > 24 for p in pixels):
            chosen.append(point)
            pixels.append(pixel)
        if len(chosen) == count:
            break
    return np.array(chosen)


def sphere_offsets(camera, rng, folder):
    """Where small bright spheres are seen, less where they should be, px."""
    points = spheres(camera, rng)
    scene = "#version 3.7; global_settings { assumed_gamma 1 } background { rgb 0 }\n"
    for point in points:
        radius = 2.5 * np.linalg.norm(point - camera.position) / camera.matrix[0, 0]
        scene += f"sphere {{ {vector(point)}, {radius:.6f} pigment {{ rgb 1 }} finish {{ diffuse 0 emission {1 / full_scale:.3f} }} }}\n"
    light = camera.picture(scene, folder, smooth=4)[:, :, 1]
    offsets = []
    for pixel in camera.project(points):
        left, top = (np.round(pixel) - 9).astype(int)
        patch = light[top:top + 19, left:left + 19]
        v, u = np.mgrid[top:top + patch.shape[0], left:left + patch.shape[1]]
        offsets.append([(u * patch).sum() / patch.sum() - pixel[0], (v * patch).sum() / patch.sum() - pixel[1]])
    return np.array(offsets)


def silhouette_overlap(camera, robot, pose, folder):
    """Pixels common to the robot as rendered and its parts as projected, to a pixel, as a part of all pixels of either."""
    seen = robot.mask(camera, pose, folder)
    drawn = np.zeros(seen.shape, np.uint8)
    for corners in robot.corners(pose):
        hull = cv2.convexHull(camera.project(corners).astype(np.float32))
        cv2.fillConvexPoly(drawn, np.round(hull * 16).astype(np.int32), 1, cv2.LINE_8, 4)
    wide = np.ones((3, 3), np.uint8)
    missing = seen & (cv2.dilate(drawn, wide) == 0) | (drawn > 0) & (cv2.dilate(seen.astype(np.uint8), wide) == 0)
    return 1 - missing.sum() / (seen | (drawn > 0)).sum()


def check(seed):
    rng = np.random.default_rng(seed)
    everything, worst = [], 1.0
    with tempfile.TemporaryDirectory() as folder:
        for n in range(6):
            camera = random_camera(rng, n % 3 == 2)
            offsets = sphere_offsets(camera, rng, folder)
            everything.append(offsets)
            print(f"camera {n}: {camera.width}x{camera.height}, fx {camera.matrix[0, 0]:.0f}, k1 {camera.distortion[0]:+.3f}, {len(offsets)} spheres: "
                  f"mean ({offsets[:, 0].mean():+.3f}, {offsets[:, 1].mean():+.3f}), rms {np.sqrt((offsets**2).sum(1).mean()):.3f}, largest {np.hypot(*offsets.T).max():.3f} px")
            for kind in kinds:
                robot = random_robot(rng, kind)
                overlap = silhouette_overlap(camera, robot, [2.6, 2.4, rng.uniform(-3, 3)], folder)
                worst = min(worst, overlap)
                print(f"   {kind}: parts and picture overlap by {100 * overlap:.1f} %")
    largest = max(np.hypot(*o.T).max() for o in everything)
    print(f"largest offset {largest:.3f} px (0.1 allowed), smallest overlap {100 * worst:.1f} % (99 allowed)")
    return 0 if largest < 0.1 and worst > 0.99 else 1
