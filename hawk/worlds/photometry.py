"""What a camera and the weather make of a scene."""

from __future__ import annotations

import cv2
import numpy as np

from hawk.worlds.canvas import Bytes, Floats, as_bytes, as_floats, noise


def photograph(rng: np.random.Generator, image: Floats) -> Bytes:
    """Return a BGR float picture (0..255) as one of many cameras would show it (uint8)."""
    picture = _tone(rng, image.astype(np.float32))
    picture = _sharpness(rng, picture)
    picture += rng.standard_normal(picture.shape, np.float32) * np.float32(5 * rng.uniform(0, 1) ** 2)
    result = as_bytes(np.clip(picture, 0, 255))
    if rng.random() < 0.6:
        quality = int(rng.uniform(40, 95))
        encoded = cv2.imencode(".jpg", result, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        result = as_bytes(np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR)))
    return result


def _tone(rng: np.random.Generator, picture: Floats) -> Floats:
    """Exposure, gamma, colour cast, contrast, saturation; sometimes dusk, often haze. Half change little."""
    amount = 1.0 if rng.random() < 0.5 else 0.4
    picture = picture * np.float32(np.exp(rng.uniform(-0.2, 0.45) * amount))
    if rng.random() < 0.05:  # dusk and lamps
        height, width = picture.shape[:2]
        lamps = 1 + noise(rng, height, width, [90], [0.3])
        picture *= np.array([0.66, 0.58, 0.6], np.float32) * np.clip(lamps, 0.5, 1.6)[..., None]
    np.clip(picture, 0, 255, out=picture)
    gamma = float(np.exp(rng.uniform(-0.35, 0.33) * amount))
    picture = as_floats(cv2.pow(picture * np.float32(1 / 255), gamma)) * np.float32(255)
    picture *= np.exp(rng.normal(0, 0.05, 3) * amount).astype(np.float32)
    mean = picture.mean()
    picture = (picture - mean) * np.float32(np.exp(rng.uniform(-0.25, 0.26) * amount)) + mean
    if rng.random() < 0.4:
        grey = picture.mean(2, keepdims=True)
        picture = grey + (picture - grey) * np.float32(rng.uniform(0.1, 0.9) if rng.random() < 0.7 else 1.35)
    if rng.random() < 0.4:  # haze: what is dark turns pale and somewhat blue
        veil = np.float32(rng.uniform(130, 230)) + np.array([1, 0, -1], np.float32) * np.float32(rng.uniform(-5, 30))
        picture += (veil - picture) * np.float32(rng.uniform(0.03, 0.3))
    return picture


def _sharpness(rng: np.random.Generator, picture: Floats) -> Floats:
    """Blur some pictures and sharpen more: at this scale most cameras' pictures have been made smaller."""
    if rng.random() < 0.7:  # cameras and map services take the grain out and leave the edges
        picture = np.asarray(cv2.bilateralFilter(picture, 5, rng.uniform(8, 32), rng.uniform(1.2, 3.0)), np.float32)
    if rng.random() < 0.4:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.3, 1.05)), np.float32)
    if rng.random() < 0.06:  # the drone moved while the shutter was open
        length, angle = int(rng.integers(1, 4)), rng.uniform(0, np.pi)
        kernel = np.zeros((2 * length + 1, 2 * length + 1), np.float32)
        reach = (int(length * np.cos(angle)), int(length * np.sin(angle)))
        cv2.line(kernel, (length - reach[0], length - reach[1]), (length + reach[0], length + reach[1]), 1.0, 1)
        picture = np.asarray(cv2.filter2D(picture, -1, kernel / kernel.sum()), np.float32)
    if rng.random() < 0.65:
        soft = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.8, 1.6))
        picture = picture + (picture - soft) * np.float32(rng.uniform(0.3, 1.4))
    return picture
