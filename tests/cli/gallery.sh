#!/usr/bin/env bash
# docs/gallery.md: its pictures and files exist, its planish commands have options that planish has, and README.md
# shows two pictures at most.
. "$(dirname "$0")/common.sh"

# check_gallery FILE: print what is wrong.
check_gallery() {
    local name option
    grep -o '](pictures/[^)]*)' "$1" | sed 's/](\(.*\))/\1/' | while read -r name; do
        [ -s "$source_folder/docs/$name" ] || echo "no picture $name"
    done
    grep '^    ' "$1" | grep -oE '\b(docs|bench)/[A-Za-z0-9_./-]+' | while read -r name; do
        [ -e "$source_folder/$name" ] || echo "no file $name"
    done
    grep '^    planish smooth ' "$1" | awk '{ print $4 }' | sort | uniq -d | while read -r name; do
        echo "a second $name: it exists already"
    done
    grep '^    planish smooth ' "$1" | grep -oE -- '--[a-z-]+' | sort -u | while read -r option; do
        grep -q -- "$option\b" help || echo "no option $option"
    done
}

"$program" smooth --help >help || fail "planish smooth --help"
found=$(check_gallery "$source_folder/docs/gallery.md")
[ -z "$found" ] || fail "docs/gallery.md: $found"
[ "$(grep -c '^    planish smooth ' "$source_folder/docs/gallery.md")" -ge 10 ] || fail "there are fewer than ten commands"
[ "$(grep -c '^!\[' "$source_folder/docs/gallery.md")" -eq 10 ] || fail "there are not ten pictures"
printf '![](pictures/none.svg)\n    gmsh -3 bench/none\n    planish smooth a b --none\n    planish smooth c b\n' >wrong.md
[ "$(check_gallery wrong.md | wc -l)" -eq 4 ] || fail "mistakes were not found: $(check_gallery wrong.md)"

pictures=$(grep -o '](docs/pictures/[^)]*)' "$source_folder/README.md" | sed 's/](\(.*\))/\1/')
[ "$(wc -w <<<"$pictures")" -le 2 ] || fail "README.md has more than two pictures"
for picture in $pictures; do
    [ -s "$source_folder/$picture" ] || fail "README.md shows $picture, which is not there"
done
finish
