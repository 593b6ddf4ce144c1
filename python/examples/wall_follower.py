#!/usr/bin/env python3
"""WallFollower: drives along the wall at its left, with a ladar and a chassis."""

import math
import sys

import rack
from rack.messages import ChassisProxy, LadarData, LadarProxy, PilotData, PilotProxy


def steer(scan: LadarData, speed: int, distance: int) -> tuple[int, float]:
    """Speed [mm/s] and turn [rad/s, clockwise] that keep the wall at the left at this distance [mm]."""
    def nearest(begin: float, end: float) -> float:
        seen = [p.distance for p in scan.points if begin <= math.degrees(p.angle) <= end and p.distance > 0]
        return min(seen, default=scan.maxRange)

    ahead, left = nearest(-20, 20), nearest(-100, -60)  # angles are clockwise: left is negative
    if ahead < 2 * distance:
        return 0, 0.5  # a corner: turn away from the wall
    return speed, max(-0.5, min(0.5, (distance - left) / 1000))


class WallFollower(rack.DataModule[PilotData]):
    """Drives along the wall at the left of the robot."""

    DATA, CLASS_ID = PilotData, PilotProxy.CLASS_ID
    PARAMETERS = [rack.partner("ladar", LadarProxy, "the ladar"), rack.partner("chassis", ChassisProxy, "the chassis"),
                  rack.integer("speed", 200, "speed [mm/s]", 0, 2000, takes_effect=rack.NOW),
                  rack.integer("distance", 600, "distance to the wall [mm]", 100, 5000, takes_effect=rack.NOW)]

    def module_init(self) -> None:
        self.work = self.open_mailbox(4, 65536)
        self.scans = self.open_mailbox(2, 65536)

    def module_on(self) -> None:
        ladar, chassis = self.proxy("ladar", LadarProxy, self.work), self.proxy("chassis", ChassisProxy, self.work)
        assert ladar is not None and chassis is not None  # neither is optional
        self.ladar, self.chassis = ladar, chassis
        self.ladar.on()
        self.chassis.on()
        self.chassis.set_active_pilot(self.address)
        self.scans.clean()
        self.period = self.ladar.subscribe(self.scans)

    def module_loop(self) -> None:
        with self.scans.peek(timeout=max(5 * self.period / 1000, 2)) as message:
            scan = self.ladar.decode_stream(message)
        if scan is None:
            return
        speed, omega = steer(scan, self.integer("speed"), self.integer("distance"))
        self.chassis.move(vx=speed, omega=omega)
        self.put(PilotData(recordingTime=scan.recordingTime, speed=speed))

    def module_off(self) -> None:
        if hasattr(self, "chassis"):
            self.chassis.move()
            self.ladar.unsubscribe(self.scans)


if __name__ == "__main__":
    sys.exit(WallFollower().run())
