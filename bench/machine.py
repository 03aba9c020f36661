"""machine: what the figures of a benchmark were measured on."""
import datetime
import os
import platform


def cpu():
    try:
        with open("/proc/cpuinfo") as info:
            return next(line.split(":", 1)[1].strip() for line in info if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def description():
    return {"cpu": cpu(), "cpus": len(os.sched_getaffinity(0)), "system": platform.platform(),
            "date": datetime.date.today().isoformat()}


def line(machine):
    return f"{machine['cpu']}, {machine['cpus']} CPUs, {machine['date']}"
