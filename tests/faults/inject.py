"""inject.py SHIM [WORD...]: run planish again and again, each time with one call of it to the system
made to fail by the preloaded SHIM (shim.c), and look at what is left behind.

Whatever fails, the exit status is one of docs/program.md; one line on standard error says what is
wrong and names a file; the input has its bytes; what is written is complete, or as it was before;
nothing else lies in the folder. A call that is interrupted or does only half is no reason to fail.
WORDs choose scenarios by their names. PLANISH_LONG: every call once; else some, PLANISH_SEED says
which."""
import collections
import errno
import json
import os
import random
import re
import shutil
import subprocess
import sys

PROGRAM = os.environ["PLANISH_PROGRAM"]
DATA = os.path.join(os.environ["PLANISH_SOURCE"], "tests", "data")
os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # threads that wait leave the core to others
LONG = bool(os.environ.get("PLANISH_LONG"))
SEED = int(os.environ.get("PLANISH_SEED", "1"))
OLD = b"what was there before\n"
TIME_LIMIT = 600  # seconds that mean that a run hangs
SOME = 25  # faults of a scenario in the short form

# What may go wrong with each call. Memory has one way; EINTR and "short" have to be survived.
MEMORY = ("malloc", "calloc", "realloc", "aligned_alloc", "posix_memalign")
ERRORS = {
    "mmap": ["ENOMEM", "ENODEV"], "madvise": ["EINVAL"], "munmap": ["EINVAL"],
    "open": ["EMFILE", "EACCES", "EINTR"], "fopen": ["EMFILE", "EACCES"],
    "close": ["EIO", "ENOSPC", "EINTR"], "fclose": ["EIO"],
    "read": ["EIO", "EINTR", "short"], "pread": ["EIO", "EINTR", "short"], "fread": ["EIO", "short"],
    "write": ["ENOSPC", "EIO", "EINTR", "short"], "pwrite": ["ENOSPC", "EINTR", "short"],
    "fwrite": ["ENOSPC", "EIO"], "fflush": ["ENOSPC"], "lseek": ["ESPIPE"],
    "ftruncate": ["EIO"], "fsync": ["EIO", "ENOSPC", "EINTR", "EINVAL"], "rename": ["EACCES", "EXDEV"],
    "unlink": ["EACCES"], "fstat": ["EIO"], "stat": ["EACCES"], "lstat": ["EACCES"],
    "access": ["EACCES"], "readlink": ["EIO"], "chmod": ["EPERM"], "fchmod": ["EPERM"],
    "fchown": ["EPERM"], "fcntl": ["EMFILE"], "flock": ["EINTR"], "pthread_create": ["EAGAIN"],
}
ERRORS.update({call: ["ENOMEM"] for call in MEMORY})
SURVIVED = {"EINTR", "short"}
# Where these have no memory, they use what they have freed, and crash, or the next one who wants
# memory does: planish cannot help that, and what is left of the files is looked at all the same.
FRAGILE = ("libhdf5", "libhwloc")
NO_FILE = ("planish: out of memory for the command line", "planish: a library ended the program")

Scenario = collections.namedtuple("Scenario", "name arguments inputs outputs is_old stdin")


def scenario(name, arguments, inputs, outputs=(), is_old=False, stdin=None):
    """inputs and outputs: names of files, in folders, too; is_old: outputs are there already."""
    return Scenario(name, arguments.split(), inputs, outputs, is_old, stdin)


def smoothing(file, more="", inputs=None, outputs=None):
    out = "out" + os.path.splitext(file)[1]
    return scenario("smooth " + file, f"smooth {file} -o {out} -q -j 1 --max-sweeps 3 {more}",
                    inputs or [file], outputs or [out])


def files_of(folder, of=DATA):
    return [os.path.relpath(os.path.join(place, name), of)
            for place, _, names in os.walk(os.path.join(of, folder)) for name in sorted(names)]


def smoothing_folder(folder):
    names = files_of(folder)
    return scenario("smooth " + folder, f"smooth {folder} -o out -q -j 1 --max-sweeps 3", names,
                    [name.replace(folder, "out", 1) for name in names])


