#!/usr/bin/env bash
# The JSON reports: valid, complete, and what they say is so.
. "$(dirname "$0")/common.sh"

expect_status 0 "$program" smooth "$sample" -o out.msh --json report.json
expect_status 0 "$program" quality out.msh --json quality.json
expect_status 0 "$program" smooth "$sample" -o again.msh --json -
cp out stdout.json
expect_text "worst radius ratio"
python3 "$cli/check_report.py" report.json quality.json stdout.json || fail "reports"

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
