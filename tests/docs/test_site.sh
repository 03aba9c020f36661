#!/usr/bin/env bash
# The site is built without a warning, its links lead somewhere, and in a browser, from files and without a network, its
# pages are complete: what search finds, nothing that is wider than a narrow window, and no complaint on the console.
set -u
here=$(cd "$(dirname "$0")" && pwd)
/usr/bin/python3 -c 'import sphinx, myst_parser, furo, numpy' 2>/dev/null ||
    { echo "without python3-sphinx, python3-myst-parser, furo or numpy"; exit 77; }
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome)
[ -n "$browser" ] || { echo "no chromium here"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$here/../../tools/site" "$work/site" || exit 1
python3 "$here/links.py" "$work/site" || exit 1

# has PAGE PREFIX NAME...: the reference on PAGE has all of these.
has() {
    local page=$work/site/$1.html prefix=$2 name
    shift 2
    [ $# -gt 10 ] || { echo "$page: only $# names are looked for: the pattern is wrong"; exit 1; }
    for name; do
        grep -q "id=\"$prefix$name\"" "$page" || { echo "$page has no $name"; exit 1; }
    done
}
cd "$here/../.." || exit 1
for header in include/planish/planish include/planish/planish_io; do
    # shellcheck disable=SC2046 # names
    has "$header" c. $(sed -n -E 's/^PLANISH_API [^(;]*\b(\w+)\(.*/\1/p; s/^typedef (struct|enum) (\w+).*/\2/p' "$header.h")
done
# shellcheck disable=SC2046
has docs/site/python-reference '\(module-\)*planish.' $(sed -n '/^__all__/,$p' tools/python/planish/__init__.py | grep -oE '"\w+"' | tr -d '"')

find "$work/site" -name '*.html' -exec sed -i \
    's|</body>|<script>onload = () => document.body.dataset.over = document.documentElement.scrollWidth - innerWidth</script></body>|' {} +

# look PAGE TEXT [QUERY]: open it in the narrowest window (500 pixels), where it has TEXT.
look() {
    timeout 120 "$browser" --headless=new --no-sandbox --user-data-dir="$work/profile" --enable-logging=stderr \
        --host-resolver-rules="MAP * ~NOTFOUND" --hide-scrollbars --window-size=390,900 --virtual-time-budget=10000 \
        --dump-dom "file://$work/site/$1.html${3-}" >"$work/dom" 2>"$work/log"
    ! grep CONSOLE "$work/log" || { echo "$1: the console says that"; exit 1; }
    grep -q 'data-over="0"' "$work/dom" || { echo "$1 is wider than the window: $(grep -o 'data-over="[^"]*"' "$work/dom")"; exit 1; }
    grep -qF -e "$2" "$work/dom" || { echo "$1: '$2' is missing"; exit 1; }
}

look index '>Tutorial</a>'
look docs/performance 'id="threads"'
look include/planish/planish 'id="c.planish_options.max_sweeps"'
look docs/site/python-reference 'id="planish.Plan.smooth"'
look search '>Elements of every type</a>' '?q=hexahedra'
look search 'planish.html#c.planish_find_layers' '?q=planish_find_layers'
