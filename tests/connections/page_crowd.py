"""Clients of the page that take a connection each and give nothing for it."""
import contextlib
import socket


class PageCrowd(contextlib.ExitStack):
    """200 idle and slow clients, 40 of them in the middle of something, and `streams`: 100 that listen to events."""

    def __init__(self, port):
        super().__init__()
        self.port = port
        listens = b"GET /api/events HTTP/1.1\r\nHost: x\r\n\r\n"
        for _ in range(160):
            self.connect(b"")  # idle
        for _ in range(20):
            self.connect(b"GET /api/state HTTP/1.1\r\nHost: ")  # a request that never ends
        for _ in range(20):
            self.connect(listens)  # but takes nothing
        self.streams = [self.connect(listens) for _ in range(100)]

    def connect(self, first):
        one = self.enter_context(socket.create_connection(("127.0.0.1", self.port), timeout=30))
        one.sendall(first)
        return one
