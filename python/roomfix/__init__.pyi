from os import PathLike
from typing import Dict, List, Literal, Mapping, Optional, Sequence, TypedDict, Union

import numpy
from numpy.typing import NDArray

__version__: str

class Error(ValueError):
    """What a site, a picture or an input has wrong, in a sentence that says what to do."""

class Site:
    """The description of a room: cameras, robots, beacons, landmarks by their names."""

    @property
    def name(self) -> str: ...
    @property
    def cameras(self) -> List[str]: ...
    @property
    def robots(self) -> List[str]: ...
    @property
    def beacons(self) -> List[str]: ...
    @property
    def landmarks(self) -> List[str]: ...

def load_site(file: Union[str, PathLike[str]]) -> Site:
    """Reads a site file, or that of a session's folder. Raises Error, with every mistake and its line."""

def load_grey(file: Union[str, PathLike[str]]) -> NDArray[numpy.uint8]:
    """A picture of any usual format as grey levels, height x width."""

class Hypothesis:
    """One of several poses that explain the same picture; the weights of all add up to 1."""

    @property
    def pose(self) -> NDArray[numpy.float64]: ...
    @property
    def weight(self) -> float: ...

class Fix:
    """A robot's pose at a time."""

    @property
    def time(self) -> float:
        """s"""
    @property
    def time_ns(self) -> int: ...
    @property
    def robot(self) -> str:
        """Its name; of an unknown thing the name that it was given; empty where none was found."""
    @property
    def unknown(self) -> bool:
        """A person, a chair or whatever else is no robot of the site."""
    @property
    def status(self) -> Literal["ok", "coasting", "none"]:
        """ok: something saw it; coasting: predicted; none: it is lost, `reason` says why."""
    @property
    def pose(self) -> NDArray[numpy.float64]:
        """x, y, yaw: m, m, rad, map frame."""
    @property
    def yaw_known(self) -> bool: ...
    @property
    def covariance(self) -> NDArray[numpy.float64]:
        """3 x 3, of x, y, yaw."""
    @property
    def sources(self) -> List[str]: ...
    @property
    def reason(self) -> str: ...
    @property
    def identity(self) -> float:
        """The probability that it is this robot and not one that looks the same."""
    @property
    def hypotheses(self) -> List[Hypothesis]: ...

Order = Literal["rgb", "bgr"]

class Camera:
    """Finds robots in single pictures of one camera, without tracking."""

    def __init__(self, site: Site, camera: str, background: Sequence[str] = ...) -> None:
        """`background`: pictures, folders or videos without robots, for a fixed camera; by default what the site says."""
    def fix(self, picture: NDArray[numpy.uint8], order: Order = "rgb") -> List[Fix]:
        """`picture`: height x width (grey) or height x width x 3; of OpenCV's pictures `order` is "bgr"."""

class Tracker:
    """One pose per robot from everything that is put in. Times must be of one clock. Each call gives the fixes that it made due."""

    def __init__(self, site: Site, background: Sequence[str] = ...) -> None:
        """`background`: of all fixed cameras; by default what the site says, otherwise it is learned on the way."""
    def frame(self, camera: str, picture: NDArray[numpy.uint8], time: float, order: Order = "rgb") -> List[Fix]: ...
    def frames(self, pictures: Mapping[str, NDArray[numpy.uint8]], time: float, order: Order = "rgb") -> List[Fix]:
        """Pictures of several cameras at the same moment: they are fitted together."""
    def range(self, robot: str, beacon: str, range: float, time: float, sigma: Optional[float] = None, receiver: str = "") -> List[Fix]:
        """m; `sigma`: by default the receiver's."""
    def odometry(self, robot: str, x: float, y: float, yaw: float, time: float) -> List[Fix]:
        """The pose in the robot's own odom frame, which starts anywhere and drifts."""
    def sighting(self, robot: str, landmark: Optional[str] = None, range: Optional[float] = None, bearing: Optional[float] = None, *, time: float) -> List[Fix]:
        """What a robot's own detector saw; without `landmark` it does not say which one. m, rad to the left."""
    def fixes(self, time: float) -> List[Fix]:
        """Every robot that anything was said of, at that time; also one that was lost since."""
    @property
    def cameras(self) -> Dict[str, str]:
        """What is to be said of each camera: ok, changed, frozen, quarantined, with the reason."""

def replay(session: Union[str, PathLike[str]], background: Sequence[str] = ..., threads: Optional[int] = None, smooth: bool = False) -> List[Fix]:
    """The fixes that `roomfix replay` writes; with `smooth` those of `roomfix replay --smooth`."""

class Arrays(TypedDict):
    time: NDArray[numpy.float64]
    pose: NDArray[numpy.float64]
    covariance: NDArray[numpy.float64]
    robot: NDArray[numpy.str_]
    status: NDArray[numpy.str_]

def arrays(fixes: Sequence[Fix], robot: Optional[str] = None) -> Arrays:
    """Fixes as numpy arrays; those without a place are left out."""
