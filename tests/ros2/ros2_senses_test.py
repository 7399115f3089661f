"""Wheels that come on a ROS 2 topic by another vendor's DDS (Cyclone), beside the way that the robot really drives, and what ROS 2 is told of it. The programs
are in the variables ROOMFIX, LISTENER and WHEELS."""
import json
import math
import os
import pathlib
import socket
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "connections"))
import driven_room
from driven_room import Sender, truth
from peers import Process, fixes_of, free_port, program, wait_until
from ros2_peer import apart, cyclone, domain, time_of

domain += 3 * apart
topic = "/r1/odom"


class Wheels:
    """The robot's node."""

    def __init__(self, test, reliability):
        command = [os.environ["WHEELS"], str(domain), topic, reliability]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, text=True, env=cyclone)
        test.addCleanup(self.kill)

    def send(self, line):
        whole, part = divmod(round(line["time"] * 1e9), 10**9)
        self.process.stdin.write(f"{whole} {part} {line['x']} {line['y']} {line['yaw']}\n")
        self.process.stdin.flush()

    def kill(self):
        self.process.kill()
        self.process.wait(30)
        self.process.stdin.close()


class Ros2Senses(driven_room.DrivenRoom):
    def start(self):
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(self.link.close)
        self.ranges = free_port()
        self.wheels = None
        return self.run_site(f"udp://127.0.0.1:{self.ranges}", f"ros2:{topic}", f"  ros2: {{domain: {domain}}}\n", env=os.environ | {"ROS_LOCALHOST_ONLY": "1"})

    def send(self, text):
        for line in text.splitlines():
            if "range" in json.loads(line):
                self.link.sendto(line.encode(), ("127.0.0.1", self.ranges))
            elif self.wheels:
                self.wheels.send(json.loads(line))

    def sense(self):
        return next((sense for sense in self.state().get("senses", []) if sense["source"] == f"ros2:{topic}"), {"message": "", "readings": 0})

    def drive_until(self, sender, holds, what):
        def one_more():
            sender.report()
            return holds()

        wait_until(one_more, what)

    def doctor(self, sender):
        """What it says of the wheels while the robot drives."""
        doctor = Process(self.folder, "doctor", program, "doctor", self.folder / "site.yaml", env=os.environ | {"ROS_LOCALHOST_ONLY": "1"})
        self.drive_until(sender, doctor.ended, "the doctor has looked at everything")
        return next(line for line in doctor.lines() if "odometry" in line)

    def test_wheels_of_either_reliability_that_die_and_come_back(self):
        running = self.start()
        heard = self.folder / "heard"
        with open(heard, "w") as out:
            listener = subprocess.Popen([os.environ["LISTENER"], str(domain), "r1", "none"], stdin=subprocess.PIPE, stdout=out, env=cyclone)
        self.addCleanup(lambda: (listener.kill(), listener.wait(30)))
        wait_until(lambda: "nobody publishes nav_msgs/msg/Odometry on /r1/odom" in self.sense()["message"], "it is said that there are no wheels")
        sender = Sender(self.send, 1000)
        self.wheels = Wheels(self, "best_effort")
        self.drive_until(sender, lambda: self.sense()["readings"] > 0, "wheels are heard")
        self.assertIn("reports: its clock is", self.doctor(sender))
        self.check(sender)
        self.assertRegex(self.sense()["message"], r"its clock is 1000\.0\d\d s behind ours")
        self.wheels.kill()
        self.wheels = None
        wait_until(lambda: "silent for" in self.sense()["message"], "the silence is told")
        before = self.sense()["readings"]
        self.wheels = Wheels(self, "reliable")
        self.drive_until(sender, lambda: self.sense()["readings"] > before + 10, "wheels are heard again")
        self.check(sender)
        self.drive_until(sender, lambda: '"name": "/roomfix_senses"' in heard.read_text(), "the node that listens is told")
        listener.communicate(timeout=30)  # while those whom it hears are still there
        self.assertEqual(running.stop(), 0, running.text())
        self.check_heard([json.loads(line) for line in heard.read_text().splitlines()], sender)

    def check_heard(self, messages, sender):
        odometry = [m["odometry"] for m in messages if "odometry" in m]
        fixes = {}
        for line in (self.folder / "fixes.jsonl").read_text().splitlines():
            fix = json.loads(line)
            if fix["status"] != "none":
                whole, _, part = line.split('"time": ')[1].split(",")[0].partition(".")
                fixes.setdefault(int(whole) * 10**9 + int(part.ljust(9, "0")), []).append(fix)
        self.assertGreater(len(odometry), 20)
        for message in odometry:
            self.check_odometry(message, fixes.get(time_of(message), []))
        self.check_velocities(fixes, sender)
        last = {m["node"]["name"]: m["node"] for m in messages if "node" in m}
        self.assertEqual(set(last) - {"/listener"}, {"/roomfix", "/roomfix_senses"})
        self.assertEqual((last["/roomfix"]["readers"], last["/roomfix_senses"]["readers"]), (0, 1))
        writer = next(m["publication"]["writer"] for m in messages if "publication" in m)
        self.assertIn(writer, last["/roomfix"]["writers"])  # as DDS itself numbers it
        self.assertTrue(writer.startswith(last["/roomfix"]["participant"][:24]))

    def check_odometry(self, message, fixes):
        """It is a fix of the file, with its velocity in the robot's own axes."""
        fix = next((f for f in fixes if math.dist(message["position"][:2], (f["x"], f["y"])) < 2e-6 and "velocity" in f), None)
        self.assertIsNotNone(fix, message)
        self.assertEqual((message["frame"], message["child"]), ("map", "base_link"))
        c, s = math.cos(fix["yaw"]), math.sin(fix["yaw"])
        vx, vy, turn = fix["velocity"]
        for value, right in zip(message["twist"], (c * vx + s * vy, c * vy - s * vx, 0, 0, 0, turn)):
            self.assertAlmostEqual(value, right, delta=3e-6)
        for name in ("covariance", "twist_covariance"):
            self.assertTrue(all(math.isfinite(value) for value in message[name]))
            self.assertTrue(all(message[name][7 * i] > 0 for i in range(6)))
        self.assertAlmostEqual(message["twist_covariance"][35], fix["velocity_covariance"][8], delta=1e-7)

    def check_velocities(self, fixes, sender):
        """As it really drove, by what they say of themselves: 3 standard deviations for nearly all."""
        right = total = 0
        for time, at_that_time in fixes.items():
            _, _, yaw = truth(1e-9 * time - sender.start)
            speed, turn = 1.5 * 2 * math.pi / 16, 2 * math.pi / 16
            for fix in at_that_time:
                if "velocity" in fix:
                    true = (speed * math.cos(yaw), speed * math.sin(yaw), turn)
                    sigmas = [math.sqrt(fix["velocity_covariance"][4 * i]) for i in range(3)]
                    right += all(abs(fix["velocity"][i] - true[i]) < 3 * sigmas[i] for i in range(3))
                    total += 1
        print(f"{right} of {total} velocities are within 3 standard deviations of the truth")
        self.assertGreater(right, 0.9 * total)


if __name__ == "__main__":
    unittest.main()
