#!/usr/bin/env bash
# The lists at the top of the public headers are true.
cd "$(dirname "$0")/../.." || exit 1
python3 tests/base/headings.py
