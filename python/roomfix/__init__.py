"""Finds robots indoors with ordinary cameras: sites, single pictures, the tracker, recorded sessions.

    import roomfix
    for fix in roomfix.replay("session"):
        print(fix.time, fix.robot, fix.status, fix.pose, fix.covariance)

Lengths are m, angles rad, times s since 1970, poses (x, y, yaw) in the site's map frame, covariances 3 x 3 in that order. `help(roomfix.Tracker)`
and the others say more; docs/python.md has examples.
"""
import numpy as _numpy

from ._roomfix import Camera, Error, Fix, Hypothesis, Site, Tracker, __version__, load_grey, load_site, replay

Error.__module__ = "roomfix"

__all__ = ["Camera", "Error", "Fix", "Hypothesis", "Site", "Tracker", "__version__", "arrays", "load_grey", "load_site", "replay"]


def arrays(fixes, robot=None):
    """Fixes as numpy arrays: a dict of `time` (N; s), `pose` (N x 3; m, m, rad), `covariance` (N x 3 x 3), `robot` and `status` (N; str).

    Only those of one robot where `robot` is given; fixes without a place (status "none") are left out.
    """
    kept = [fix for fix in fixes if fix.status != "none" and (robot is None or fix.robot == robot)]
    return {
        "time": _numpy.array([fix.time for fix in kept], dtype=float),
        "pose": _numpy.array([fix.pose for fix in kept], dtype=float).reshape(-1, 3),
        "covariance": _numpy.array([fix.covariance for fix in kept], dtype=float).reshape(-1, 3, 3),
        "robot": _numpy.array([fix.robot for fix in kept], dtype=str),
        "status": _numpy.array([fix.status for fix in kept], dtype=str),
    }
