#!/usr/bin/env bash
# Periodic domains whose nodes are there once each: the elements that reach around are named and held,
# and the rest is smoothed as ever.
. "$(dirname "$0")/common.sh"

for case in "10 4 x" "4 10 y" "9 8 xy" "3 5 x"; do
    read -r nx ny directions <<<"$case"
    python3 "$cli/make_periodic.py" $nx $ny $directions in.mesh >numbers || fail "make_periodic.py $case"
    expect_status 1 "$program" smooth in.mesh -o out.mesh --json report.json
    expect_text "wrap around a periodic domain"
    expect_json "r['wrapped'] == $(cat numbers) and r['mesh']['wrapped_elements'] == len(r['wrapped'])"
    expect_json "set(r['unfixable']) <= set(r['wrapped']) and r['untangling_sweeps'] == 0"
    expect_json "r['before']['inverted'] == r['after']['inverted'] == len(r['unfixable'])"
    expect_json "r['after']['rms_radius_ratio'] <= r['before']['rms_radius_ratio']"
    [ "$case" = "3 5 x" ] || expect_json "r['moved_nodes'] > 0"
    expect_json "r['mesh']['held']['wrapped'] > 0"
    expect_status 0 "$program" quality in.mesh --json report.json
    expect_json "r['wrapped'] == $(cat numbers)"
done

# No seam: as ever.
python3 "$cli/make_periodic.py" 6 5 none in.mesh >numbers || fail make_periodic.py
expect_status 0 "$program" smooth in.mesh -o out.mesh --json report.json
! grep -q "wrap around" out || fail "nothing wraps around"
expect_json "r['wrapped'] == [] and r['mesh']['wrapped_elements'] == 0"

finish
