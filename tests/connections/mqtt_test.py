"""Fixes on MQTT beside the fixes in a file, with a real broker that refuses, dies and comes back. The program is in the variable ROOMFIX."""
import json
import pathlib
import socket
import sqlite3
import subprocess
import unittest

from peers import Broker, Process, certificate, fixes_of, free_port, labyrinth, program, temporary_folder, wait_until


class Mqtt(unittest.TestCase):
    def setUp(self):
        self.temporary = temporary_folder()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)

    def broker(self, *settings):
        broker = Broker(self.folder, *(settings or ["allow_anonymous true"]))
        self.addCleanup(broker.stop)
        return broker

    def subscribe(self, broker, *arguments):
        subscriber = broker.subscribe(*arguments)
        self.addCleanup(subscriber.stop, True)
        return subscriber

    def run_site(self, broker_settings, *options, more=""):
        """The recorded drive to its end."""
        site = labyrinth(self.folder / "session", f"outputs:\n  mqtt: {{{broker_settings}}}\n{more}", seconds=14)
        command = [program, "run", site, "--speed", "0", "--no-page", "--fixes", self.folder / "fixes.jsonl", *options]
        return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)

    def test_poses_are_those_of_the_file(self):
        broker = self.broker()
        subscriber = self.subscribe(broker, "poses")
        subprocess.run(["mosquitto_pub", "-p", str(broker.port), "-t", "ready", "-m", "yes", "-r"], check=True)
        wait_until(lambda: ["ready", "yes"] in subscriber.messages(), "the subscriber hears")
        done = self.run_site(f"port: {broker.port}, rate: 0, home_assistant: true",
                             more=f"  history: {{database: {self.folder}/history.db}}\nzones:\n  start: [[0, 0], [1.2, 0], [1.2, 2.4], [0, 2.4]]\n")
        self.assertEqual(done.returncode, 0, done.stderr)
        wait_until(lambda: ["roomfix/labyrinth/status", "offline"] in subscriber.messages(), "roomfix said goodbye")
        messages = subscriber.messages()
        poses = [json.loads(payload) for topic, payload in messages if topic == "roomfix/labyrinth/r/pose"]
        fixes = [fix for fix in fixes_of(self.folder / "fixes.jsonl") if fix["status"] != "none"]
        self.assertGreater(len(fixes), 100)
        self.assertEqual([(p["x"], p["y"], p["status"]) for p in poses], [(f["x"], f["y"], f["status"]) for f in fixes])
        for pose, fix in zip(poses, fixes):
            self.assertAlmostEqual(pose["cov"][3], fix["covariance"][4], delta=1e-8 * fix["covariance"][4])
            self.assertGreater(pose["cov"][0], 0)

        events = [json.loads(payload)["event"] for topic, payload in messages if topic == "roomfix/labyrinth/zones/start"]
        self.assertGreater(len(events), 0)
        with sqlite3.connect(self.folder / "history.db") as history:
            self.assertEqual([event for event, in history.execute("SELECT event FROM roomfix_zone_events ORDER BY number")], events, "the history tells the same")
        self.assertTrue(all(a != b for a, b in zip(events, events[1:])), events)  # in and out in turns

        topics = {topic for topic, _ in messages}
        configurations = [json.loads(payload) for topic, payload in messages if topic.startswith("homeassistant/")]
        self.assertEqual(len(configurations), 5)
        for configuration in configurations:
            self.assertIn(configuration["state_topic"], topics)
            for availability in configuration["availability"]:
                self.assertIn(availability["topic"], topics)

    def test_the_rate_is_kept(self):
        broker = self.broker()
        subscriber = self.subscribe(broker, "poses", "roomfix/#")
        done = self.run_site(f"port: {broker.port}, rate: 2")
        self.assertEqual(done.returncode, 0, done.stderr)
        wait_until(lambda: ["roomfix/labyrinth/status", "offline"] in subscriber.messages(), "roomfix said goodbye")
        poses = [payload for topic, payload in subscriber.messages() if topic.endswith("/pose")]
        fixes = [fix for fix in fixes_of(self.folder / "fixes.jsonl") if fix["status"] != "none"]
        self.assertLessEqual(len(poses), 2 * (fixes[-1]["time"] - fixes[0]["time"]) + 1)
        self.assertGreater(len(poses), 10)

    def test_a_broker_that_dies_and_comes_back(self):
        broker = self.broker()
        site = labyrinth(self.folder / "session", f"outputs:\n  mqtt: {{port: {broker.port}, rate: 0}}\n")
        first = self.subscribe(broker, "first", "roomfix/labyrinth/r/pose")
        running = Process(self.folder, "roomfix", program, "run", site, "--speed", "4", "--no-page", "--fixes", self.folder / "fixes.jsonl")
        self.addCleanup(running.stop, True)
        wait_until(lambda: first.messages(), "poses come")
        broker.stop(kill=True)
        known = len(fixes_of(self.folder / "fixes.jsonl"))
        wait_until(lambda: len(fixes_of(self.folder / "fixes.jsonl")) > known + 10, "fixes go on without the broker")
        broker.start()
        second = self.subscribe(broker, "second", "roomfix/labyrinth/#")
        wait_until(lambda: any(topic.endswith("/pose") for topic, _ in second.messages()), "poses come again")
        self.assertIn(["roomfix/labyrinth/status", "online"], second.messages())
        self.assertIn(["roomfix/labyrinth/r/status", "online"], second.messages())
        running.stop(kill=True)
        wait_until(lambda: second.messages()[-1] == ["roomfix/labyrinth/status", "offline"], "the broker says that roomfix is gone")
        self.assertEqual(broker.retained("roomfix/labyrinth/status"), "offline")

    def test_a_wrong_password_is_told_and_the_fixes_are_kept(self):
        passwords = self.folder / "passwords"
        subprocess.run(["mosquitto_passwd", "-b", "-c", str(passwords), "robots", "right"], check=True)
        passwords.chmod(0o600)
        broker = self.broker("allow_anonymous false", f"password_file {passwords}")
        (self.folder / "secret").write_text("wrong\n")
        done = self.run_site(f"port: {broker.port}, user: robots, password: {{file: {self.folder}/secret}}")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("Not authorized", done.stderr)
        self.assertIn("check user and password", done.stderr)
        self.assertNotIn("wrong", done.stderr)
        self.assertGreater(len(fixes_of(self.folder / "fixes.jsonl")), 100)
        (self.folder / "secret").write_text("right\n")
        done = self.run_site(f"port: {broker.port}, user: robots, password: {{file: {self.folder}/secret}}")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_no_broker_is_told_and_the_fixes_are_kept(self):
        done = self.run_site(f"port: {free_port()}")
        self.assertEqual(done.returncode, 1)
        self.assertIn("cannot be reached: Connection refused", done.stderr)
        self.assertGreater(len(fixes_of(self.folder / "fixes.jsonl")), 100)

    def test_what_is_no_broker_is_told(self):
        with socket.socket() as silent:
            silent.bind(("127.0.0.1", 0))
            silent.listen()
            done = self.run_site(f"port: {silent.getsockname()[1]}")
        self.assertEqual(done.returncode, 1)
        self.assertIn("is it a broker, and is this its port?", done.stderr)
        broker = self.broker()
        certificate(self.folder, "ca", "ca", 2)
        done = self.run_site(f"port: {broker.port}, tls: {{ca: {self.folder}/ca.crt}}")
        self.assertEqual(done.returncode, 1)
        self.assertIn("is this the port at which the broker speaks it?", done.stderr)

    def test_a_password_that_is_nowhere_is_told_before_the_start(self):
        done = self.run_site("user: robots, password: {env: ROOMFIX_TEST_NO_SUCH_VARIABLE}")
        self.assertEqual(done.returncode, 2)
        self.assertIn("ROOMFIX_TEST_NO_SUCH_VARIABLE", done.stderr)

    def test_only_a_certificate_that_is_right_is_believed(self):
        for name, host, days, ca in (("ca", "ca", 2, None), ("good", "127.0.0.1", 2, "ca"), ("elsewhere", "other.example", 2, "ca"),
                                     ("old", "127.0.0.1", -1, "ca"), ("stranger", "127.0.0.1", 2, None)):
            certificate(self.folder, name, host, days, ca)
        for name, reason in (("good", None), ("elsewhere", "another host"), ("old", "expired"), ("stranger", "self-signed")):
            with self.subTest(name):
                broker = Broker(self.folder, "allow_anonymous true", f"certfile {self.folder}/{name}.crt", f"keyfile {self.folder}/{name}.key")
                done = self.run_site(f"port: {broker.port}, tls: {{ca: {self.folder}/ca.crt}}")
                broker.stop()
                self.assertEqual(done.returncode, 0 if reason is None else 1, done.stderr)
                if reason:
                    self.assertIn(reason, done.stderr.lower())


if __name__ == "__main__":
    unittest.main()
