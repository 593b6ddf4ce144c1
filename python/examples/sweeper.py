#!/usr/bin/env python3
"""Sweeper: a simulated ladar, to start from. It is a component like any other: try --help, --describe, timsctl."""

import math
import sys

import rack
from rack.messages import LadarData, LadarPoint, LadarProxy


class Sweeper(rack.DataModule[LadarData]):
    """Scans a round room."""

    DATA, CLASS_ID = LadarData, LadarProxy.CLASS_ID
    PARAMETERS = [rack.integer("period", 100, "period of the data [ms]", 10, 60000),
                  rack.integer("radius", 3000, "radius of the room [mm]", 100, 30000, takes_effect=rack.NOW)]

    def module_on(self) -> None:
        self.period = self.integer("period")

    def module_loop(self) -> None:
        self.sleep_until_next()
        angles = [math.radians(degrees) for degrees in range(-90, 91)]
        radius = self.integer("radius")
        self.put(LadarData(recordingTime=rack.time_stamp(), duration=self.period, maxRange=30000, startAngle=angles[0],
                           endAngle=angles[-1], points=[LadarPoint(angle, radius) for angle in angles]))


if __name__ == "__main__":
    sys.exit(Sweeper().run())
