"""EXIF and XMP of a photograph as DJI's cameras write them, and their place in the JPEG."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

from hawk.runtime.late import load
from hawk.runtime.programs import remedy

_BASE: Final = {"make": 271, "model": 272, "orientation": 274, "software": 305, "changed": 306}
_EXIF_IFD, _GPS_IFD = 0x8769, 0x8825
_SEGMENT: Final = b"\xff\xe1"
_XMP: Final = b"http://ns.adobe.com/xap/1.0/\x00"
_SECOND_PARTS: Final = 10_000
"""Of an arc second: DJI's resolution of a place, 3 mm."""


class TagsError(Exception):
    """Tags cannot be written; the text gives the remedy."""


@dataclass(frozen=True, slots=True)
class DroneCamera:
    """A drone's camera: lengths in millimetres, ``film_mm`` on 35 mm film, ``shape`` is height over width."""

    model: str
    focal_mm: float
    sensor_mm: float
    film_mm: int
    shape: float

    def focal_px(self, width: int) -> float:
        """Return the nominal focal length of a picture of this width, pixels."""
        return self.focal_mm / self.sensor_mm * width

    def height_px(self, width: int) -> int:
        """Return the even height of a picture of this width."""
        return 2 * round(self.shape * width / 2)


CAMERAS: Final = {
    camera.model: camera
    for camera in (
        DroneCamera("FC330", 3.61, 6.2, 20, 3 / 4),
        DroneCamera("FC6310", 8.8, 13.13, 24, 2 / 3),
        DroneCamera("FC3170", 4.5, 6.4, 24, 3 / 4),
        DroneCamera("FC7303", 4.49, 6.2, 24, 3 / 4),
        DroneCamera("L1D-20c", 10.26, 13.13, 28, 2 / 3),
        DroneCamera("M3E", 12.29, 17.42, 24, 3 / 4),
    )
}
"""Phantom 4, Phantom 4 Pro, Mavic Air 2, Mini 2, Mavic 2 Pro and Mavic 3 Enterprise, by their specifications."""


@dataclass(frozen=True, slots=True)
class Written:
    """Facts that a photograph's tags give: ``latitude``, ``longitude`` and ``yaw`` in degrees, ``altitude`` above the
    sea and ``height`` above the take-off place in metres, ``time`` aware, ``focal_px`` the nominal focal length.
    """

    camera: DroneCamera
    size: tuple[int, int]
    focal_px: float
    time: datetime
    latitude: float
    longitude: float
    altitude: float
    height: float
    yaw: float


def tagged(jpeg: bytes, written: Written) -> bytes:
    """Return a JPEG with EXIF and XMP before its picture. Raises TagsError without Pillow."""
    segments = (_exif(written), _XMP + _xmp(written).encode())
    return jpeg[:2] + b"".join(_SEGMENT + (len(each) + 2).to_bytes(2, "big") + each for each in segments) + jpeg[2:]


def _exif(written: Written) -> bytes:
    try:
        pil = load("PIL", "Image", "TiffImagePlugin")  # an extra
    except ImportError as error:
        raise TagsError(f"Pillow is not installed, which writes EXIF: {remedy('pictures')}") from error

    def ratio(value: float, parts: int) -> Any:
        return pil.TiffImagePlugin.IFDRational(round(value * parts), parts)

    moment = f"{written.time:%Y:%m:%d %H:%M:%S}"
    camera, (width, height) = written.camera, written.size
    base = {"make": "DJI", "model": camera.model, "orientation": 1, "software": "hawk-sim", "changed": moment}
    exif = pil.Image.Exif()
    for name, value in base.items():
        exif[_BASE[name]] = value
    exif.get_ifd(_EXIF_IFD).update(
        {
            0x9003: moment,
            0x9004: moment,
            0x9011: f"{written.time:%z}"[:3] + ":" + f"{written.time:%z}"[3:5],
            0x920A: ratio(camera.focal_mm, 100),
            0xA405: camera.film_mm,
            0xA002: width,
            0xA003: height,
            0xA404: ratio(1.0, 1),
        }
    )
    exif.get_ifd(_GPS_IFD).update(
        {
            0: b"\x02\x03\x00\x00",
            1: "S" if written.latitude < 0 else "N",
            2: _degrees(written.latitude, ratio),
            3: "W" if written.longitude < 0 else "E",
            4: _degrees(written.longitude, ratio),
            5: b"\x01" if written.altitude < 0 else b"\x00",
            6: ratio(abs(written.altitude), 1000),
        }
    )
    return bytes(exif.tobytes())


def _degrees(value: float, ratio: Any) -> tuple[Any, Any, Any]:
    parts = round(abs(value) * 3600 * _SECOND_PARTS)
    minutes, rest = divmod(parts, 60 * _SECOND_PARTS)
    return ratio(minutes // 60, 1), ratio(minutes % 60, 1), ratio(rest / _SECOND_PARTS, _SECOND_PARTS)


def _xmp(written: Written) -> str:
    yaw = math.degrees(math.remainder(math.radians(written.yaw), math.tau))
    day = f"{written.time:%Y-%m-%d}"
    tags = {
        "xmp:ModifyDate": day,
        "xmp:CreateDate": day,
        "tiff:Make": "DJI",
        "tiff:Model": written.camera.model,
        "dc:format": "image/jpeg",
        "drone-dji:AbsoluteAltitude": f"{written.altitude:+.2f}",
        "drone-dji:RelativeAltitude": f"{written.height:+.2f}",
        "drone-dji:GpsLatitude": f"{written.latitude:.8f}",
        "drone-dji:GpsLongitude": f"{written.longitude:.8f}",
        "drone-dji:GimbalRollDegree": "+0.00",
        "drone-dji:GimbalYawDegree": f"{yaw:+.2f}",
        "drone-dji:GimbalPitchDegree": "-90.00",
        "drone-dji:FlightRollDegree": "+0.00",
        "drone-dji:FlightYawDegree": f"{yaw:+.2f}",
        "drone-dji:FlightPitchDegree": "+0.00",
        "drone-dji:CamReverse": "0",
        "drone-dji:GimbalReverse": "0",
        "drone-dji:RtkFlag": "0",
        "drone-dji:CalibratedFocalLength": f"{written.focal_px:.6f}",
        "drone-dji:CalibratedOpticalCenterX": f"{written.size[0] / 2:.6f}",
        "drone-dji:CalibratedOpticalCenterY": f"{written.size[1] / 2:.6f}",
        "crs:Version": "7.0",
        "crs:HasSettings": "False",
        "crs:HasCrop": "False",
        "crs:AlreadyApplied": "False",
    }
    attributes = "\n   ".join(f'{name}="{value}"' for name, value in tags.items())
    return _PACKET.format(attributes=attributes)


_PACKET: Final = """<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
 <rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
  <rdf:Description rdf:about="DJI Meta Data"
   xmlns:tiff="http://ns.adobe.com/tiff/1.0/"
   xmlns:xmp="http://ns.adobe.com/xap/1.0/"
   xmlns:dc="http://purl.org/dc/elements/1.1/"
   xmlns:crs="http://ns.adobe.com/camera-raw-settings/1.0/"
   xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/"
   {attributes}>
  </rdf:Description>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end="w"?>"""
