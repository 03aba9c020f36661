"""lying_counts.py PROGRAM EVERY [MEBIBYTES]: PROGRAM reads the tiny meshes with one number of each
replaced by one that is huge, negative or beside the point.

In text every whole number is replaced, in binary every word of 4 and of 8 bytes at every even
place, in the file's byte order. Files are also cut short, at every sixteenth of their length. Every EVERY-th of these files is tried, each in a process of its
own in at most so many MiB of address space (400; 0: no limit). It has to end soon with status 0 or 1
and the output, or with status 2, one line that names the file, and nothing left behind; the line
must not speak of memory, since nothing of so small a file may ask for much.
"""
import os
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile

from tiny_meshes import folders, meshes, xdmf_beside

program, every = sys.argv[1], int(sys.argv[2])
limit = (int(sys.argv[3]) if len(sys.argv) > 3 else 400) << 20
SECONDS = 60  # far more than any needs, also with sanitizers

TEXT = ["0", "-1", "3", "2147483647", "2147483648", "-2147483648", "4294967295", "4294967296",
        "4294967297", "6148914691236517206", "9223372036854775807", "9223372036854775808",
        "18446744073709551616", "1e18", "999999999999999999", "9" * 5000, "x", ""]
WORDS = {4: [0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**30, 715827883, 357913942],
         8: [2**31, 2**32, 2**32 + 1, 2**63 - 1, 2**63, 2**64 - 1, 10**18, 2**61, 768614336404564651]}
NUMBER = re.compile(rb"(?<![\w.+-])-?\d+(?![\w.])")
BIG_ENDIAN = {"version3.meshb", "binary.vtk", "offsets.vtk", "binary.off", "big.ply",
              "classic.exo", "offsets.exo", "wide.exo"}


def lies(name, data):
    """The files that name becomes."""
    for i in range(16):
        yield data[:len(data) * i // 16]
    for found in NUMBER.finditer(data):
        for text in TEXT:
            yield data[:found.start()] + text.encode() + data[found.end():]
    if all(byte < 128 and (byte >= 32 or byte in b"\n\r\t") for byte in data):
        return
    order = ">" if name in BIG_ENDIAN else "<"
    for size, code in ((4, "I"), (8, "Q")):
        for at in range(0, len(data) - size + 1, 2):
            for value in WORDS[size]:
                yield data[:at] + struct.pack(order + code, value) + data[at + size:]


def be_small():
    if limit:
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def fault(name, expected):
    """What is wrong with how the program takes the file called name, or None; and its status."""
    output = "out" + os.path.splitext(name)[1]
    command = [program, "smooth", name, "-o", output, "-q", "-j", "1", "--max-sweeps", "1"]
    try:
        run = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=SECONDS,
                             preexec_fn=be_small, check=False)
    except subprocess.TimeoutExpired:
        return "takes more than %d s" % SECONDS, None
    left = [file for file in os.listdir() if file not in expected]
    for file in left:
        shutil.rmtree(file) if os.path.isdir(file) else os.remove(file)
    lines = run.stderr.splitlines()
    if run.returncode not in (0, 1, 2):
        return "status %d: %r" % (run.returncode, run.stderr[-300:]), None
    if run.returncode == 2 and left:
        return "leaves %s" % left, None
    if run.returncode < 2 and output not in left:
        return "status %d, and no output" % run.returncode, None
    if run.returncode and (len(lines) != 1 or not lines[0].startswith(b"planish: ")):
        return "not one line: %r" % run.stderr[-500:], None
    if b"memory" in run.stderr:
        return "asks for memory: %r" % run.stderr, None
    return None, run.returncode


def write(path, data):
    with open(path, "wb") as out:
        out.write(data)


def cases():
    """(what the program opens, what lies there then, the files of it: {path: bytes})"""
    files = meshes()
    tetgen = {name: data for name, data in files.items() if name.startswith("tetgen.")}
    for name, data in files.items():
        if name not in tetgen:
            yield name, {name}, {name: data}
    yield "tetgen.node", set(tetgen), tetgen
    yield "beside.xdmf", set(xdmf_beside()), xdmf_beside()
    for name, inside in folders().items():
        yield name, {name}, {os.path.join(name, file): data for file, data in inside.items()}


def main():
    counter, tried, faults, statuses = 0, 0, 0, [0, 0, 0]
    kept = tempfile.mkdtemp(prefix="lying_counts.")
    for opened, expected, files in cases():
        for path, data in files.items():
            os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
            write(path, data)
        problem, status = fault(opened, expected)
        if problem or status:
            sys.exit("%s itself is no mesh: %s" % (opened, problem))
        for path, data in files.items():
            for changed in lies(path, data):
                counter += 1
                if counter % every:
                    continue
                write(path, changed)
                tried += 1
                problem, status = fault(opened, expected)
                if problem:
                    faults += 1
                    copy = os.path.join(kept, "%d-%s" % (counter, path.replace("/", "-")))
                    shutil.copy(path, copy)
                    print("%s: %s" % (copy, problem))
                else:
                    statuses[status] += 1
            write(path, data)
        for file in expected:
            shutil.rmtree(file) if os.path.isdir(file) else os.remove(file)
    if not faults:
        os.rmdir(kept)
    print("figure: lying numbers: %d of %d files, %d read, %d not usable as meshes, %d refused, %d faults" %
          (tried, counter, statuses[0], statuses[1], statuses[2], faults))
    return faults > 0


sys.exit(main())
