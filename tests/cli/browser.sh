#!/usr/bin/env bash
# Pages in a real browser: no complaint on its console, and the pictures are drawn.
. "$(dirname "$0")/common.sh"

[ -z "${PLANISH_QUICK-}" ] || { echo "left to tools/check --full: it takes a minute"; exit 77; }
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
[ -n "$browser" ] || { echo "no chromium here"; exit 77; }
expect_status 0 "$program" smooth "$sample" -o smooth.msh --report solid.html -q
grep -q "without three.js" solid.html && { echo "built without three.js"; exit 77; }

# browse PAGE OPTION...: opens it as a browser does; what its console says goes to console.
browse() {
    local page=$1
    shift
    timeout 120 "$browser" --headless=new --no-sandbox --user-data-dir="$work/profile" \
        --use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist \
        --enable-logging=stderr --virtual-time-budget=10000 "$@" "file://$work/$page" >dom 2>log
    grep "CONSOLE" log >console
}

# expect_picture PAGE N TEXT...: it draws N views, and their captions say TEXT.
expect_picture() {
    local page=$1 wanted=$2 text
    shift 2
    browse "$page" --dump-dom
    [ ! -s console ] || { fail "$page: the console says"; head -n 5 console; }
    [ "$(grep -o '<canvas' dom | wc -l)" -eq "$wanted" ] || fail "$page: $wanted views"
    for text; do
        grep -qF -e "$text" dom || fail "$page: '$text' is not in it"
    done
}

python3 "$cli/make_mesh.py" 6 0.9 tangled.mesh
cp "$source_folder/tests/data/square.msh" square.msh
expect_status 0 "$program" smooth tangled.mesh -o smooth.mesh --report tangled.html -q
expect_status 0 "$program" smooth square.msh -o plane.msh --report plane.html -q
expect_status 0 "$program" quality tangled.mesh --report quality.html -q
inverted=$("$program" quality tangled.mesh | sed -n 's/^inverted elements *//p')
expect_picture solid.html 2 "elements worse than"
expect_picture tangled.html 2 "$inverted of them inverted"
# More inverted elements than are drawn: what is bad after that is still to be seen.
python3 "$cli/make_mesh.py" 20 0.9 large.mesh
expect_status 0 "$program" smooth large.mesh -o smooth.mesh --report large.html -q
expect_picture large.html 2 "of which 4,000 are drawn" "after: "
grep -q 'after: <span class="count">[0-9,]* elements worse than 1\.[0-9]' dom || fail "no element of the result can be chosen"
expect_picture plane.html 2 "elements worse than"
expect_picture quality.html 1 "$inverted of them inverted"

# What is drawn is there to be seen: the page without the drawing makes a much smaller picture.
browse tangled.html --window-size=1200,2000 --screenshot="$work/with.png"
sed 's/getContext(.webgl.)/getContext("none")/' tangled.html >without.html
browse without.html --window-size=1200,2000 --screenshot="$work/without.png"
[ "$(stat -c %s with.png)" -gt $(($(stat -c %s without.png) * 14 / 10)) ] || fail "nothing is drawn"
browse without.html --dump-dom
[ ! -s console ] && grep -q "it has no WebGL" dom || fail "without WebGL that should be said"
finish
