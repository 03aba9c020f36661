"""Say in commands of a shell what a recipe does, or check files that are data alone.

    recipes.py check FOLDER CITATION    syntax of recipes, and keys that CITATION.cff must have
    recipes.py conda META               its script and its tests
    recipes.py spack PACKAGE            the arguments of CMake
"""
import json
import re
import sys
import types

import yaml


def read_meta(path):
    """meta.yaml without its templates, as Linux has it."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    version = re.search(r'{% set version = "(.*)" %}', text)[1]
    text = re.sub(r"{%.*%}", "", text).replace("{{ version }}", version)
    text = re.sub(r'{{ (\w+)\("([\w-]+)".*?\) }}', r"\1_\2", text)
    return yaml.safe_load(text)


class Recorder:
    """Stands for spack.package: directives are heard, and variants have their defaults."""

    def __init__(self):
        self.variants, self.heard = {}, []

    def directive(self, name):
        def hear(*arguments, **options):
            self.heard.append((name, arguments, options))
            if name == "variant":
                self.variants[arguments[0]] = options["default"]
        return hear


def load_spack(path):
    """The recipe's class, made without Spack."""
    recorder = Recorder()

    class CMakePackage:
        def define(self, name, value):
            return f"-D{name}={'ON' if value else 'OFF'}"

        def define_from_variant(self, name, variant):
            return self.define(name, recorder.variants[variant])

    names = {"spack": {}, "spack.package": {n: recorder.directive(n) for n in ("license", "version", "variant", "depends_on")},
             "spack_repo": {}, "spack_repo.builtin": {}, "spack_repo.builtin.build_systems": {},
             "spack_repo.builtin.build_systems.cmake": {"CMakePackage": CMakePackage}}
    for name, members in names.items():
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__dict__.update(members)
    space = {}
    with open(path, encoding="utf-8") as file:
        exec(compile(file.read(), path, "exec"), space)  # pylint: disable=exec-used
    assert {name for name, *_ in recorder.heard} == {"license", "version", "variant", "depends_on"}
    return space["Planish"]()


def check(folder, citation):
    meta = read_meta(f"{folder}/conda/meta.yaml")
    assert set(meta) == {"package", "source", "build", "requirements", "test", "about", "extra"}, set(meta)
    assert len(meta["source"]["sha256"]) == 64
    with open(f"{folder}/vcpkg/vcpkg.json", encoding="utf-8") as file:
        port = json.load(file)
    assert port["name"] == "planish" and port["version-semver"] == meta["package"]["version"]
    with open(citation, encoding="utf-8") as file:
        citation = yaml.safe_load(file)
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert str(citation["version"]) == meta["package"]["version"]


if __name__ == "__main__":
    if sys.argv[1] == "check":
        check(*sys.argv[2:])
    elif sys.argv[1] == "conda":
        recipe = read_meta(sys.argv[2])
        print("\n".join(recipe["build"]["script"] + recipe["test"]["commands"]))
    else:
        print("\n".join(load_spack(sys.argv[2]).cmake_args()))
