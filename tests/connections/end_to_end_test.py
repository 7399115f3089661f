"""From three cameras on the network to everybody who may want to know, beside where the robot really is. The program is in the variable ROOMFIX; a subscriber of
another vendor's DDS in ROOMFIX_DDS_LISTENER, where there is one."""
import datetime
import json
import math
import os
import pathlib
import signal
import subprocess
import unittest

from live_site import LiveHall, Page, evaluate, quantile
from peers import Broker, Postgres, Process, cyclone_on_loopback, fixes_of, free_port, loopback_only, program, source, temporary_folder, wait_until

dds_listener = os.environ.get("ROOMFIX_DDS_LISTENER")
seconds = 9  # of the drive


def distance_to_way(place, way):
    """From the nearest point of a line through places (m)."""
    nearest = math.dist(place, way[0])
    for (x, y), (to_x, to_y) in zip(way, way[1:]):
        length = math.dist((x, y), (to_x, to_y))
        part = ((place[0] - x) * (to_x - x) + (place[1] - y) * (to_y - y)) / length**2 if length > 0 else 0
        part = min(max(part, 0), 1)
        nearest = min(nearest, math.dist(place, (x + part * (to_x - x), y + part * (to_y - y))))
    return nearest


class EndToEnd(unittest.TestCase):
    def setUp(self):
        temporary = temporary_folder()
        self.folder = pathlib.Path(temporary.name)
        self.addCleanup(temporary.cleanup)

    def start(self, name, *command, **more):
        process = Process(self.folder, name, *command, **more)
        self.addCleanup(process.stop, True)
        return process

    def ask_everybody(self, hall):
        """The program, and all who listen to it."""
        broker, database = Broker(self.folder, "allow_anonymous true"), Postgres(self.folder)
        self.addCleanup(broker.stop)
        self.addCleanup(database.remove)
        web, foxglove, domain = free_port(), free_port(), 100 + os.getpid() % 33
        site = hall.write_site(f"  web: {{port: {web}}}\n  mqtt: {{port: {broker.port}, rate: 0}}\n  foxglove: {{port: {foxglove}}}\n  ros2: {{domain: {domain}, robot_transform: true}}\n"
                               f"  history: {{database: '{database.address}'}}\n")
        self.database, self.page = database, Page(web)
        self.mqtt = self.start("mqtt", "mosquitto_sub", "-p", broker.port, "-V", "mqttv5", "-t", "roomfix/li2014/r1/pose", "-F", "%U\t%p")
        self.dds = self.start("dds", dds_listener, domain, "r1", "hall1", stdin=subprocess.PIPE, env=cyclone_on_loopback) if dds_listener else None
        self.running = self.start("roomfix", program, "run", site, "--fixes", self.folder / "fixes.jsonl", "--record", self.folder / "recorded", env=loopback_only)
        wait_until(lambda: self.page.state() or self.running.ended(), "the page is served")
        self.foxglove = self.start("foxglove", "node", source / "tests/connections/foxglove_client.mjs", f"ws://127.0.0.1:{foxglove}")
        self.browser = self.start("browser", "node", source / "tests/connections/page_watcher.mjs", f"http://127.0.0.1:{web}")

    def everybody_is_there(self):
        cameras = self.page.state()["cameras"]
        clocks = all("the camera's own" in camera.get("note", "") for camera in cameras)  # its sender reports have come
        return clocks and all(listener.text() for listener in (self.mqtt, self.foxglove, self.browser)) and (self.dds is None or '"pose"' in self.dds.text())

    def tell_errors(self, who, places, hall):
        errors = [math.dist((x, y), hall.place(time)[:2]) for time, x, y in places]
        print(f"{who}: {len(errors)} places of the drive, error median {1e3 * quantile(errors, 0.5):.1f} mm, largest {1e3 * max(errors):.1f} mm")
        self.assertGreater(len(errors), 20, who)
        self.assertLess(quantile(errors, 0.5), 0.01, who)

    def check_places(self, who, places, hall):
        """Those of the drive, (time, x, y): each is in the file, too, where the truth says how good it is."""
        driving = [place for place in places if place[0] > hall.begins]
        self.tell_errors(who, driving, hall)
        for time, x, y in driving:
            self.assertTrue(any(abs(fix["time"] - time) < 0.002 and math.dist((fix["x"], fix["y"]), (x, y)) < 3e-6 for fix in self.driving), f"{who}: {time} {x} {y}")

    def check_times(self, hall, fixes):
        errors = [abs(fix["time"] - hall.taken(fix["time"])) for fix in fixes]
        latencies = [fix["latency"] for fix in fixes if "latency" in fix]
        print(f"time of a picture against when it was taken: median {1e3 * quantile(errors, 0.5):.2f} ms, 99 % {1e3 * quantile(errors, 0.99):.2f} ms")
        print(f"from the picture to its fix, {len(latencies)} fixes: median {1e3 * quantile(latencies, 0.5):.0f} ms, 99 % {1e3 * quantile(latencies, 0.99):.0f} ms")
        self.assertLessEqual(quantile(errors, 0.95), 0.005)

    def test_everybody_hears_the_truth(self):
        hall = LiveHall(self.folder, seconds)
        self.addCleanup(hall.stop)
        self.ask_everybody(hall)
        wait_until(self.everybody_is_there, "everybody gets fixes", 60)
        hall.drive()
        wait_until(hall.arrived, "the robot arrived", 60)
        self.running.process.send_signal(signal.SIGINT)
        self.assertEqual(self.running.process.wait(60), 0, self.running.text())
        hall.stop()

        fixes = fixes_of(self.folder / "fixes.jsonl")
        self.driving = [fix for fix in fixes if fix["time"] > hall.begins - 0.01 and fix["status"] != "none"]
        self.check_times(hall, self.driving)
        self.tell_errors("the file", [(fix["time"], fix["x"], fix["y"]) for fix in self.driving], hall)

        heard = [(float(at), datetime.datetime.fromisoformat(pose["t"]).timestamp(), pose) for at, pose in
                 ((at, json.loads(text)) for at, text in (line.split("\t", 1) for line in self.mqtt.lines()))]
        came = [at - time for at, time, _ in heard if time > hall.begins]
        print(f"from the picture to an MQTT subscriber: median {1e3 * quantile(came, 0.5):.0f} ms, 99 % {1e3 * quantile(came, 0.99):.0f} ms")
        self.check_places("MQTT", [(time, pose["x"], pose["y"]) for _, time, pose in heard], hall)
        poses = [json.loads(line) for line in self.foxglove.lines()]
        self.check_places("Foxglove", [(p["time"], p["pose"]["position"]["x"], p["pose"]["position"]["y"]) for p in poses], hall)
        if self.dds:
            self.dds.process.communicate(timeout=30)
            poses = [json.loads(line)["pose"] for line in self.dds.lines() if line.startswith('{"pose"')]
            self.check_places("ROS 2", [(p["sec"] + 1e-9 * p["nanosec"], *p["position"][:2]) for p in poses], hall)
        rows = [[float(value) for value in row] for row in self.database.ask("SELECT time / 1e9, x, y FROM roomfix_fixes WHERE x IS NOT NULL ORDER BY number")]
        self.assertEqual(len(rows), len([fix for fix in fixes if fix["status"] != "none"]))
        self.check_places("PostgreSQL", rows, hall)
        # The browser tells no times, and moves smoothly from fix to fix: it is set beside the nearest of shortly before.
        shown = [see for see in map(json.loads, self.browser.lines()) if see["now"] > hall.begins + 1]
        recent = [[fix for fix in self.driving if see["now"] - 2 < fix["time"] < see["now"]] for see in shown]
        near = [min(fixes_before, key=lambda fix: math.dist((fix["x"], fix["y"]), (see["x"], see["y"]))) for fixes_before, see in zip(recent, shown)]
        self.tell_errors("the page", [(fix["time"], see["x"], see["y"]) for fix, see in zip(near, shown)], hall)
        for fixes_before, see in zip(recent, shown):
            way = [(fix["x"], fix["y"]) for fix in fixes_before]
            self.assertLess(distance_to_way((see["x"], see["y"]), way), 0.05, f"the page shows {see}, the fixes before were {way}")
        self.compare_with_replay(hall)

    def compare_with_replay(self, hall):
        """Of what was recorded meanwhile."""
        hall.write_truth(self.folder / "truth.csv")
        live = evaluate(self.folder / "fixes.jsonl", self.folder / "truth.csv")["all"]
        subprocess.run([program, "replay", self.folder / "recorded", "--fixes", self.folder / "replayed.jsonl"], check=True, stderr=subprocess.DEVNULL)
        replayed = evaluate(self.folder / "replayed.jsonl", self.folder / "truth.csv")["all"]
        errors = [1e3 * figures["position"]["rmse"] for figures in (live, replayed)]
        print(f"rms error live {errors[0]:.1f} mm (NEES {live['nees']['mean']:.2f}), replayed {errors[1]:.1f} mm (NEES {replayed['nees']['mean']:.2f})")
        self.assertLess(errors[0], 1.3 * errors[1] + 0.5)
        self.assertLess(live["nees"]["mean"], 3)


if __name__ == "__main__":
    unittest.main()
