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
        link.sendto(b"\xff\xfe{nonsense\n" * 20, ("127.0.0.1", port))
        self.check(Sender(lambda text: link.sendto(text.encode(), ("127.0.0.1", port)), 1000))
        senses = self.state()["senses"]
        self.assertEqual(len(senses), 1)
        self.assertRegex(senses[0]["message"], r"r1: its clock is 1000\.0\d\d s behind ours")
        self.assertGreater(senses[0]["readings"], 20)

    def test_by_mqtt_with_a_clock_that_agrees(self):
        broker = Broker(self.folder, "allow_anonymous true")
        self.addCleanup(broker.stop)
        self.run_site("mqtt:robots/r1/sensed", "mqtt:robots/r1/sensed", f"  mqtt: {{port: {broker.port}}}\n")
        pipe = subprocess.Popen(["mosquitto_pub", "-p", str(broker.port), "-t", "robots/r1/sensed", "-l"], stdin=subprocess.PIPE, text=True)
        self.addCleanup(lambda: (pipe.stdin.close(), pipe.wait(30)))

        def send(text):
            pipe.stdin.write(text)
            pipe.stdin.flush()

        self.check(Sender(send, 0))
        wait_until(lambda: "agrees" in self.state()["senses"][0]["message"], "the clock is said to agree")


if __name__ == "__main__":
    unittest.main()
