/* terminal: what a stream can show: colours, blocks, and a line that is written over. */
#include "terminal/terminal.h"

#include "terminal/platform.h"
#include "terminal/signals.h"
#include "terminal/text.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { USUAL_COLUMNS = 80 };

int pl_terminal_is(FILE *stream) {
    return pl_console_is(stream) && pl_console_obeys();
}

/** Whether stream is a terminal that shows colours. */
static int has_colours(FILE *stream) {
    const char *none = getenv("NO_COLOR");
    return !(none && none[0]) && pl_terminal_is(stream);
}

int pl_terminal_has_blocks(FILE *stream) {
    return pl_terminal_is(stream) && pl_console_is_utf8();
}

int pl_terminal_columns(FILE *stream) {
    const int columns = pl_console_columns(stream);
    return columns > 0 ? columns : USUAL_COLUMNS;
}

int pl_terminal_room(FILE *stream) {
    return pl_console_is(stream) ? pl_terminal_columns(stream) : INT_MAX;
}

int pl_terminal_text_width(FILE *stream) {
    return pl_terminal_room(stream) < PL_TEXT_WIDTH ? PL_TEXT_NARROW : PL_TEXT_WIDTH;
}

void pl_terminal_wrap(FILE *stream, const char *sentence) {
    const int width = pl_terminal_text_width(stream);
    int column = 0;
    for (const char *word = sentence; *word;) {
        const int length = (int)strcspn(word, " ");
        if (column > 0 && column + 1 + length > width) {
            fputc('\n', stream);
            column = 0;
        }
        column += fprintf(stream, "%s%.*s", column > 0 ? " " : "", length, word);
        word += length;
        word += strspn(word, " ");
    }
    fputc('\n', stream);
}

const char *pl_style_begin(FILE *stream, pl_style style) {
    static const char *const codes[] = {
        [PL_STYLE_PLAIN] = "",          [PL_STYLE_HEADING] = "\033[1m",
        [PL_STYLE_BETTER] = "\033[32m", [PL_STYLE_WORSE] = "\033[31m",
        [PL_STYLE_NOTE] = "\033[33m",   [PL_STYLE_ERROR] = "\033[1;31m",
    };
    return has_colours(stream) ? codes[style] : "";
}

const char *pl_style_end(FILE *stream, pl_style style) {
    return style != PL_STYLE_PLAIN && has_colours(stream) ? "\033[0m" : "";
}

void pl_line_show(const char *text) {
    const int room = pl_terminal_columns(stderr) - 1; /* the last column would wrap on some */
    pl_signals_set_line(1);
    fprintf(stderr, "\r%.*s" PL_ERASE_TO_END, room > 0 ? room : 0, text);
    fflush(stderr);
}

void pl_line_clear(void) {
    if (!pl_signals_set_line(0))
        return;
    fputs("\r" PL_ERASE_TO_END, stderr);
    fflush(stderr);
}
