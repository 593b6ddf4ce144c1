#!/usr/bin/env python3
"""Shows the pictures of a camera component: camera_reader.py [Camera(0/0)]. Needs OpenCV (python3-opencv)."""

import importlib
import sys
from typing import Any

import numpy

import rack
import tims
from rack.messages import CameraData, CameraProxy

MONO8, RGB24, JPEG = 1, 11, 41  # CameraData.mode


def opencv() -> Any:
    return importlib.import_module("cv2")


def picture(data: CameraData) -> Any:
    """As OpenCV has it: rows of grey values, or of blue, green, red. ValueError: another mode."""
    pixels = numpy.frombuffer(data.image, numpy.uint8)
    if data.mode == MONO8:
        return pixels.reshape(data.height, data.width)
    if data.mode == RGB24:
        return pixels.reshape(data.height, data.width, 3)[:, :, ::-1]
    if data.mode == JPEG:
        return opencv().imdecode(pixels, 1)
    raise ValueError(f"pictures of mode {data.mode} are not shown: set the camera to mono8, rgb24 or jpeg")


def main() -> int:
    cv2 = opencv()
    name = sys.argv[1] if len(sys.argv) > 1 else "Camera(0/0)"
    with tims.Session(timeout=5) as session, session.open("Tool(0/30)", 4, 65536) as work:
        # Two slots: an older picture is replaced, so what is shown is new.
        with session.open("Tool(0/31)", 2, 4_000_000) as pictures:
            camera = CameraProxy(work, name)
            camera.on()
            for data in camera.stream(pictures, timeout=10):
                cv2.imshow(name, picture(data))
                if cv2.waitKey(1) == ord("q"):
                    return 0
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (tims.Error, rack.CodecError, ValueError) as error:
        sys.exit(f"camera_reader: {error}")
