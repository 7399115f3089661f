"""Tests of the Python module: python3 test_roomfix.py PROGRAM; the module must be on PYTHONPATH."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy

import roomfix

program = sys.argv.pop()


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.session = pathlib.Path(cls.folder.name) / "session"
        subprocess.run([program, "simulate", "li2014", "-o", cls.session, "--duration", "2"], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_replay_gives_what_the_program_writes(self):
        fixes = pathlib.Path(self.folder.name) / "fixes.jsonl"
        subprocess.run([program, "replay", self.session, "--fixes", fixes], check=True, capture_output=True)
        written = [json.loads(line) for line in fixes.read_text().splitlines()]
        replayed = roomfix.replay(self.session)
        self.assertEqual(len(written), len(replayed))
        self.assertGreater(len(replayed), 10)
        for line, fix in zip(written, replayed):
            self.assertEqual(line["robot"], fix.robot)
            self.assertEqual(line["status"], fix.status)
            numpy.testing.assert_allclose([line["x"], line["y"]], fix.pose[:2], atol=1e-6)
            covariance = fix.covariance
            numpy.testing.assert_allclose(covariance, covariance.T)
            self.assertGreater(numpy.linalg.eigvalsh(covariance)[0], 0)

    def test_arrays(self):
        found = roomfix.arrays(roomfix.replay(self.session, threads=1), "r1")
        count = len(found["time"])
        self.assertEqual(found["pose"].shape, (count, 3))
        self.assertEqual(found["covariance"].shape, (count, 3, 3))
        self.assertTrue((numpy.diff(found["time"]) >= 0).all())
        self.assertEqual(roomfix.arrays([])["pose"].shape, (0, 3))

    def test_pictures_as_numpy(self):
        site = roomfix.load_site(self.session)
        name = site.cameras[0]
        picture = roomfix.load_grey(sorted((self.session / "frames" / name).glob("*"))[0])
        camera = roomfix.Camera(site, name)
        fixes = camera.fix(picture)
        self.assertTrue(fixes)
        in_colour = camera.fix(numpy.repeat(picture[:, :, None], 3, axis=2))
        self.assertEqual([f.status for f in fixes], [f.status for f in in_colour])
        for wrong in (picture.astype(float), picture[:, :0], picture.astype(numpy.uint8)[None, None]):
            with self.assertRaisesRegex(ValueError, "a picture must be an array of uint8"):
                camera.fix(wrong)
        with self.assertRaisesRegex(roomfix.Error, "the picture is .* pixels, the site says"):
            camera.fix(picture[::2, ::2])
        with self.assertRaisesRegex(ValueError, "'rgb' or 'bgr'"):
            camera.fix(picture, order="hsv")
        with self.assertRaisesRegex(roomfix.Error, "cannot be opened|cannot be read"):
            roomfix.load_grey(self.session / "nowhere.png")
        with self.assertRaisesRegex(roomfix.Error, "there is no camera 'cellar'"):
            roomfix.Camera(site, "cellar")

    def test_frames_put_in_by_hand_give_the_fixes_of_replay(self):
        site = roomfix.load_site(self.session)
        tracker = roomfix.Tracker(site)
        odometry = numpy.genfromtxt(self.session / "odometry.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
        told, given = 0, []
        folders = {name: sorted((self.session / "frames" / name).glob("*")) for name in site.cameras}
        for files in list(zip(*folders.values()))[:4]:
            self.assertEqual(len({file.stem for file in files}), 1)
            time = int(files[0].stem) * 1e-9
            while told < len(odometry) and odometry["time"][told] <= time:
                tracker.odometry("r1", *(float(odometry[name][told]) for name in ("x", "y", "yaw")), float(odometry["time"][told]))
                told += 1
            given += tracker.frames({name: roomfix.load_grey(file) for name, file in zip(folders, files)}, time)
        replayed = {(fix.time_ns, tuple(fix.sources)): fix for fix in roomfix.replay(self.session) if fix.status == "ok"}
        compared = [(fix, replayed[(fix.time_ns, tuple(fix.sources))]) for fix in given if (fix.time_ns, tuple(fix.sources)) in replayed]
        self.assertGreater(len(compared), 3)
        for by_hand, fix in compared:
            numpy.testing.assert_allclose(by_hand.pose, fix.pose, atol=1e-3)

    def test_ranges_by_hand(self):
        folder = pathlib.Path(self.folder.name)
        beacons = {"b1": (0, 0, 2.5), "b2": (8, 0, 2.5), "b3": (8, 6, 2.5), "b4": (0, 6, 2.5)}
        lines = "".join(f"  {name}: {{position: [{x}, {y}, {z}]}}\n" for name, (x, y, z) in beacons.items())
        (folder / "beacons.yaml").write_text(
            f"roomfix: 1\nsite: {{name: room}}\nbeacons:\n{lines}robots:\n  r1: {{shape: box, size: [0.5, 0.4, 0.4], receiver: {{position: [0, 0, 0.5]}}, odometry: {{}}}}\n")
        tracker = roomfix.Tracker(roomfix.load_site(folder / "beacons.yaml"))
        fixes = []
        for i in range(300):
            angle, time, beacon = 0.03 * i, 1 + 0.1 * i, f"b{1 + i % 4}"
            x, y = 4 + 1.5 * numpy.cos(angle), 3 + 1.5 * numpy.sin(angle)
            fixes += tracker.odometry("r1", x, y, angle + numpy.pi / 2, time)
            fixes += tracker.range("r1", beacon, float(numpy.linalg.norm(numpy.array(beacons[beacon]) - (x, y, 0.5))), time)
        error = fixes[-1].pose[:2] - (x, y)
        self.assertLess(numpy.linalg.norm(error), 0.1)
        self.assertLess(error @ numpy.linalg.solve(fixes[-1].covariance[:2, :2], error), 14)  # once in a thousand
        self.assertEqual([f.robot for f in tracker.fixes(time)], ["r1"])
        with self.assertRaisesRegex(roomfix.Error, "there is no beacon 'b9'"):
            tracker.range("r1", "b9", 1, 40)
        with self.assertRaisesRegex(roomfix.Error, "has no detector"):
            tracker.sighting("r1", range=1.0, time=40)

    def test_a_bad_site_lists_its_mistakes(self):
        file = pathlib.Path(self.folder.name) / "bad.yaml"
        file.write_text("roomfix: 1\nsite: {name: room}\nrobots:\n  r1: {shape: egg}\n")
        with self.assertRaisesRegex(roomfix.Error, "bad.yaml:4"):
            roomfix.load_site(file)
        with self.assertRaises(ValueError):
            roomfix.load_site(pathlib.Path(self.folder.name) / "missing.yaml")


if __name__ == "__main__":
    unittest.main()
