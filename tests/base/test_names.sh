#!/usr/bin/env bash
# Functions and types that a comment or a document names are there.
cd "$(dirname "$0")/../.." || exit 1
git rev-parse --is-inside-work-tree >/dev/null 2>&1 || exit 77 # the files are those of git
python3 tests/base/names.py
