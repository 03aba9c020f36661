"""Expectations of report.json: folders and expressions come in turn, each ended by a zero byte; a line says whether
each holds for the report in its folder, as r."""
import json
import os
import sys


def verdict(folder, expression):
    try:
        with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
            return "holds" if eval(expression, {"json": json, "r": json.load(file)}) else "does not hold"
    except Exception as error:  # pylint: disable=broad-except
        return f"{type(error).__name__}: {error}".replace("\n", " ")


def words():
    rest = b""
    while part := os.read(0, 1 << 16):
        *whole, rest = (rest + part).split(b"\0")
        yield from whole


given = words()
for name, wanted in zip(given, given):
    print(verdict(os.fsdecode(name), wanted.decode()), flush=True)
