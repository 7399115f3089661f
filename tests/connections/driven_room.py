"""A robot that drives a circle and reports what it senses, beside the way that it really drives."""
import json
import math
import pathlib
import random
import time
import unittest
import urllib.request

from peers import Process, fixes_of, free_port, listens, program, temporary_folder, wait_until

beacons = {"n1": (0, 0, 2.5), "n2": (6, 0, 2.3), "n3": (6, 5, 2.5), "n4": (0, 5, 2.2)}
receiver = 0.3  # m above the floor


def truth(t):
    """Once around in 16 s."""
    angle = 2 * math.pi * t / 16
    return 3 + 1.5 * math.cos(angle), 2.5 + 1.5 * math.sin(angle), angle + math.pi / 2


class Sender:
    """A robot that reports by `send`, with a clock that began when it was switched on."""

    def __init__(self, send, behind):
        self.send, self.behind, self.start, self.noise, self.number = send, behind, time.time(), random.Random(5), 0

    def report(self):
        now = time.time()
        x, y, yaw = truth(now - self.start)
        stamp = now - self.behind
        name = list(beacons)[self.number % 4]
        distance = math.dist((x, y, receiver), beacons[name]) + self.noise.gauss(0, 0.02)
        self.number += 1
        lines = [{"time": stamp, "robot": "r1", "beacon": name, "range": distance}, {"time": stamp, "robot": "r1", "x": x - 4.5, "y": y - 2.5, "yaw": yaw}]
        time.sleep(self.noise.uniform(0, 0.01))  # on its way
        self.send("".join(json.dumps(line) + "\n" for line in lines))
        time.sleep(0.03)


class DrivenRoom(unittest.TestCase):
    """A room in which that robot is found by ranges to four beacons and by its wheels."""

    def setUp(self):
        self.temporary = temporary_folder()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)
        self.port = free_port()

    def run_site(self, ranges, wheels, outputs, **more):
        listed = "".join(f"  {name}: {{position: [{x}, {y}, {z}]}}\n" for name, (x, y, z) in beacons.items())
        (self.folder / "site.yaml").write_text(
            "roomfix: 1\nsite: {name: room}\nrobots:\n"
            f"  r1: {{shape: box, size: [0.5, 0.4, 0.3], drive: differential, receiver: {{position: [0, 0, {receiver}], source: '{ranges}'}}, "
            f"odometry: {{source: '{wheels}'}}}}\nbeacons:\n{listed}outputs:\n  web: {{port: {self.port}}}\n{outputs}")
        self.running = running = Process(self.folder, "roomfix", program, "run", self.folder / "site.yaml", "--fixes", self.folder / "fixes.jsonl", **more)
        self.addCleanup(running.stop, True)
        wait_until(lambda: listens(self.port) or running.ended(), "the page is served")
        self.assertFalse(running.ended(), running.text())
        return running

    def state(self):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/state", timeout=30) as answer:
            return json.loads(answer.read())

    def check(self, sender):
        """From now on the robot is found, where and when it was."""
        known = self.number_of_fixes()

        def good():
            fixes = [fix for fix in fixes_of(self.folder / "fixes.jsonl")[-10:] if fix["status"] == "ok"]
            return len(fixes) == 10 and all(fix["covariance"][0] + fix["covariance"][4] < 0.04**2 for fix in fixes)

        for _ in range(2000):
            sender.report()
            if self.number_of_fixes() > known + 10 and good():
                break
        else:
            self.fail("the robot was not found")
        for fix in fixes_of(self.folder / "fixes.jsonl")[-10:]:
            x, y, _ = truth(fix["time"] - sender.start)
            self.assertLess(math.hypot(fix["x"] - x, fix["y"] - y), 0.1)
            self.assertLess(abs(fix["time"] - time.time()), 5)  # of our clock

    def number_of_fixes(self):
        file = self.folder / "fixes.jsonl"
        return file.read_text().count("\n") if file.exists() else 0