SCENARIOS = [
    smoothing_folder("elmer"), smoothing_folder("openfoam"),
    scenario("elmer in place", "smooth elmer -o elmer -q -j 1 --max-sweeps 3", files_of("elmer"),
             ["elmer/mesh.nodes"], True),
    scenario("all outputs", "smooth medit.mesh -o out.mesh --json r.json --report r.html -q -j 1"
             " --max-sweeps 3 --slide auto", ["medit.mesh"], ["out.mesh", "r.json", "r.html"]),
    scenario("all outputs replaced", "smooth medit.mesh -o out.mesh --json r.json --report r.html"
             " -j 1 --max-sweeps 2 -v", ["medit.mesh"], ["out.mesh", "r.json", "r.html"], True),
    scenario("over the input", "smooth medit.mesh -o medit.mesh -q -j 2 --max-sweeps 2",
             ["medit.mesh"], ["medit.mesh"], True),
    scenario("two threads, bound", "smooth medit.mesh -o out.mesh -q -j 2 --max-sweeps 2",
             ["medit.mesh"], ["out.mesh"]),
    scenario("from standard input", "smooth /dev/stdin -o /dev/stdout -q -j 1 --max-sweeps 2", [],
             stdin="medit.mesh"),
    smoothing("square.msh", "--objective mean-ratio --min-volume-fraction 1e-6"),
    smoothing("ascii41.msh", "--objective worst --slide auto"),
    smoothing("binary22.msh"), smoothing("binary41.msh", "--only-worse-than 1.3"),
    smoothing("medit.meshb"), smoothing("ascii.vtk"), smoothing("binary.vtk"),
    smoothing("ascii.vtu"), smoothing("base64.vtu"), smoothing("zlib.vtu"), smoothing("raw.vtu"),
    smoothing("tetgen.node", inputs=["tetgen.node", "tetgen.ele"], outputs=["out.node", "out.ele"]),
    smoothing("netgen.vol"), smoothing("cube.mfem"), smoothing("abaqus.inp"), smoothing("nastran.bdf"),
    smoothing("square.off"), smoothing("square.stl"), smoothing("square.obj"), smoothing("square.ply"), smoothing("cube.vtkhdf"), smoothing("cube.med", "--slide auto"),
    smoothing("cube.h5"), smoothing("cube.cgns"), smoothing("cube.exo"),
    smoothing("cube.avs"), smoothing("cube.su2"), smoothing("cube.unv"), smoothing("cube.xdmf"),
    smoothing("named.xdmf", inputs=["named.xdmf", "named.bin"], outputs=["out.bin", "out.xdmf"]),
    scenario("xdmf in place", "smooth named.xdmf -o named.xdmf -q -j 1 --max-sweeps 3", ["named.xdmf", "named.bin"], ["named.bin"], True),
    smoothing("packed.vtkhdf"),
    scenario("convert to vtu", "smooth ascii41.msh -o out.vtu -q -j 1 --max-sweeps 1",
             ["ascii41.msh"], ["out.vtu"]),
    scenario("convert to vtk", "smooth medit.mesh -o out.vtk -q -j 1 --max-sweeps 1 --json r.json",
             ["medit.mesh"], ["out.vtk", "r.json"]),
    scenario("quality", "quality medit.mesh --json r.json --report r.html --worst 5",
             ["medit.mesh"], ["r.json", "r.html"]),
    scenario("quality of several", "quality medit.mesh square.off ascii.vtk --json -",
             ["medit.mesh", "square.off", "ascii.vtk"]),
    scenario("like another file", "smooth medit.mesh --like medit.meshb -o out.mesh -q -j 1 --json r.json",
             ["medit.mesh", "medit.meshb"], ["out.mesh", "r.json"]),
    scenario("report", "report result.json", ["result.json", "medit.mesh"], ["result.html"], True),
    scenario("help", "smooth --help", []),
]


def plain(name, data):
    """Content of an output without what differs from run to run."""
    if name.endswith(".html"):
        return re.sub(rb"[0-9.]+", b"#", data[-200:]), len(data) // 20000
    if not name.endswith(".json"):
        return data
    try:
        r = json.loads(data)
    except ValueError:
        return data
    for key in ("seconds", "peak_memory_bytes", "threads", "binding"):
        r.pop(key, None)
    for sweep in r.get("sweeps", []):
        sweep.pop("seconds")
    return r


def plain_stdout(text):
    """Tables have times in them."""
    r = plain("r.json", text)
    text = text if r == text else json.dumps(r).encode()
    return re.sub(rb"[0-9.]+ *(s|ms|MB)\b.*", b"#", text)


