#!/usr/bin/env python3
"""measure: read and write files and folders.   measure.py PROGRAMS RESULT.json PATH ..."""
import json
import os
import subprocess
import sys
import tempfile

import machine

REPEATS = 5


def files_of(path):
    """The files of a folder, or the file itself."""
    return [entry.path for entry in os.scandir(path)] if os.path.isdir(path) else [path]


def size_of(path):
    """Bytes of a file, TetGen's two together, or of all files of a folder."""
    if os.path.isdir(path):
        return sum(map(os.path.getsize, files_of(path)))
    beside = os.path.splitext(path)[0] + ".ele"
    both = path.endswith(".node") and os.path.exists(beside)
    return os.path.getsize(path) + (os.path.getsize(beside) if both else 0)


def smooth(programs, path, threads, extension):
    """The seconds that the program reports of one sweep, written with an extension."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(path)) as folder:
        out = os.path.join(folder, "out" + extension)
        done = subprocess.run([f"{programs}/planish", "smooth", path, "-o", out, "-j", str(threads),
                               "-q", "--max-sweeps", "1", "--json", "-"],
                              stdout=subprocess.PIPE, check=True)
        size = size_of(out)
    return {**json.loads(done.stdout)["seconds"], "bytes": size}


def warm(path):
    """Read all files once, so that they are in the disk cache."""
    for name in files_of(path):
        with open(name, "rb") as file:
            while file.read(1 << 24):
                pass


def measure(programs, path, threads, extension=None):
    """The best read and write of several runs."""
    own = os.path.splitext(path)[1]
    runs = [smooth(programs, path, threads, extension or own) for _ in range(REPEATS)]
    name = os.path.basename(path)
    return {"file": f"{name} to {extension}" if extension else name, "threads": threads,
            "bytes": size_of(path), "written_bytes": runs[0]["bytes"],
            "read": min(run["read"] for run in runs), "write": min(run["write"] for run in runs)}


def main():
    programs, result, *files = sys.argv[1:]
    about = machine.description()
    threads = sorted({1, about["cpus"]})
    rows = []
    for path in sorted(files):
        if path.endswith((".ele", ".part")) or os.path.basename(path).startswith("part-"):
            continue
        warm(path)
        rows += [measure(programs, path, n) for n in threads]
    binary = next(path for path in files if path.endswith("msh41_binary.msh"))
    rows += [measure(programs, binary, 1, extension) for extension in (".vtu", ".vtk")]
    with open(result, "w") as file:
        json.dump({"machine": about, "formats": rows}, file, indent=1)
    print(machine.line(about))
    print("\n| file | MB | threads | read s | MB/s | write s | MB/s |\n"
          "| --- | --: | --: | --: | --: | --: | --: |")
    for row in rows:
        print(f"| {row['file']} | {row['bytes'] / 1e6:.0f} | {row['threads']} "
              f"| {row['read']:.3f} | {row['bytes'] / 1e6 / row['read']:.0f} "
              f"| {row['write']:.3f} | {row['written_bytes'] / 1e6 / row['write']:.0f} |")


if __name__ == "__main__":
    main()
