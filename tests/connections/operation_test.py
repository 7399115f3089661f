"""doctor, init, and a site file that changes while it is in use. The program is in the variable ROOMFIX."""
import json
import pathlib
import socket
import subprocess
import unittest
import urllib.error
import urllib.request

from peers import Broker, Process, free_port, labyrinth, listens, program, temporary_folder, wait_until


class Operation(unittest.TestCase):
    def setUp(self):
        self.temporary = temporary_folder()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)

    def call(self, *arguments, **more):
        return subprocess.run([program, *[str(word) for word in arguments]], capture_output=True, text=True, timeout=120, **more)

    def test_doctor_finds_what_is_wrong_and_only_that(self):
        broker = Broker(self.folder, "allow_anonymous true")
        self.addCleanup(broker.stop)
        port = free_port()
        outputs = (f"outputs:\n  mqtt: {{port: {broker.port}}}\n  web: {{port: {port}}}\n  foxglove: {{port: 0}}\n  history: {{database: {self.folder}/history.db}}\n"
                   f"  jsonl: {self.folder}/fixes.jsonl\n")
        site = labyrinth(self.folder / "session", outputs)
        done = self.call("doctor", site)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertNotIn("PROBLEM", done.stdout)
        for what in ("clock", f"MQTT at 127.0.0.1:{broker.port}: the broker takes", "the page: can be served", "Foxglove's server: can be served", "history.db can be used",
                     "receiver: ranges.csv can be read"):
            self.assertIn(what, done.stdout)

        broker.stop()
        taken = socket.socket()
        self.addCleanup(taken.close)
        taken.bind(("127.0.0.1", port))
        taken.listen()
        site.write_text(site.read_text().replace(f"{self.folder}/fixes.jsonl", "nowhere/fixes.jsonl").replace("history.db", "none/history.db"))
        (self.folder / "session/ranges.csv").unlink()
        done = self.call("doctor", site)
        self.assertEqual(done.returncode, 1, done.stdout)
        for what in ("PROBLEM MQTT", "Connection refused", f"PROBLEM the page: port {port}", "PROBLEM fixes", "PROBLEM history", "PROBLEM robot r, receiver"):
            self.assertIn(what, done.stdout)
        self.assertEqual(done.stdout.count("PROBLEM"), 5, done.stdout)

    def test_init_writes_what_check_then_asks_to_complete(self):
        self.assertEqual(self.call("simulate", "li2014", "-o", self.folder / "li", "--duration", "0.3").returncode, 0)
        frames = next((self.folder / "li/frames").iterdir())
        site = self.folder / "site.yaml"
        done = self.call("init", "-o", site, frames, input="my hall\nhigh\n2.7\ncylinder\n0.4,0.5\n")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = site.read_text()
        for part in ("name: my_hall", "ceiling: 2.7", f"source: {frames}", "shape: cylinder, size: [0.4, 0.5]"):
            self.assertIn(part, text)
        checked = self.call("check", site)
        self.assertNotEqual(checked.returncode, 0)
        problems = [line for line in (checked.stdout + checked.stderr).splitlines() if ": error:" in line]
        self.assertEqual(len(problems), 1, checked.stdout + checked.stderr)
        self.assertIn("0 floor points given", problems[0])
        self.assertEqual(self.call("init", "-o", site).returncode, 2)
        self.assertEqual(site.read_text(), text)

    def test_a_changed_site_file_is_taken_up_and_a_wrong_one_is_not(self):
        port = free_port()
        site = labyrinth(self.folder / "session", f"outputs:\n  web: {{port: {port}}}\n")
        for recorded in ("ranges.csv", "odometry.csv"):  # it waits for readings that never come: nothing is looked through at its end
            site.write_text(site.read_text().replace(recorded, f"udp://127.0.0.1:{free_port()}"))
        running = Process(self.folder, "roomfix", program, "run", site)
        self.addCleanup(running.stop, True)
        wait_until(lambda: listens(port), "the page is served")

        def served(key):
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/site", timeout=30) as answer:
                    return json.loads(answer.read())[key]
            except (urllib.error.URLError, ConnectionError):
                return None  # it is just beginning anew

        def zones():
            return [zone["id"] for zone in served("zones") or ()]

        good = site.read_text()
        site.write_text(good + "zones: {dock: nowhere}\n")
        wait_until(lambda: "the old one stays" in running.text(), "the mistake is told")
        self.assertIn("zones.dock needs three or more corners", running.text())
        self.assertEqual(zones(), [])
        site.write_text(good + "zones: {dock: [[0, 0], [1, 0], [1, 1]]}\n")
        wait_until(lambda: zones() == ["dock"], "the new zone is served")
        self.assertNotIn("beginning anew", running.text())  # for that robots would have to be found anew
        site.write_text(good.replace("name: labyrinth", "name: maze"))
        wait_until(lambda: served("name") == "maze", "the new site is served")
        self.assertEqual(zones(), [])
        self.assertIn("beginning anew", running.text())
        self.assertFalse(running.ended())


if __name__ == "__main__":
    unittest.main()
