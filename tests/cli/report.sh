#!/usr/bin/env bash
# The JSON reports: valid, complete, and what they say is so.
. "$(dirname "$0")/common.sh"

expect_status 0 "$program" smooth "$sample" -o out.msh --json report.json
expect_status 0 "$program" quality out.msh --json quality.json
expect_status 0 "$program" smooth "$sample" -o again.msh --json -
cp out stdout.json
expect_text "worst radius ratio"
python3 "$cli/check_report.py" report.json quality.json stdout.json || fail "reports"

# The peak is the program's own, not that of who calls it.
python3 -c 'import json, subprocess, sys
large = bytes(range(256)) * (1 << 20)
report = json.loads(subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, check=True).stdout)
assert 1 << 20 < report["peak_memory_bytes"] < len(large), report["peak_memory_bytes"]' \
    "$program" smooth "$sample" -o peak.msh -q --json - || fail "the peak"

expect_status 0 "$program" quality "$sample" --json input.json -q
python3 -c 'import json
assert json.load(open("report.json"))["input_checksum"] == json.load(open("input.json"))["checksum"]' ||
    fail "the checksum of the input"

# Names that are no UTF-8, quotes and line ends in names.
name=$(printf 'a\xff"b\nc\\.msh')
cp "$sample" "$name"
expect_status 0 "$program" smooth "$name" -o "$name" --json odd.json -q
python3 -m json.tool odd.json >/dev/null || fail "odd names in the report"
expect_status 2 "$program" smooth "x$name" -o out.msh
expect_one_line

# What hurts most stands first.
expect_status 0 "$program" quality out.msh
[ "$(sed -n 2p out | cut -c1-18)" = "worst radius ratio" ] || fail "first row of the table"
expect_status 0 "$program" quality out.msh --json - -q
[ ! -s err ] && python3 -m json.tool out >/dev/null || fail "quality --json - -q"
finish
