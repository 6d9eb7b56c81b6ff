"""check_channels.py PROGRAM: holds a running mission to docs/channels.md, from outside.

Subscribers are the stock `lcm` package with default socket buffers. tools/check_channels starts this
in a network of its own. Fails when a message of the default mission is lost, too long or cannot be
decoded, and when a mission acts on garbage, or doesn't act on a task or a stop.
"""
import collections
import subprocess
import sys

import bot_core
import lcm
import second_look

TYPES = {
    "MISSION": second_look.mission_t,
    "STATUS": second_look.status_t,
    "IMAGE": bot_core.images_t,
    "VIEW": second_look.view_t,
    "PLANE": second_look.support_plane_t,
    "OBJECTS": second_look.objects_t,
    "OCCUPANCY": second_look.occupancy_t,
    "CANDIDATES": second_look.candidates_t,
    "LOOK": second_look.look_t,
    "NAV_GOAL": second_look.nav_goal_t,
    "NAV_STATUS": second_look.nav_status_t,
    "TIMING": second_look.timing_t,
}
MAX_BYTES = 100_000

bus = lcm.LCM("udpm://239.255.76.67:7667?ttl=0")
failures = []


def expect(condition, failure):
    if not condition:
        failures.append(failure)


class Mission:
    """The default mission, with all that it tells. `on_status` is called for each STATUS."""

    def __init__(self, on_status=lambda status: None):
        self.lengths = collections.defaultdict(list)
        self.newest = {}
        self.status_times = []
        self.on_status = on_status
        subscription = bus.subscribe("SECONDLOOK_.*", self._on_message)
        program = subprocess.Popen([sys.argv[1], "run", "--config", "config/sim.yaml"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while program.poll() is None:
            bus.handle_timeout(100)
        while bus.handle_timeout(500):
            pass
        bus.unsubscribe(subscription)
        self.exit_status = program.returncode
        self.received = sum(len(lengths) for lengths in self.lengths.values())

    def _on_message(self, channel, data):
        name = channel.removeprefix("SECONDLOOK_")
        if name not in TYPES:  # our own
            return
        self.newest[name] = TYPES[name].decode(data)
        self.lengths[name].append(len(data))
        if name == "STATUS":
            self.status_times.append(self.newest[name].utime / 1e6)
            self.on_status(self.newest[name])


def check_that_everything_arrives():
    listener = subprocess.Popen([sys.executable, "tools/listen.py"], stdout=subprocess.PIPE)
    mission = Mission()
    listener.terminate()
    printed = listener.communicate()[0].decode()
    print(f"{'channel':12} {'messages':>8} {'bytes':>9} {'longest':>8}")
    for name in TYPES:
        lengths = mission.lengths[name] or [0]
        print(f"{name:12} {len(mission.lengths[name]):8} {sum(lengths):9} {max(lengths):8}")
        expect(mission.lengths[name], f"nothing on {name}")
        expect(max(lengths) <= MAX_BYTES, f"{name} has {max(lengths)} bytes")
    status = mission.newest["STATUS"]
    times = mission.status_times
    print(f"{mission.received} of {status.sent} messages were received, {status.send_drops} had no "
          f"room; STATUS at {(len(times) - 1) / (times[-1] - times[0]):.2f} Hz")
    expect(mission.received == status.sent and status.send_drops == 0, "messages were lost")
    expect(mission.exit_status == 0, f"the mission ended with {mission.exit_status}")
    expect("ended: everything is settled" in printed and "verified" in printed,
           "listen.py did not see the mission's end")


def make_task(name, looks):
    task = second_look.task_t()
    task.wanted, task.num_wanted = [second_look.wanted_t()], 1
    task.wanted[0].name, task.wanted[0].confidence = name, 0.99
    task.confidence, task.budget_looks = 0.9, looks
    return task.encode()


def check_that_garbage_changes_nothing_and_a_stop_does():
    stop = second_look.command_t()
    stop.command, stop.reason = second_look.command_t.STOP, "check_channels"
    garbage = []
    for channel, good, other in (("COMMAND", stop.encode(), make_task("mug", 1)),
                                 ("TASK", make_task("mug", 1), stop.encode())):
        for data in (b"", b"\xff" * 1000, good[:-1], good + b"\0", good + bytes(200_000), other):
            garbage.append((channel, data))
    garbage.append(("TASK", make_task("teacup", 1)))  # no such class: rejected by the mission
    seen = []

    def on_status(status):
        if not seen:
            for channel, data in garbage:
                bus.publish("SECONDLOOK_" + channel, data)
        if status.rejected >= len(garbage) and status.phase != "ended":
            bus.publish("SECONDLOOK_COMMAND", stop.encode())
        seen.append(status)

    mission = Mission(on_status)
    status = mission.newest["STATUS"]
    print(f"{status.rejected} rejected of {len(garbage)}, the last: {status.last_rejected}")
    expect(status.rejected == len(garbage), "garbage was not rejected")
    expect("'teacup', which is not in the object database" in status.last_rejected,
           "STATUS does not say why the task was rejected")
    expect(status.detail == "stopped on request", f"the mission ended: {status.detail}")
    expect(mission.newest["MISSION"].progress == 4, "MISSION does not say that it was stopped")
    expect(mission.exit_status == 4, f"a stopped mission ended with {mission.exit_status}")


def check_that_a_task_is_taken():
    sent = []

    def on_status(status):
        if not sent:
            sent.append(bus.publish("SECONDLOOK_TASK", make_task("mug", 0)))

    mission = Mission(on_status)
    print(f"with a budget of no looks: {mission.newest['STATUS'].detail}")
    expect(mission.newest["STATUS"].detail == "the budget of 0 looks is spent",
           "the task that came in was not taken")


check_that_everything_arrives()
check_that_garbage_changes_nothing_and_a_stop_does()
check_that_a_task_is_taken()
sys.exit("; ".join(failures) or 0)
