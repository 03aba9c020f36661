#!/usr/bin/env bash
# Every call to the system fails once, or does half of what it should: tests/faults/inject.py.
. "$(dirname "$0")/common.sh"

[ -n "${PLANISH_FAULTS-}" ] || { echo "skipped: this C library's functions cannot be replaced"; exit 77; }

python3 "$source_folder/tests/faults/inject.py" "$PLANISH_FAULTS" || fail "what a fault leaves behind"
finish
