"""tutorial.py FILE.md [N]: run the commands of a document (the first N) in this folder, and compare what they print.

A command is a line "    $ COMMAND", run by bash; the indented lines behind it are its output, "..." any lines between
others. Standard error comes after standard output. Seconds count for nothing. A command fails if its exit status is not
0; what needs a library that planish was built without is passed over.
"""
import re
import subprocess
import sys


def commands(path):
    """[(command, its lines)]"""
    found, block = [], False
    for line in open(path, encoding="utf-8"):
        line = line.rstrip("\n")
        if line.startswith("    $ "):
            found.append((line[6:], []))
            block = True
        elif line.startswith("    ") and block:
            found[-1][1].append(line[4:])
        else:
            block = False
    return found


def without_seconds(lines):
    """The lines; the last column of the table of planish advise, and the times of a run, are left out."""
    in_table = False
    for line in lines:
        in_table = line.startswith(("what smoothing", "as it is", "smoothed", "  with ")) and (
            in_table or line.startswith("what"))
        if in_table and not line.startswith(("what", "as it is")):
            line = line.rsplit(None, 1)[0]
        yield re.sub(r"^[\d.]+ s: read .*", "SECONDS", line)


def missing(wanted, given):
    """The first line of wanted that given does not have in its place; None if all are there."""
    at, is_free = 0, False
    for line in wanted:
        if line == "...":
            is_free = True
            continue
        while is_free and at < len(given) and given[at] != line:
            at += 1
        if at == len(given) or given[at] != line:
            return line
        at, is_free = at + 1, False
    return None if is_free or at == len(given) else f"no line '{given[at]}'"


def main():
    known = commands(sys.argv[1])
    count = int(sys.argv[2]) if len(sys.argv) > 2 else len(known)
    failures = passed_over = 0
    for command, lines in known[:count]:
        run = subprocess.run(["bash", "-c", command], stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if run.returncode and re.search("was built without|packed by", run.stderr):
            passed_over += 1
            continue
        given = list(without_seconds((run.stdout + run.stderr).split("\n")[:-1]))
        line = missing(list(without_seconds(lines)), given)
        if run.returncode or line is not None:
            failures += 1
            print(f"$ {command}\nexit status {run.returncode}; not there: {line}\n" + "\n".join(given) + "\n")
    print(f"{count} commands, {passed_over} passed over, {failures} failed")
    sys.exit(failures > 0 or count < 3)


main()
