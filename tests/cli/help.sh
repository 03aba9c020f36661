#!/usr/bin/env bash
# Help, manual page, completions and docs/program.md tell of the same commands and options, and the program
# knows them; what is mistyped is guessed at.
. "$(dirname "$0")/common.sh"

"$program" --generate man >planish.1 && "$program" --generate bash >bash && "$program" --generate zsh >zsh ||
    fail "--generate"

# completions WORD...: what bash offers for the last one
completions() {
    bash -c 'source ./bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _planish
        printf "%s\n" "${COMPREPLY[@]}"' - "$@"
}
# options COMMAND: those of its help, without the two minuses
options() {
    "$program" help "$1" | grep -o '^  \(-.,\|   \) --[a-z-]*' | sed 's/.*--//'
}
# zsh_options COMMAND: those of its part of the completion
zsh_options() {
    sed -n "/^$1)/,/;;/p" zsh | grep -o "^ *'\*'[^']*'\[" | grep -o -e '--[a-z-]*' | sed 's/^--//'
}

# The table of docs/formats.md is the program's.
"$program" --generate formats >formats || fail "--generate formats"
[ "$(wc -l <formats)" -gt 20 ] || fail "too few formats"
grep -vxFf "$source_folder/docs/formats.md" formats && fail "docs/formats.md has another table of formats"

# Every command is in all of them.
commands=$("$program" --help | sed -n 's/^  \([a-z]\{1,\}\) .*/\1/p' | grep -vx help)
[ "$commands" = "$(printf 'smooth\nquality\ncompare\nadvise\ngroups\nconvert\nreport')" ] || fail "commands of the help: $commands"
for command in $commands; do
    grep -q "^\\\\fBplanish $command\\\\fR" planish.1 || fail "planish(1) lacks $command"
    grep -q "^    '$command:" zsh || fail "zsh lacks $command"
    grep -q "^    planish $command " "$source_folder/docs/program.md" || fail "program.md lacks $command"
    completions planish "${command:0:2}" | grep -qx "$command" || fail "bash lacks $command"
    completions planish help "${command:0:2}" | grep -qx "$command" || fail "bash lacks help $command"
    expect_status 0 "$program" "$command" --help
    grep -q "^Usage: planish $command " out && grep -q "^Exit status:" out || fail "help of $command"
    for same in "$command -h" "help $command"; do
        # shellcheck disable=SC2086
        "$program" $same | cmp - out || fail "planish $same is another help"
    done
done
"$program" help | cmp - <("$program" -h) || fail "planish help and -h"
"$program" help | cmp - <("$program" --help) || fail "planish help and --help"

# Every option of each command is, too, and no other.
# one_line: the lines of standard input, with blanks around each
one_line() {
    sed 's/^/ /; s/$/ /' | tr -d '\n'
}
page=$(sed 's/\\-/-/g; s/\\f[BRI]//g' planish.1)
of_page=$(grep -oE '^(-., )?--[a-z-]+( |$)' <<<"$page" | grep -o -e '--[a-z-]*' | one_line)
of_document=$(grep -o '`--[a-z-]*[` ]' "$source_folder/docs/program.md" | tr -d '` ' | one_line)
for command in $commands; do
    wanted=$(options "$command" | sort)
    [ "$(wc -w <<<"$wanted")" -ge 3 ] || fail "$command has too few options: $wanted"
    [ "$(completions planish "$command" -- | sed 's/^--//' | sort)" = "$wanted" ] ||
        fail "bash offers other options of $command"
    [ "$(zsh_options "$command" | sort)" = "$wanted" ] || fail "zsh offers other options of $command"
    for option in $wanted; do
        [[ $of_page == *" --$option "* ]] || fail "planish(1) lacks --$option"
        [[ $of_document == *" --$option "* ]] || fail "docs/program.md lacks --$option"
    done
    for option in $(some $wanted); do
        "$program" "$command" "--$option" x --no-such-option >out 2>err </dev/null
        contents_of err
        [[ $contents != *"--$option is not one of"* && $contents != *"--$option' is not one of"* &&
            $contents != *"unknown option '--$option'"* ]] || fail "$command does not know --$option"
    done
done
for command in $commands; do
    options "$command"
done >options
of_commands=$(one_line <options)
for option in $(grep -o -e '^\(-., \)\?--[a-z-]*' <<<"$page" | sed 's/.*--//'); do
    [[ $of_commands == *" $option "* ]] || fail "planish(1) has --$option, which no command has"
done

# The sections of smooth's help are those of docs/program.md, with the same options, each in one section.
# section_options NAME: the options in that section of smooth's help, without the two minuses
section_options() {
    "$program" smooth --help | sed -n "/^$1:$/,/^$/p" | grep -o -e '^.\{6\}--[a-z-]*' | sed 's/.*--//'
}
sections=$("$program" smooth --help | sed -n 's/^\([A-Z][a-z ]*\):$/\1/p' | grep -vx 'Exit status\|Examples')
[ "$sections" = "$(sed -n '/^## Options of smooth/,/^## /s/^### //p' "$source_folder/docs/program.md")" ] ||
    fail "sections of the help: $sections"
