"""targets: measure all, and write FOLDER/targets.json.   targets.py PLANISH FOLDER"""
import json
import sys
import tempfile

import layers
import machine
import metrics
import parts
import period
import sizes
import speed
from program import Program


def main():
    planish, folder = sys.argv[1:]
    found = {"machine": machine.description()}
    with tempfile.TemporaryDirectory(dir=folder) as files:
        program = Program(planish, files)
        found["parts"] = parts.measure(program)
        found["layers"] = layers.measure(program)
    found["period"] = period.measure()
    found["sizes"] = sizes.measure()
    found["metrics"] = metrics.measure()
    found["speed"] = speed.measure()
    with open(f"{folder}/targets.json", "w", encoding="ascii") as file:
        json.dump(found, file, indent=1)


if __name__ == "__main__":
    main()
