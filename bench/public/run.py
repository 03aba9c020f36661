#!/usr/bin/python3
"""run: smooth every mesh below some folders in three ways, judge the results, print a table; see run."""
import argparse
import concurrent.futures
import functools
import gzip
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import machine
import show

WAYS = {"default": (), "slide": ("--slide", "auto"), "best": ("--best",)}
GRACE = 60  # seconds over the time limit, until the program is ended from outside
TIMED_OUT = 124


def extensions(planish):
    """Those that planish knows."""
    table = subprocess.run([planish, "--generate", "formats"], check=True, capture_output=True, text=True).stdout
    return {word for line in table.splitlines()[2:] for word in re.findall(r"\.\w+", line.split("|")[3])}


def files_below(folder, known):
    """Mesh files, each mesh once; files in gzip count by the name inside."""
    found = []
    for path in sorted(folder.rglob("*")):
        name = pathlib.Path(path.name.removesuffix(".gz"))
        if not path.is_file() or name.suffix.lower() not in known:
            continue
        if path.suffix == ".node" and path.with_suffix(".ele").exists():
            continue
        if path.suffix == ".h5" and any(path.with_suffix(x).exists() for x in (".xdmf", ".xmf")):
            continue
        found.append(path)
    return found


def run_program(command, seconds):
    """Exit status, and the first line of standard error that is an error."""
    try:
        done = subprocess.run(list(map(str, command)), check=False, timeout=seconds, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    except subprocess.TimeoutExpired:
        return TIMED_OUT, "timeout"
    lines = [line for line in done.stderr.decode("utf-8", "replace").splitlines() if line.startswith("planish: ")]
    return done.returncode, lines[-1].removeprefix("planish: ") if lines else ""


def reason_of(message, path):
    """A message without what belongs to the one file."""
    message = message.replace(str(path), "").replace(path.name, "").lstrip(": ")
    return re.sub(r"\d+", "N", re.sub(r"'[^']*'", "'...'", message))[:110]


def load(path):
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def smooth(planish, path, way, seconds, folder):
    """The row of one way."""
    import judge  # pylint: disable=import-outside-toplevel # numpy and meshio: in the workers alone
    import reading  # pylint: disable=import-outside-toplevel
    target, report = folder / ("out" + path.suffix), folder / "report.json"
    for old in (*reading.files_of(target), report):
        old.unlink(missing_ok=True)
    status, message = run_program([planish, "smooth", path, "-o", target, "-q", "-j", "1", "--time-limit", seconds,
                                   "--json", report, *WAYS[way]], seconds + GRACE)
    row = {"way": way, "status": status}
    if status == 2:
        return row | {"refused": reason_of(message, path)}
    if status not in (0, 1) or not target.exists() or not report.exists():
        return row | {"faults": [f"ends: status {status}: {message}"]}
    said = load(report)
    row["stop"] = said["stop"]
    try:
        return row | judge.judge(path, target, said, way, status)
    except reading.NotRead as error:
        return row | {"not_judged": f"no other reader: {error}"}
    except Exception as error:  # pylint: disable=broad-except # of one mesh: the others go on
        return row | {"faults": [f"judge: {type(error).__name__}: {error}"]}


def treat(planish, path, source, ways, seconds):
    """All that is found out about one file."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if path.suffix == ".gz":
            unpacked = folder / path.stem
            with gzip.open(path) as packed, open(unpacked, "wb") as out:
                shutil.copyfileobj(packed, out)
        else:
            unpacked = path
        line = {"path": str(path), "source": source, "rows": []}
        status, message = run_program([planish, "quality", unpacked, "-q", "--json", folder / "quality.json"],
                                      seconds + GRACE)
        quality = load(folder / "quality.json")
        if status == 2:
            return line | {"refused": reason_of(message, unpacked)}
        if status != 0 or quality is None:
            return line | {"faults": [f"ends: quality, status {status}: {message}"]}
        line["format"] = quality["format"]
        line["rows"] = [smooth(planish, unpacked, way, seconds, folder) for way in ways]
        return line


def key_of(path, program, ways, seconds):
    about = path.stat()
    return hashlib.sha256(repr((str(path), about.st_size, about.st_mtime_ns, program, ways, seconds)).encode()).hexdigest()[:16]


def faults_of(line):
    return line.get("faults", []) + [f"{row['way']}: {fault}" for row in line["rows"] for fault in row.get("faults", [])]


def work(chosen):
    """Lines of all files; those that results.jsonl has already are not made again."""
    program = hashlib.sha256(chosen.planish.read_bytes()).hexdigest()[:16]
    known = extensions(chosen.planish)
    done, tasks, lines = {}, {}, []
    results = chosen.results / "results.jsonl"
    if results.exists():
        done = {line["key"]: line for line in map(json.loads, results.read_text(encoding="utf-8").splitlines())}
    for folder in chosen.folders:
        for path in files_below(folder, known):
            if path.stat().st_size > chosen.largest * 1e6:
                continue
            key = key_of(path, program, chosen.ways, chosen.time_limit)
            source = "/".join(path.relative_to(folder).parent.parts) or folder.name
            if key in done:
                lines.append(done[key] | {"source": source})
            else:
                tasks[key] = path, source
    treat_one = functools.partial(treat, chosen.planish, ways=chosen.ways, seconds=chosen.time_limit)
    with concurrent.futures.ProcessPoolExecutor(chosen.jobs) as pool, open(results, "a", encoding="utf-8") as file:
        running = {pool.submit(treat_one, path, source): key for key, (path, source) in tasks.items()}
        for future in concurrent.futures.as_completed(running):
            line = future.result() | {"key": running[future]}
            lines.append(line)
            file.write(json.dumps(line) + "\n")
            file.flush()
            for fault in faults_of(line):
                print(f"{line['path']}: {fault}", file=sys.stderr)
    return sorted(lines, key=lambda line: line["path"])


def main():
    parser = argparse.ArgumentParser(prog="bench/public/run")
    parser.add_argument("planish", type=pathlib.Path)
    parser.add_argument("results", type=pathlib.Path)
    parser.add_argument("folders", type=pathlib.Path, nargs="+", metavar="FOLDER")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--time-limit", type=int, default=60, metavar="SECONDS")
    parser.add_argument("--largest", type=float, default=1e9, metavar="MB")
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count())
    chosen = parser.parse_args()
    chosen.planish = chosen.planish.resolve()
    chosen.results.mkdir(parents=True, exist_ok=True)
    lines = work(chosen)
    about = machine.description()
    (chosen.results / "public.json").write_text(json.dumps({"machine": about, "files": lines}, indent=1), encoding="utf-8")
    print(machine.line(about) + "\n")
    show.show(lines)
    return int(any(map(faults_of, lines)))


if __name__ == "__main__":
    sys.exit(main())