class Runs:
    """The runs of one scenario in a folder of its own."""

    def __init__(self, shim, scenario):
        self.shim, self.scenario, self.problems, self.n, self.n_crashes = shim, scenario, 0, 0, 0
        self.log = os.path.abspath("log")
        self.input = {name: open(os.path.join("originals", name), "rb").read()
                      for name in scenario.inputs}

    def prepare(self):
        shutil.rmtree("run", ignore_errors=True)
        os.mkdir("run")
        if self.scenario.is_old:
            for name in self.scenario.outputs:
                os.makedirs(os.path.dirname(os.path.join("run", name)), exist_ok=True)
                with open(os.path.join("run", name), "wb") as file:
                    file.write(OLD)
        for name, data in self.input.items():
            os.makedirs(os.path.dirname(os.path.join("run", name)), exist_ok=True)
            with open(os.path.join("run", name), "wb") as file:
                file.write(data)

    def run(self, fault=None):
        self.prepare()
        if os.path.exists(self.log):
            os.remove(self.log)
        environment = dict(os.environ, LD_PRELOAD=self.shim, FAULT_LOG=self.log)
        if fault:
            environment["FAULT"] = fault
        stdin = self.scenario.stdin and open(os.path.join("originals", self.scenario.stdin), "rb")
        try:
            return subprocess.run([PROGRAM] + self.scenario.arguments, cwd="run", env=environment,
                                  stdin=stdin or subprocess.DEVNULL, capture_output=True,
                                  timeout=TIME_LIMIT)
        finally:
            if stdin:
                stdin.close()

    def logged(self):
        try:
            return [line.split() for line in open(self.log)]
        except FileNotFoundError:
            return []

    def found(self):
        found = {name: open(os.path.join("run", name), "rb").read() for name in files_of(".", "run")}
        found.update({place + "/": b"" for place, folders, names in os.walk("run") if not folders + names})
        found.pop("run/", None)
        return {os.path.normpath(name): data for name, data in found.items()}

    def reference(self):
        done = self.run()
        found = self.found()
        assert done.returncode == 0, done.stderr
        self.expected = {name: plain(name, found[name]) for name in self.scenario.outputs}
        self.stdout = plain_stdout(done.stdout)
        return {call: int(n) for call, n, _ in self.logged()}

    def is_complete(self, found, name):
        if name not in found:
            return False
        data, expected = plain(name, found[name]), self.expected[name]
        if self.lacks_sweeps and name.endswith(".json"):
            data, expected = dict(data, sweeps=[]), dict(expected, sweeps=[])
        return data == expected

    def is_as_before(self, found, name):
        before = self.input.get(name, OLD if self.scenario.is_old else None)
        return found.get(name) == before

    def look(self, done, what):
        """What is wrong with a run that had a fault; an empty text if nothing is."""
        s, found, lines = self.scenario, self.found(), done.stderr.decode().splitlines()
        self.lacks_sweeps = "out of memory for the history of the sweeps" in done.stderr.decode()
        complaints = [line for line in lines if line.startswith("planish: ")]
        extra = set(found) - set(s.inputs) - set(s.outputs)
        is_crash = done.returncode < 0 and self.is_fragile()
        if is_crash:  # as after SIGKILL
            extra = {name for name in extra if ".planish-" not in name}
        if extra:
            return f"left behind: {extra}"
        if any(found.get(name) != data for name, data in self.input.items() if name not in s.outputs):
            return "an input was touched"
        if is_crash:
            self.n_crashes += 1
            return self.look_at_outputs(found)
        if done.returncode not in ((0, 1, 2) if s.arguments[0] == "smooth" else (0, 2)):
            return "exit status"
        if done.returncode == 0 or what in SURVIVED:
            if not all(self.is_complete(found, name) for name in s.outputs):
                return "not complete"
            if plain_stdout(done.stdout) != self.stdout:
                return "standard output"
            return f"status {done.returncode}" if done.returncode else ""
        if len(complaints) != 1:
            return "one line on standard error"
        return self.look_at_failure(done, found, complaints[0])

    def look_at_failure(self, done, found, complaint):
        s = self.scenario
        names = [*s.inputs, *s.outputs, *(name.split("/")[0] for name in [*s.inputs, *s.outputs]), "standard output", "/dev/stdin", "/dev/stdout"]
        if not complaint.startswith(NO_FILE) and not any(name in complaint for name in names):
            return "no file is named"
        if self.look_at_outputs(found):
            return self.look_at_outputs(found)
        mesh = s.outputs[0] if s.outputs else None
        if done.returncode == 1 and mesh and not self.is_complete(found, mesh):
            return "status 1 without the mesh"
        if done.returncode == 2 and s.arguments[0] == "smooth":
            for name in s.outputs:
                if not self.is_as_before(found, name):
                    return f"status 2, and {name} was written"
        return ""

    def look_at_outputs(self, found):
        for name in self.scenario.outputs:
            if not self.is_complete(found, name) and not self.is_as_before(found, name):
                return f"{name} is neither complete nor as before"
        return ""

    def is_fragile(self):
        """Whether it was such a library that had no memory."""
        call, _, library = self.logged()[0]
        return call in MEMORY and any(name in library for name in FRAGILE)

    def try_fault(self, call, number, what):
        code = what if what == "short" else getattr(errno, what)
        fault = f"{call}:{number}:{code}"
        self.n += 1
        try:
            done = self.run(fault)
        except subprocess.TimeoutExpired:
            problem = "hangs"
            done = None
        else:
            problem = self.look(done, what)
            if not problem and [call, str(number)] not in [line[:2] for line in self.logged()]:
                problem = "" if self.is_uncertain(call) else "the fault was not met"
        if problem:
            self.problems += 1
            shown = done and (done.returncode, done.stderr.decode()[:300])
            print(f"FAILED: {self.scenario.name}: {call} {number} {what}: {problem} {shown}")

    def is_uncertain(self, call):
        """With several threads calls are not of the same number in every run; nor is there as much to be
        said of memory, wherever the system puts it, as pages begin at multiples of their size."""
        return "2" in self.scenario.arguments or call == "madvise"


