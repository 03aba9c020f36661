"""program: run the program of a build folder, several times for its seconds."""
import json
import subprocess


def smooth(build, mesh, out, *options):
    """The report of one run on one thread."""
    done = subprocess.run([f"{build}/planish", "smooth", mesh, "-o", out, "-j", "1", "-q",
                           "--json", "-", *options], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def sweep_seconds(report, sweeps=None):
    return sum(sweep["seconds"] for sweep in report["sweeps"][:sweeps])


def best_of(repeats, run, seconds):
    """The run with the fewest seconds: other load only adds to them."""
    return min((run() for _ in range(repeats)), key=seconds)