while read -r section; do
    wanted=$(section_options "$section")
    [ -n "$wanted" ] || fail "no option in section $section"
    of_section=$(sed -n "/^### $section$/,/^##* /p" "$source_folder/docs/program.md" | grep '^|' |
        grep -o '`--[a-z-]*[` ]' | tr -d '` ' | one_line)
    for option in $wanted; do
        [[ $of_section == *" --$option "* ]] ||
            fail "section $section of docs/program.md lacks --$option"
    done
done <<<"$sections"
[ "$(options smooth | sort | uniq -d)" = "" ] || fail "options in two sections: $(options smooth | sort | uniq -d)"

grep -q '^.SS "Options of smooth, quality, compare, advise, groups and convert"$' planish.1 ||
    fail "planish(1) joins names of commands: $(grep '^.SS' planish.1)"

# All within 80 columns.
for command in "" $commands; do
    # shellcheck disable=SC2086
    "$program" help $command | awk 'length($0) > 80 { exit 1 }' || fail "help $command is wider than 80 columns"
done
if command -v man >/dev/null; then
    warnings=$(LC_ALL=C MANWIDTH=80 man --warnings -l planish.1 2>&1 >page)
    [ -z "$warnings" ] || fail "planish(1): $warnings"
    col -bx <page | awk 'length($0) > 80 { exit 1 }' || fail "planish(1) is wider than 80 columns"
    for section in NAME SYNOPSIS COMMANDS OPTIONS FORMATS "EXIT STATUS" EXAMPLES; do
        col -bx <page | grep -qx "$section" || fail "planish(1) has no section $section"
    done
fi
! command -v groff >/dev/null || [ -z "$(groff -man -Tutf8 -ww planish.1 2>&1 >/dev/null)" ] ||
    fail "groff warns of planish(1)"
if command -v mandoc >/dev/null; then
    warnings=$(mandoc -T lint planish.1 | grep -v "missing date")
    [ -z "$warnings" ] || fail "mandoc of planish(1): $warnings"
fi

# Completion in use.
[ "$(completions planish q)" = quality ] || fail "completion of a command"
short() {
    completions planish "$1" - | grep -v '^--' | tr '\n' ' '
}
[ "$(short smooth)" = "-o -j -v -vv -q -h " ] || fail "short options: $(short smooth)"
[ "$(short report)" = "-o -q -h " ] || fail "short options of report: $(short report)"
[ "$(completions planish smooth - | grep -c '^--')" -gt 20 ] || fail "long options behind one minus"
[ "$(completions planish smooth -v | tr '\n' ' ')" = "-v -vv " ] || fail "completion of -v"
[ "$(completions planish smooth --objective mea)" = mean-ratio ] || fail "completion of a value"
[ "$(completions planish smooth --objective = mea)" = mean-ratio ] || fail "completion behind ="
[ "$(completions planish smooth --objective =)" = "$(completions planish smooth --objective "")" ] ||
    fail "completion right behind ="

# The formats are the library's, whose message about bytes of no format lists them, everywhere.
echo "no mesh" >a_file
expect_status 2 "$program" quality a_file
formats=$(sed -n 's/.*there are \(.*\) (docs.*/\1/p' err | tr -d ,)
[ "$(wc -w <<<"$formats")" -ge 13 ] || fail "the library's formats: $(cat err)"
[ "$(completions planish smooth --format "" | sort)" = "$(tr ' ' '\n' <<<"$formats" | sort)" ] ||
    fail "--format has other formats than the library: $formats"
listed=$("$program" help smooth | tr -s '\n ' ' ' | sed 's/.*format of the input: \([^(]*\) (.*/\1/; s/,\| or / /g')
[ "$(tr -s ' ' '\n' <<<"$listed")" = "$(tr ' ' '\n' <<<"$formats")" ] || fail "help of --format: $listed"
of_document=$(grep -o '^| .* | `[a-z0-9]*` | ' "$source_folder/docs/formats.md" | grep -o '`[a-z0-9]*` | $' | tr -d '`|' | one_line)
for format in $formats; do
    [[ $of_document == *" $format "* ]] || fail "docs/formats.md lacks $format"
done
grep -q "$(wc -w <<<"$formats") formats" "$source_folder/README.md" || fail "README.md has another number of formats"
[ "$(completions planish quality a_f)" = a_file ] || fail "completion of a file"
[ "$(completions planish smooth --json a_f)" = a_file ] || fail "completion of a file of an option"
! completions planish quality --obj | grep -q . || fail "options of another command are offered"
cp "$sample" groups.msh
[ "$(completions "$program" smooth groups.msh --fix sk)" = skin ] || fail "completion of a group"
[ "$(completions "$program" smooth groups.msh --slide = '' | head -n 5 | tr '\n' ' ')" = "auto curved none skin bracket " ] ||
    fail "completion of --slide: $(completions "$program" smooth groups.msh --slide = '')"