def faults(counts):
    """All faults of a scenario with so many calls, or some of them."""
    every = [(call, number, what) for call, errors in ERRORS.items() for what in errors
             for number in range(counts.get(call, 0))]
    if LONG or len(every) <= SOME:
        return every
    # As many of each kind, as there are hundreds of calls for memory for one that writes.
    kinds = sorted({(call, what) for call, _, what in every})
    chosen = random.choices(kinds, k=SOME)
    return [(call, random.randrange(counts[call]), what) for call, what in chosen]


def run_scenario(shim, s):
    runs = Runs(shim, s)
    counts = runs.reference()
    if s.is_old and counts.get("fsync", 0) < len(s.outputs):
        runs.problems += 1
        print(f"FAILED: {s.name}: what is replaced is given up before the new one is on the disk")
    for fault in faults(counts):
        runs.try_fault(*fault)
    print(f"figure: {s.name}: {runs.n} faults, {runs.n_crashes} crashes of HDF5 and hwloc, "
          f"{runs.problems} problems", flush=True)
    return runs


def pack():
    """cube.vtkhdf with packed coordinates: HDF5 itself writes those. Whether there is h5py."""
    try:
        import h5py
    except ImportError:
        print("not tried: packed coordinates (python3-h5py)")
        return False
    shutil.copy("originals/cube.vtkhdf", "originals/packed.vtkhdf")
    with h5py.File("originals/packed.vtkhdf", "r+") as file:
        points = file["VTKHDF/Points"][:]
        del file["VTKHDF/Points"]
        file["VTKHDF"].create_dataset("Points", data=points, chunks=(32, 3), compression="gzip")
    return True


def name_points():
    """cube.xdmf with its points in a file of bytes."""
    import struct
    with open("originals/cube.xdmf", encoding="ascii") as file:
        head, text = file.read().split('Format="XML" Precision="8">', 1)
    numbers, tail = text.split("</DataItem>", 1)
    numbers = [float(word) for word in numbers.split()]
    with open("originals/named.bin", "wb") as file:
        file.write(struct.pack("=%dd" % len(numbers), *numbers))
    with open("originals/named.xdmf", "w", encoding="ascii") as file:
        file.write(head + 'Format="Binary" Precision="8">named.bin</DataItem>' + tail)


def main():
    shim, words = os.path.abspath(sys.argv[1]), sys.argv[2:]
    random.seed(SEED)
    shutil.rmtree("originals", ignore_errors=True)
    shutil.copytree(DATA, "originals")
    subprocess.run([PROGRAM, "smooth", "medit.mesh", "-o", "smoothed.mesh", "--json", "result.json",
                    "-q"], cwd="originals", check=True)
    asked = [s for s in SCENARIOS if not words or any(word in s.name for word in words)]
    name_points()
    if not pack():
        asked = [s for s in asked if "packed" not in s.name]
    done = [run_scenario(shim, s) for s in asked]
    n, problems = sum(r.n for r in done), sum(r.problems for r in done)
    crashes = sum(r.n_crashes for r in done)
    print(f"figure: {n} faults in {len(done)} scenarios, {crashes} crashes of HDF5 and hwloc, "
          f"{problems} problems")
    return 1 if problems or not done else 0


sys.exit(main())
