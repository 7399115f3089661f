"""What the tests of ROS 2 topics have in common."""
import os

# Runs beside each other are in domains of their own, up to 101: beyond that the system may give DDS's ports to others.
apart = 25
domain = 1 + os.getpid() % apart
# Everything stays on this machine, and on its loopback interface.
cyclone = os.environ | {"CYCLONEDDS_URI": """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces></General>
<Discovery><Peers><Peer address="127.0.0.1"/></Peers><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>20</MaxAutoParticipantIndex></Discovery>
</Domain></CycloneDDS>"""}


def time_of(message):
    return message["sec"] * 10**9 + message["nanosec"]
