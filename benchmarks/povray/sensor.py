"""From linear light to the file that a camera writes: exposure, white balance, vignetting, noise, gamma 2.2, JPEG or PNG."""
import cv2
import numpy as np


class Sensor:
    def __init__(self, rng, shape):
        self.grey = rng.random() < 0.15
        self.jpeg = int(rng.integers(60, 96)) if rng.random() < 0.75 else None
        self.balance = np.exp(rng.normal(0, 0.06, 3))  # blue, green, red: nobody's white is exact
        self.target = rng.uniform(0.15, 0.3)           # what the empty room's mean is exposed to
        self.exposure = 1.0
        self.shot, self.read = rng.uniform(0.0002, 0.0015), rng.uniform(0.001, 0.004)
        self.blur = rng.uniform(0.3, 0.6)
        v, u = np.mgrid[0:shape[0], 0:shape[1]]
        radius = np.hypot(u - shape[1] / 2, v - shape[0] / 2) / (np.hypot(*shape) / 2)
        strength = rng.uniform(0.1, 0.45) if rng.random() < 0.5 else 0
        self.vignette = (1 - strength * radius**2).astype(np.float32)[:, :, None]

    def expose(self, light):
        """Sets the exposure once, for the room as it is."""
        self.exposure = self.target / np.minimum(light, 4 * np.median(light)).mean()

    def picture(self, light, rng, gain=1.0, balance=(1, 1, 1)):
        """8 bits, with noise of its own."""
        electric = cv2.GaussianBlur(light, (0, 0), self.blur) * self.vignette * (self.exposure * gain * self.balance * balance).astype(np.float32)
        electric = electric + rng.normal(0, 1, electric.shape) * np.sqrt(self.shot * np.maximum(electric, 0) + self.read**2)
        encoded = 255 * np.clip(electric, 0, 1) ** (1 / 2.2)
        bits = np.round(encoded).astype(np.uint8)
        return cv2.cvtColor(bits, cv2.COLOR_BGR2GRAY) if self.grey else bits

    @property
    def suffix(self):
        return "jpg" if self.jpeg else "png"

    def write(self, file, picture):
        file.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(file), picture, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg] if self.jpeg else [])
