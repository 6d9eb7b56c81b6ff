"""Prints what a running mission believes, whenever that changes. See docs/channels.md."""
import sys

import lcm
from second_look import objects_t, status_t


def on_objects(channel, data):
    for o in objects_t.decode(data).objects:
        x, y, z = o.p_WO
        print(f"{o.id:3} {o.state:10} {o.class_name:16} ({x:.3f}, {y:.3f}, {z:.3f})", flush=True)


def on_status(channel, data):
    status = status_t.decode(data)
    print(f"step {status.step}: {status.phase}: {status.detail}", flush=True)


bus = lcm.LCM(sys.argv[1] if len(sys.argv) > 1 else "udpm://239.255.76.67:7667?ttl=0")
bus.subscribe("SECONDLOOK_OBJECTS", on_objects)
bus.subscribe("SECONDLOOK_STATUS", on_status)
while True:
    bus.handle()
