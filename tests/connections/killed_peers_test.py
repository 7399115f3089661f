"""A camera, the broker, the database, a ROS 2 subscriber and a page client are killed and come back, in several orders, while a robot drives: everything that is
left goes on, says honestly what is missing, and is whole again within 5 s. The program is in the variable ROOMFIX.

ROOMFIX_ORDERS: how many of the 120 orders (default 3; they are drawn anew each time)."""
import itertools
import json
import math
import os
import pathlib
import random
import subprocess
import threading
import time
import unittest
import urllib.error
import urllib.request

from live_site import LiveHall, Page
from peers import Broker, Postgres, Process, cyclone_on_loopback, fixes_of, free_port, loopback_only, program, temporary_folder, wait_until

dds_listener = os.environ.get("ROOMFIX_DDS_LISTENER")
orders = int(os.environ.get("ROOMFIX_ORDERS", "3"))
longest_recovery = 5  # s


class PageClient:
    """A listener to the page's events."""

    def __init__(self, port):
        self.port = port
        self.start()

    def start(self):
        self.ended, self.heard = False, 0
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/events", timeout=30) as events:
            while not self.ended:
                self.heard += events.readline().startswith(b"data:")

    def stop(self, kill=False):
        self.ended = True


class Subscriber:
    """A program that listens."""

    def __init__(self, start):
        self.begin = start
        self.start()

    def start(self):
        self.process = self.begin()

    def stop(self, kill=False):
        self.process.stop(kill)


class KilledPeers(unittest.TestCase):
    def setUp(self):
        temporary = temporary_folder()
        self.folder = pathlib.Path(temporary.name)
        self.addCleanup(temporary.cleanup)
        self.slowest = {}  # s until each was whole again

    def start(self):
        self.hall = LiveHall(self.folder, 20, there_and_back=True)
        self.addCleanup(self.hall.stop)
        self.broker, self.database = Broker(self.folder, "allow_anonymous true"), Postgres(self.folder)
        self.addCleanup(self.broker.stop, True)
        self.addCleanup(self.database.remove)
        web, domain = free_port(), 100 + os.getpid() % 33
        site = self.hall.write_site(f"  web: {{port: {web}}}\n  mqtt: {{port: {self.broker.port}}}\n  ros2: {{domain: {domain}, robot_transform: true}}\n"
                                    f"  history: {{database: '{self.database.address}'}}\n")
        self.page, self.domain = Page(web), domain
        self.fixes = self.folder / "fixes.jsonl"
        self.running = Process(self.folder, "roomfix", program, "run", site, "--fixes", self.fixes, env=loopback_only)
        self.addCleanup(self.running.stop, True)
        wait_until(lambda: self.page.sink("history") or self.running.ended(), "the page is served")
        self.peers = {"camera": self.hall.cameras["hall1"], "broker": self.broker, "database": self.database, "page": PageClient(web)}
        if dds_listener:
            numbers = itertools.count()
            self.peers["ros2"] = Subscriber(lambda: Process(self.folder, f"dds-{next(numbers)}", dds_listener, domain, "r1", "hall1", stdin=subprocess.PIPE, env=cyclone_on_loopback))
            self.addCleanup(self.peers["ros2"].stop, True)

    def newest_row(self):
        return float(self.database.ask("SELECT coalesce(max(time), 0) / 1e9 FROM roomfix_fixes")[0][0])

    def works(self, peer, since):
        """Has it got something that is younger than `since`?"""
        if peer == "camera":
            return self.page.camera("hall1")["status"] == "ok"
        if peer == "broker":
            heard = subprocess.run(["mosquitto_sub", "-p", str(self.broker.port), "-V", "mqttv5", "-t", "roomfix/li2014/r1/pose", "-C", "1", "-W", "1"], capture_output=True, text=True)
            return bool(heard.stdout)
        if peer == "database":
            return self.newest_row() > since
        if peer == "page":
            return self.peers["page"].heard > 0
        return '"pose"' in self.peers["ros2"].process.text()

    def says_so(self, peer):
        """Does the page tell that it is gone? Who only listens need not be missed."""
        if peer == "camera":
            return self.page.camera("hall1")["status"] == "away"
        if peer in ("broker", "database"):
            return self.page.sink("MQTT" if peer == "broker" else "history")["status"] == "failed"
        return True

    def kill_and_restart(self, order):
        for peer in order:
            self.peers[peer].stop(True)
            time.sleep(0.2)
        known = len(fixes_of(self.fixes))
        for peer in order:
            wait_until(lambda: self.says_so(peer), f"it is said that the {peer} is gone")
        wait_until(lambda: len(fixes_of(self.fixes)) > known + 5, "fixes go on")
        self.assertFalse(self.running.ended(), self.running.text())
        back = {}
        for peer in order:
            self.peers[peer].start()
            back[peer] = time.time()
        for peer in order:  # the robot is in sight only when the camera is, so that nobody is waited for before
            wait_until(lambda: self.works(peer, back[peer]), f"the {peer} is in use again after {order}")
            self.slowest[peer] = max(self.slowest.get(peer, 0), time.time() - back[peer])

    def check_fixes(self):
        """All that is called ok is where the robot is; the database has every fix."""
        fixes = [fix for fix in fixes_of(self.fixes) if fix["status"] == "ok"]
        errors = [math.dist((fix["x"], fix["y"]), self.hall.place(fix["time"])[:2]) for fix in fixes]
        surprises = [error**2 / (fix["covariance"][0] + fix["covariance"][4]) for error, fix in zip(errors, fixes)]
        print(f"{len(fixes)} ok fixes, error median {1e3 * sorted(errors)[len(errors) // 2]:.1f} mm, largest {1e3 * max(errors):.0f} mm; by what they state, squared, on average {sum(surprises) / len(surprises):.2f}")
        self.assertLess(max(errors), 0.3)
        self.assertLess(sum(surprises) / len(surprises), 3)

    def test_in_any_order(self):
        self.start()
        wait_until(lambda: all(self.works(peer, 0) for peer in self.peers), "all is well", 60)
        self.hall.drive()
        all_orders = list(itertools.permutations(self.peers))
        for number, order in enumerate(random.sample(all_orders, min(orders, len(all_orders)))):
            self.kill_and_restart(order)
            print(number, *order, {peer: round(time, 1) for peer, time in self.slowest.items()}, flush=True)
        wait_until(lambda: self.works("database", time.time() - 1), "the history is up to date")
        self.running.process.terminate()
        self.assertEqual(self.running.process.wait(60), 1)  # for what could not be sent
        self.assertRegex(self.running.text(), r"MQTT .*: \d+ messages were not sent, while there was no connection")
        stored = self.database.ask("SELECT count(*) FROM roomfix_fixes")[0][0]
        self.assertEqual(int(stored), len(fixes_of(self.fixes)))
        self.check_fixes()
        for peer, seconds in self.slowest.items():
            self.assertLess(seconds, longest_recovery, peer)


if __name__ == "__main__":
    unittest.main()
