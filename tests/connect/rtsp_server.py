"""A camera with RTSP: GStreamer's server with the pictures that come from stdin.

rtsp_server.py PORT WIDTH HEIGHT h264|jpeg
Pictures are I420, each after 8 bytes: when it was taken, nanoseconds since 1970, little endian. Prints a line once it listens.
"""
import struct
import sys
import threading
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer  # noqa: E402

port, width, height, coding = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
coder = {
    "h264": "x264enc tune=zerolatency speed-preset=ultrafast bitrate=8000 key-int-max=25 ! rtph264pay name=pay0 pt=96 config-interval=1",
    "jpeg": "jpegenc quality=90 ! rtpjpegpay name=pay0 pt=26",
}[coding]
Gst.init(None)
sources = []


def on_element(_, element):
    if "rtpbin" in element.get_name():
        element.set_property("rtcp-sync-send-time", False)  # sender reports are about when a picture was taken, not about when it is sent


def configure(_, media):
    bin = media.get_element()
    bin.get_parent().connect("element-added", on_element)
    sources.append(bin.get_by_name("camera"))


server = GstRtspServer.RTSPServer.new()
server.set_address("127.0.0.1")
server.set_service(port)
factory = GstRtspServer.RTSPMediaFactory.new()
factory.set_shared(True)
factory.set_latency(0)
factory.set_launch(
    f"( appsrc name=camera is-live=true format=time max-bytes=4000000 block=false "
    f"caps=video/x-raw,format=I420,width={width},height={height},framerate=25/1 ! {coder} )"
)
factory.connect("media-configure", configure)
server.get_mount_points().add_factory("/camera", factory)
if server.attach(None) == 0:
    sys.exit("the port is taken")
print("listening", flush=True)


def feed():
    size = width * height * 3 // 2
    while True:
        head = sys.stdin.buffer.read(8)
        picture = sys.stdin.buffer.read(size)
        if len(picture) < size:
            loop.quit()
            return
        for source in sources[-1:]:
            clock = source.get_clock()
            if clock is None:
                continue
            age = time.time_ns() - struct.unpack("<q", head)[0]
            buffer = Gst.Buffer.new_wrapped(picture)
            buffer.pts = max(0, clock.get_time() - source.get_base_time() - age)
            buffer.duration = Gst.SECOND // 25
            source.emit("push-buffer", buffer)


loop = GLib.MainLoop()
threading.Thread(target=feed, daemon=True).start()
loop.run()
