"""Do what a Dockerfile says without Docker: dockerfile.py DOCKERFILE CONTEXT BASE FOLDER MESH

As root of a mount namespace of its own. A stage is a copy of the system at BASE, in memory below FOLDER. Last the
image's command is run as it is, and once to smooth MESH. FOLDER/stage0 has the first stage.
"""
import json
import os
import re
import shutil
import subprocess
import sys


def read_steps(path):
    """Pairs of instruction and its text."""
    with open(path, encoding="utf-8") as file:
        lines = "".join(line for line in file if not line.startswith("#"))
    for line in re.sub(r"\\\n", " ", lines).splitlines():
        if line.strip():
            yield line.split(None, 1)


class Stage:
    """A copy of the system, changed by instructions."""

    def __init__(self, base, folder):
        self.root, self.directory, self.entry, self.command = f"{folder}/root", "/", [], []
        os.makedirs(self.root)
        mount = lambda *arguments: subprocess.run(["mount", *arguments], check=True)  # noqa: E731
        mount("-t", "tmpfs", "tmpfs", folder)
        for name in ("root", "changed", "work"):
            os.mkdir(f"{folder}/{name}")
        mount("-t", "overlay", "overlay", "-o", f"lowerdir={base},upperdir={folder}/changed,workdir={folder}/work", self.root)
        for name in ("proc", "dev"):
            mount("--rbind", f"/{name}", f"{self.root}/{name}")

    def run(self, command):
        script = f"cd {self.directory} && exec \"$@\""
        return subprocess.run(["chroot", self.root, "/bin/sh", "-c", script, "sh", *command], check=True,
                              stdout=subprocess.PIPE, encoding="utf-8").stdout

    def copy(self, source, target):
        """Files of a pattern into a folder, or the context to a path."""
        target = self.root + target
        if source.endswith("/."):
            os.makedirs(target)
            skipped = ["--exclude=./.git", "--exclude=./build*"]
            with subprocess.Popen(["tar", "-C", source, "-c", *skipped, "."], stdout=subprocess.PIPE) as tar:
                subprocess.run(["tar", "-x", "-C", target], stdin=tar.stdout, check=True)
            return
        os.makedirs(target, exist_ok=True)
        found = [n for n in os.listdir(os.path.dirname(source))
                 if re.fullmatch(os.path.basename(source).replace("*", ".*"), n)]
        assert found, f"nothing is {source}"
        for name in found:
            shutil.copy(os.path.join(os.path.dirname(source), name), target)


def main(dockerfile, context, base, folder, mesh):
    stages, names = [], {}
    for instruction, text in read_steps(dockerfile):
        if instruction == "FROM":
            stages.append(Stage(base, f"{folder}/stage{len(stages)}"))
            names[text.split()[-1]] = stages[-1]
        elif instruction == "RUN":
            stages[-1].run(["/bin/sh", "-c", text])
        elif instruction == "COPY":
            origin, *paths = text.split() if text.startswith("--from=") else [None, *text.split()]
            of = names[origin[len("--from="):]].root if origin else f"{context}/"
            stages[-1].copy(of + paths[0], paths[1])
        elif instruction == "WORKDIR":
            stages[-1].directory = text
            os.makedirs(stages[-1].root + text, exist_ok=True)
        elif instruction == "ENTRYPOINT":
            stages[-1].entry = json.loads(text)
        elif instruction == "CMD":
            stages[-1].command = json.loads(text)
        else:
            sys.exit(f"{instruction}: not known here")
    last = stages[-1]
    assert "smooth" in last.run(last.entry + last.command)
    shutil.copy(mesh, last.root + last.directory + "/in.msh")
    assert "worst radius ratio" in last.run([*last.entry, "smooth", "in.msh", "-o", "out.msh"])
    assert os.path.getsize(last.root + last.directory + "/out.msh") > 0


if __name__ == "__main__":
    main(*sys.argv[1:])
