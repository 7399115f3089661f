"""A simulated hall whose cameras are live: its pictures are sent by RTSP at the times at which they are said to be taken, so that it is known where the robot really
is at every moment."""
import bisect
import csv
import json
import math
import pathlib
import random
import re
import struct
import subprocess
import threading
import time
import urllib.error
import urllib.request

from peers import Process, free_port, listens, program, source, wait_until

period = 0.1  # s between pictures


class LiveCamera:
    """An RTSP server with the pictures of a folder. `picture` is the one that it shows now."""

    def __init__(self, folder, pictures, size):
        self.folder, self.port = folder, free_port()
        self.width, self.height = size
        decoded = subprocess.run(["ffmpeg", "-loglevel", "error", "-f", "image2", "-pattern_type", "glob", "-i", f"{pictures}/*.jpg", "-pix_fmt", "yuvj420p", "-f", "rawvideo", "pipe:"],
                                 stdout=subprocess.PIPE, check=True).stdout
        self.length = self.width * self.height * 3 // 2
        self.pictures = [int.from_bytes(decoded[at:at + self.length], "little") for at in range(0, len(decoded), self.length)]
        ones = int.from_bytes(bytes([1]) * self.length, "little")
        self.noises = [random.getrandbits(8 * self.length) & ones for _ in range(7)]  # no sensor gives the same picture twice
        self.address = f"rtsp://127.0.0.1:{self.port}/camera"
        self.lock = threading.Lock()
        self.start()

    def start(self):
        server = Process(self.folder, f"camera-{self.port}", "/usr/bin/python3", source / "tests/connect/rtsp_server.py", self.port, self.width, self.height, "jpeg", stdin=subprocess.PIPE)
        wait_until(lambda: listens(self.port), "the camera listens")
        with self.lock:
            self.server = server

    def show(self, number, moment):
        with self.lock:
            server = self.server
        noisy = self.pictures[number] ^ random.choice(self.noises)
        try:
            server.process.stdin.write(struct.pack("<q", moment) + noisy.to_bytes(self.length, "little"))
            server.process.stdin.flush()
        except (BrokenPipeError, ValueError):
            pass  # it was switched off

    def stop(self, kill=False):
        with self.lock:
            self.server.stop(kill)


class LiveHall:
    """The hall of Li 2014 with its three cameras. The robot stands where its drive begins until `drive()`, and then where it ends, or it comes back the same way."""

    def __init__(self, folder, seconds, there_and_back=False):
        self.folder = pathlib.Path(folder)
        self.session = self.folder / "hall"
        subprocess.run([program, "simulate", "li2014", "-o", self.session, "--duration", str(seconds)], check=True, stderr=subprocess.DEVNULL)
        with open(self.session / "truth.csv") as file:
            self.way = [(float(line["x"]), float(line["y"]), float(line["yaw"])) for line in csv.DictReader(file)]
        sizes = re.findall(r"size: \[(\d+), (\d+)\]\n", (self.session / "site.yaml").read_text())
        self.cameras = {f"hall{i}": LiveCamera(self.folder, self.session / f"frames/hall{i}", [int(number) for number in sizes[i - 1]]) for i in (1, 2, 3)}
        last = len(self.way) - 1
        slowly = [last - k for k, pictures in ((4, 2), (3, 2), (2, 3), (1, 4), (0, 8)) for _ in range(pictures)]  # it stops, and starts the other way
        there = list(range(last - 4)) + slowly
        there = [last - number for number in slowly[::-1]] + there[5:]
        self.numbers = there + there[::-1] if there_and_back else list(range(last + 1))
        self.there_and_back = there_and_back
        self.shown = []  # when each picture was taken, ns since 1970, and which one it was
        self.times = []  # the same in s
        self.begins = self.ending = None
        self.player = threading.Thread(target=self.play, daemon=True)
        self.player.start()

    def play(self):
        due, step = time.time(), 0
        while not self.ending:
            moment = time.time_ns()
            number = self.numbers[step]
            self.shown.append((moment, number))
            self.times.append(moment * 1e-9)
            for camera in self.cameras.values():
                camera.show(number, moment)
            if self.begins is not None:
                step = (step + 1) % len(self.numbers) if self.there_and_back else min(step + 1, len(self.numbers) - 1)
            due = max(due + period, time.time())
            time.sleep(max(0.0, due - time.time()))

    def drive(self):
        self.begins = time.time()

    def arrived(self):
        return self.shown[-1][1] == len(self.way) - 1

    def stop(self):
        self.ending = True
        self.player.join(30)
        for camera in self.cameras.values():
            camera.stop(True)

    def write_site(self, outputs, more=""):
        """A site file with the live cameras, whose sender reports are known to be about the exposure."""
        text = (self.session / "site.yaml").read_text() + f"outputs:\n{outputs}{more}"
        text = re.sub(r",\s*odometry: \{[^}]*\}", "", text)
        for name, camera in self.cameras.items():
            text = text.replace(f"source: frames/{name}\n", f"source: {camera.address}\n    time_offset_sigma: 0.003\n")
        site = self.session / "live.yaml"
        site.write_text(text)
        return site

    def taken(self, moment):
        """When the picture was taken that is nearest to a moment, s since 1970."""
        i = bisect.bisect(self.times, moment)
        return min(self.times[max(i - 1, 0):i + 1], key=lambda known: abs(known - moment))

    def place(self, moment):
        """Where the robot is at a moment, s since 1970."""
        shown, times = self.shown, self.times
        i = min(max(bisect.bisect(times, moment), 1), len(times) - 1)
        part = min(max((moment - times[i - 1]) / (times[i] - times[i - 1]), 0), 1)
        (x0, y0, yaw0), (x1, y1, yaw1) = self.way[shown[i - 1][1]], self.way[shown[i][1]]
        return x0 + part * (x1 - x0), y0 + part * (y1 - y0), yaw0 + part * math.remainder(yaw1 - yaw0, 2 * math.pi)

    def write_truth(self, file):
        with open(file, "w") as out:
            out.write("time,robot,x,y,yaw\n")
            for moment, number in self.shown:
                out.write(f"{moment // 10**9}.{moment % 10**9:09d},r1," + ",".join(map(str, self.way[number])) + "\n")


class Page:
    """What a program that runs says of itself."""

    def __init__(self, port):
        self.port = port

    def state(self):
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/state", timeout=30) as answer:
                return json.loads(answer.read())
        except (urllib.error.URLError, ConnectionError):
            return None

    def camera(self, name):
        state = self.state()
        return next((camera for camera in state["cameras"] if camera["id"] == name), None) if state else None

    def sink(self, part):
        state = self.state()
        return next((sink for sink in state.get("sinks", []) if part in sink["name"]), None) if state else None


def quantile(values, q):
    return sorted(values)[int(q * (len(values) - 1))] if values else math.nan


def errors_of(fixes, place):
    """How far each fix is from where the robot was, m, and the squares of that over what is stated, on average."""
    errors = [math.dist((fix["x"], fix["y"]), place(fix)[:2]) for fix in fixes]
    squares = [error**2 / (fix["covariance"][0] + fix["covariance"][4]) for error, fix in zip(errors, fixes)]
    return errors, sum(squares) / max(len(squares), 1)


def evaluate(fixes, truth):
    done = subprocess.run([program, "evaluate", fixes, "--truth", truth, "--symmetry-deg", "90", "--json", f"{fixes}.json"], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return json.loads(pathlib.Path(f"{fixes}.json").read_text())
