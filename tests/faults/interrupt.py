"""interrupt.py: end planish by signals at random moments, from its start to its end, and look at
what is left behind.

The input has its bytes; each output is complete, or as it was before; after signals that can be
caught there is no temporary file. SIGINT, SIGTERM and SIGHUP: from the beginning of the sweeps on
the mesh is written (status 0 or 1), before there is nothing. A second one may end it at once, and so
may others that end programs (SIGQUIT, SIGUSR1, SIGXCPU).
SIGKILL leaves at most a temporary file of each output, OUT.planish-PID-N. PLANISH_LONG: a thousand
times; PLANISH_SEED: other moments."""
import collections
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

PROGRAM = os.environ["PLANISH_PROGRAM"]
os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # threads that wait leave the core to others
LONG = bool(os.environ.get("PLANISH_LONG"))
OLD = b"what was there before\n"
TIME_LIMIT = 600  # seconds that mean that a run hangs
ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
OTHERS = (signal.SIGQUIT, signal.SIGUSR1, signal.SIGXCPU)

Scenario = collections.namedtuple("Scenario", "name arguments inputs outputs")
SCENARIOS = [
    Scenario("all outputs", "smooth in.mesh -o out.mesh --json r.json --report r.html -q",
             ["in.mesh"], ["out.mesh", "r.json", "r.html"]),
    Scenario("converted", "smooth in.mesh -o out.vtu --json r.json -q -j 1", ["in.mesh"],
             ["out.vtu", "r.json"]),
    Scenario("TetGen", "smooth in.node -o out.node -q", ["in.node", "in.ele"],
             ["out.node", "out.ele"]),
    Scenario("quality", "quality in.mesh --json r.json --report r.html -q", ["in.mesh"],
             ["r.json", "r.html"]),
]


def is_complete(name, data, inputs):
    """Whether it is all of the output: to its end, with what is no coordinate as in the input."""
    if name.endswith(".json"):
        try:
            return "checksum" in json.loads(data)
        except ValueError:
            return False
    if name.endswith(".html"):
        return data.rstrip().endswith(b"</html>")
    if name.endswith(".vtu"):
        return data.rstrip().endswith(b"</VTKFile>")
    if name.endswith(".ele"):
        return data == inputs["in.ele"]
    source = inputs["in" + name[name.rindex("."):]]
    tail = source.find(b"Tetrahedra")
    whole = tail < 0 or data.endswith(source[tail:])
    return whole and data.count(b"\n") == source.count(b"\n") and data[-1:] == b"\n"


class Runs:
    """The runs of one scenario."""

    def __init__(self, scenario):
        self.scenario, self.problems, self.statuses = scenario, 0, collections.Counter()
        self.inputs = {name: open(name, "rb").read() for name in scenario.inputs}
        self.seconds = min(self.time_of_run() for _ in range(2))

    def prepare(self, is_old):
        shutil.rmtree("run", ignore_errors=True)
        os.mkdir("run")
        for name, data in self.inputs.items():
            with open(os.path.join("run", name), "wb") as file:
                file.write(data)
        for name in self.scenario.outputs if is_old else []:
            with open(os.path.join("run", name), "wb") as file:
                file.write(OLD)

    def start(self):
        return subprocess.Popen([PROGRAM] + self.scenario.arguments.split(), cwd="run",
                                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE)

    def time_of_run(self):
        self.prepare(False)
        begin = time.monotonic()
        run = self.start()
        run.communicate(timeout=TIME_LIMIT)
        assert run.returncode == 0
        return time.monotonic() - begin

    def wait_for_moment(self, run):
        """Any after the start, or one at which a temporary file is there: two signals follow then."""
        end = time.monotonic() + self.seconds * random.uniform(0, 1.05)
        if random.random() < 0.6:
            time.sleep(end - time.monotonic())
            return False
        while run.poll() is None:
            if any(".planish-" in name for name in os.listdir("run")):
                return True
        return False

    def try_signals(self, numbers):
        is_old = random.random() < 0.5
        self.prepare(is_old)
        run = self.start()
        is_writing = self.wait_for_moment(run)
        if is_writing and signal.SIGKILL not in numbers:
            numbers = 2 * numbers[:1]
        for i, number in enumerate(numbers):
            if i > 0:  # two at the same time would be one
                time.sleep(0.001 if is_writing else self.seconds * random.uniform(0, 0.3))
            if run.poll() is None:
                run.send_signal(number)
        error = run.communicate(timeout=TIME_LIMIT)[1].decode()
        self.statuses[run.returncode] += 1
        problem = self.look(run.returncode, numbers, is_old, error)
        if problem:
            self.problems += 1
            print(f"FAILED: {self.scenario.name}: {[n.name for n in numbers]}: {problem}; status "
                  f"{run.returncode} {error[:200]!r} {sorted(os.listdir('run'))}")

    def look(self, status, numbers, is_old, error):
        found = {name: open(os.path.join("run", name), "rb").read() for name in os.listdir("run")}
        outputs = self.scenario.outputs
        if any(found.get(name) != data for name, data in self.inputs.items()):
            return "an input was touched"
        extra = set(found) - set(self.inputs) - set(outputs)
        if signal.SIGKILL in numbers:
            places = "|".join(map(re.escape, outputs))
            extra = {n for n in extra if not re.fullmatch(rf"({places})\.planish-\d+-\d+", n)}
        if extra:
            return f"left behind: {extra}"
        complete = {n for n in outputs if n in found and found[n] != OLD
                    and is_complete(n, found[n], self.inputs)}
        before = {n for n in outputs if found.get(n) == (OLD if is_old else None)}
        if complete | before != set(outputs):
            return f"neither complete nor as before: {set(outputs) - complete - before}"
        if status in (0, 1):
            return "" if complete == set(outputs) else f"not complete: {before}"
        if status not in [-n for n in numbers]:
            return "exit status"
        if error and "interrupted by a signal" not in error:
            return "a message of something else than the signal"
        if "nothing was written" in error and complete:
            return f"something was written: {complete}"
        if len(numbers) == 1 and complete and numbers[0] in ENDS and \
                self.scenario.arguments.startswith("smooth"):
            return "the first signal ended it after something had been written"
        return ""


def signals():
    first = random.choice([*ENDS, *OTHERS, signal.SIGKILL])
    return [first] if first not in ENDS or random.random() < 0.6 else \
        [first, random.choice([*ENDS, signal.SIGKILL])]


def main():
    random.seed(int(os.environ.get("PLANISH_SEED", "1")))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for number in ENDS + OTHERS:
        signal.signal(number, signal.SIG_DFL)  # those ignored here would be there, too
    total = 1000 if LONG else 40
    problems = 0
    for scenario in SCENARIOS:
        runs = Runs(scenario)
        for _ in range(total // len(SCENARIOS)):
            runs.try_signals(signals())
        problems += runs.problems
        ends = ", ".join(f"{n} times {status}" for status, n in sorted(runs.statuses.items()))
        print(f"figure: {scenario.name}, {runs.seconds:.2f} s: status {ends}", flush=True)
    print(f"figure: {total} runs ended by signals, {problems} problems")
    return 1 if problems else 0


sys.exit(main())
