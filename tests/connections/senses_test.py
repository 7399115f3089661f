"""Readings that come by UDP and MQTT from a sender whose clock is another one, beside the way that it really drives. The program is in the variable ROOMFIX."""
import socket
import subprocess
import unittest

import driven_room
from driven_room import Sender
from peers import Broker, free_port, wait_until


class Senses(driven_room.DrivenRoom):
    def test_by_udp_with_a_clock_that_is_behind(self):
        port = free_port()
        self.run_site(f"udp://127.0.0.1:{port}", f"udp://127.0.0.1:{port}", "")
        link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(link.close)
        sender = Sender(lambda text: link.sendto(text.encode(), ("127.0.0.1", port)), 1000)

        def told():  # what is sent before the program listens is lost
            link.sendto(b"\xff\xfe{nonsense\n" * 20, ("127.0.0.1", port))
            return f"not used: udp://127.0.0.1:{port}: a line is no JSON object" in self.running.text()

        wait_until(told, "what is wrong is told while it runs")
        self.check(sender)
        senses = self.state()["senses"]
        self.assertEqual(len(senses), 1)
        self.assertRegex(senses[0]["message"], r"r1: its clock is 1000\.0\d\d s behind ours")
        self.assertGreater(senses[0]["readings"], 20)
        sender.behind += 3600  # somebody sets its clock
        self.check(sender)
        self.assertRegex(self.state()["senses"][0]["message"], r"r1: its clock is 4(600\.0|599\.9)\d\d s behind ours")
        sender.behind -= 7200
        self.check(sender)
        self.assertRegex(self.state()["senses"][0]["message"], r"r1: its clock is 2(600\.0|599\.9)\d\d s ahead of ours")

    def test_by_mqtt_with_a_clock_that_agrees(self):
        broker = Broker(self.folder, "allow_anonymous true")
        self.addCleanup(broker.stop)
        self.run_site("mqtt:robots/r1/sensed", "mqtt:robots/r1/sensed", f"  mqtt: {{port: {broker.port}}}\n")
        pipe = subprocess.Popen(["mosquitto_pub", "-p", str(broker.port), "-t", "robots/r1/sensed", "-l"], stdin=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (pipe.stdin.close(), pipe.wait(30)))

        def send(text):
            pipe.stdin.write(text)
            pipe.stdin.flush()

        sender = Sender(send, 0)
        self.check(sender)
        wait_until(lambda: "agrees" in self.state()["senses"][0]["message"], "the clock is said to agree")

        # A flood on the same topic, from somebody else.
        nonsense = [b"\xff\xfe\x00", b"{" * 200, b'{"time": 1e400, "robot": "r1", "x": 0}', b'{"time": 1, "robot": "r1", "beacon": "n1", "range": "far"}', b"[]" * 3000]
        with open(self.folder / "flood", "wb") as flood:
            for i in range(50000):
                flood.write(nonsense[i % 5] + b"\n")
        flooding = subprocess.Popen(["mosquitto_pub", "-p", str(broker.port), "-t", "robots/r1/sensed", "-l"], stdin=open(self.folder / "flood", "rb"))
        self.check(sender)
        self.assertEqual(flooding.wait(60), 0)


if __name__ == "__main__":
    unittest.main()
