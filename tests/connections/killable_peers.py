"""A site with three live cameras and everybody who may listen to it, each of whom can be killed and started again."""
import contextlib
import itertools
import os
import pathlib
import subprocess
import threading
import time
import urllib.request

from live_site import LiveHall, Page
from peers import Broker, Postgres, Process, cyclone_on_loopback, fixes_of, free_port, loopback_only, program, wait_until

dds_listener = os.environ.get("ROOMFIX_DDS_LISTENER")  # a subscriber of another vendor's DDS, where there is one


class PageClient:
    """A listener to the page's events."""

    def __init__(self, port):
        self.port = port
        self.start()

    def start(self):
        self.ended, self.heard = threading.Event(), 0
        threading.Thread(target=self.listen, args=(self.ended,), daemon=True).start()

    def listen(self, ended):
        with contextlib.suppress(OSError), urllib.request.urlopen(f"http://127.0.0.1:{self.port}/api/events", timeout=30) as events:
            while not ended.is_set():
                self.heard += events.readline().startswith(b"data:")

    def stop(self, kill=False):
        self.ended.set()


class Ros2Subscriber:
    def __init__(self, folder, domain):
        self.folder, self.domain, self.numbers = folder, domain, itertools.count()
        self.start()

    def start(self):
        name = f"dds-{next(self.numbers)}"
        self.process = Process(self.folder, name, dds_listener, self.domain, "r1", "hall1", stdin=subprocess.PIPE, env=cyclone_on_loopback)

    def heard(self):
        return '"pose"' in self.process.text()

    def stop(self, kill=False):
        self.process.stop(kill)


class SiteWithPeers(contextlib.ExitStack):
    """`peers`, by their names; `running`: the program; `fixes`: its file of fixes."""

    def __init__(self, folder, seconds):
        """The robot drives so many seconds there and back, once `hall.drive()` says so."""
        super().__init__()
        self.folder = pathlib.Path(folder)
        self.hall = LiveHall(self.folder, seconds, there_and_back=True)
        self.callback(self.hall.stop)
        self.broker, self.database = Broker(self.folder, "allow_anonymous true"), Postgres(self.folder)
        self.callback(self.broker.stop, True)
        self.callback(self.database.remove)
        web, domain = free_port(), 100 + os.getpid() % 33
        site = self.hall.write_site(f"  web: {{port: {web}}}\n  mqtt: {{port: {self.broker.port}}}\n  ros2: {{domain: {domain}, robot_transform: true}}\n"
                                    f"  history: {{database: '{self.database.address}'}}\n")
        self.page, self.fixes = Page(web), self.folder / "fixes.jsonl"
        self.running = Process(self.folder, "roomfix", program, "run", site, "--fixes", self.fixes, env=loopback_only)
        self.callback(self.running.stop, True)
        wait_until(lambda: self.page.sink("history") or self.running.ended(), "the page is served")
        wait_until(lambda: self.database.ask("SELECT to_regclass('roomfix_fixes')") != [[""]], "the history has its tables")
        self.peers = {"camera": self.hall.cameras["hall1"], "broker": self.broker, "database": self.database, "page": PageClient(web)}
        if dds_listener:
            self.peers["ros2"] = Ros2Subscriber(self.folder, domain)
        for name in ("page", "ros2"):
            if name in self.peers:
                self.callback(self.peers[name].stop, True)

    def works(self, peer, since):
        """Has it got something that is younger than `since`?"""
        if peer == "camera":
            return self.page.camera("hall1")["status"] == "ok"
        if peer == "broker":
            asked = ["mosquitto_sub", "-p", str(self.broker.port), "-V", "mqttv5", "-t", "roomfix/li2014/r1/pose", "-C", "1", "-W", "1"]
            return bool(subprocess.run(asked, capture_output=True).stdout)
        if peer == "database":
            return float(self.database.ask("SELECT coalesce(max(time), 0) / 1e9 FROM roomfix_fixes")[0][0]) > since
        return self.peers["page"].heard > 0 if peer == "page" else self.peers["ros2"].heard()

    def says_so(self, peer):
        """Does the page tell that it is gone? Who only listens need not be missed."""
        if peer == "camera":
            return self.page.camera("hall1")["status"] == "away"
        if peer in ("broker", "database"):
            return self.page.sink("MQTT" if peer == "broker" else "history")["status"] == "failed"
        return True

    def kill(self, order):
        """One after the other; the fixes go on, and it is said who is gone."""
        for peer in order:
            self.peers[peer].stop(True)
            time.sleep(0.2)
        known = len(fixes_of(self.fixes))
        for peer in order:
            wait_until(lambda: self.says_so(peer), f"it is said that the {peer} is gone")
        wait_until(lambda: len(fixes_of(self.fixes)) > known + 5, "fixes go on")
        if self.running.ended():
            raise AssertionError(self.running.text())

    def restart(self, order):
        """One after the other; gives how long each took until it was in use again, s."""
        back, took = {}, {}
        for peer in order:
            self.peers[peer].start()
            back[peer] = time.time()
        for peer in order:  # the robot is in sight only when the camera is, so that nobody is waited for before
            wait_until(lambda: self.works(peer, back[peer]), f"the {peer} is in use again after {order}")
            took[peer] = time.time() - back[peer]
        return took