[ "$(completions "$program" groups.msh --slide-tol)" = --slide-tolerance ] || fail "options of planish IN"
[ "$(completions "$program" groups.msh --fix sk)" = skin ] || fail "a group of planish IN"
[ "$(completions "$program" grou | tr '\n' ' ')" = "groups groups.msh " ] || fail "files as the first word"
cp groups.msh "two words.msh"
[ "$(completions "$program" smooth 'two\ words.msh' --fix sk)" = skin ] || fail "groups of a file with a blank"
# Tags DIM:N: a colon is quoted, or a word of its own.
printf '%s\n' '$MeshFormat' '2.2 0 8' '$EndMeshFormat' '$Nodes' 4 '1 0 0 0' '2 1 0 0' '3 0 1 0' '4 1 1 0' '$EndNodes' \
    '$Elements' 4 '1 1 2 4 4 1 2' '2 1 2 40 40 1 3' '3 2 2 7 7 1 2 3' '4 2 2 7 7 2 4 3' '$EndElements' >tags.msh
for words in '1' '1\:' '"1:4' "'1:4"; do
    [ "$(completions "$program" smooth tags.msh --fix "$words" | tr '\n' ' ')" = "1:4 1:40 " ] ||
        fail "completion of $words: $(completions "$program" smooth tags.msh --fix "$words")"
done
[ "$(completions "$program" smooth tags.msh --fix 1 : 40)" = 40 ] || fail "completion of 1:40"
[ "$(completions "$program" smooth tags.msh --fix 1 : | tr '\n' ' ')" = "4 40 " ] || fail "completion of 1:"
[ "$(completions "$program" smooth tags.msh --fix = 1 : 40)" = 40 ] || fail "completion of =1:40"
mkfifo pipe
mkdir smooth
timeout 20 bash -c 'source ./bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _planish' - \
    "$program" smooth pipe --fix "" || fail "completion waits for a pipe"
[ "$(completions "$program" smooth groups.msh --fix sk)" = skin ] || fail "a folder that is called as a command"
if command -v zsh >/dev/null; then
    zsh -n zsh || fail "zsh does not understand its completion"
fi

# Mistyped words.
mistyped() {
    local wanted=$1
    shift
    expect_status 64 "$program" "$@"
    expect_one_line
    expect_text "$wanted"
    expect_text "--help"
}
mistyped "unknown option '--treads'; did you mean --threads?" smooth in.msh -o out.msh --treads 3
mistyped "unknown option '--thraeds'; did you mean --threads?" smooth in.msh -o out.msh --thraeds=3
mistyped "unknown option '--jsn'; did you mean --json?" quality in.msh --jsn -
mistyped "unknown option '--frobnicate'; try" quality in.msh --frobnicate
mistyped "planish quality has no option --box" quality in.msh --box 0,0,1,1
mistyped "unknown option '--worst-'; did you mean --worst-measure or --worst-rise?" smooth in.msh --worst- 3
# The beginning of a name is no option: the message is about what was typed.
for typed in "--tol 0" "--tol=0" --tol; do
    # shellcheck disable=SC2086
    mistyped "unknown option '--tol'; did you mean --tolerance?" smooth in.msh -o out.msh $typed
done
for typed in --fas --fas=3; do
    mistyped "unknown option '--fas'; did you mean --fast?" smooth in.msh -o out.msh $typed
done
mistyped "unknown option '--si'; did you mean --size, --size-from or --size-weight?" smooth in.msh -o out.msh --si h
mistyped "planish smooth has no option --to" smooth in.msh out.msh --to vtk
mistyped "planish smooth has no option --worst" smooth in.msh out.msh --worst 3
mistyped "planish quality has no option --slide" quality in.msh --slide
mistyped "planish quality has no option --slide" quality in.msh --slide 1e-6
mistyped "unknown option '--ver'; did you mean --verbose or --version?" smooth in.msh -o out.msh --fast -q --ver
mistyped "option --output needs a value (OUT)" smooth in.msh --fast -o
mistyped "unknown command 'smoth'; did you mean smooth?" smoth in.msh
mistyped "unknown command 'qualtiy'; did you mean quality?" help qualtiy
mistyped "unknown command 'polish'; it must be smooth, quality, compare, advise, groups, convert or report" polish
mistyped "smooth, quality, compare, advise, groups, convert or report"
mistyped "unexpected argument 'quality': help takes one command" help smooth quality
expect_status 0 "$program" help help
grep -q "^Usage: planish COMMAND" out || fail "help of help"
mistyped "no result is named" report
mistyped "unexpected argument 'b.json': give one result" report a.json b.json
mistyped "unexpected argument 'c.msh': give BEFORE and AFTER" compare a.msh b.msh c.msh
mistyped "unexpected argument 'c.vtk': give IN and OUT" convert a.msh b.vtk c.vtk
mistyped "unexpected argument 'b.vtk': give one mesh file" convert a.msh b.vtk -o c.vtk
mistyped "unexpected argument 'b.msh': to smooth several meshes, give --output-dir DIR or --in-place" smooth a.msh b.msh c.msh
finish
