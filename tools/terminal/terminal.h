/* terminal: colours, blocks and a line that is written over, if a stream can show them.
 *
 * There are colours on terminals only, and none where TERM is dumb or unset, or NO_COLOR is set
 * (https://no-color.org). What is decided depends on the stream and the environment alone.
 *
 *     pl_terminal_*          what a stream can show, and how wide it is
 *     pl_style_begin, _end    a text in colour
 *     pl_line_show, _clear    the line that is written over
 */
#ifndef PL_TOOLS_TERMINAL_H
#define PL_TOOLS_TERMINAL_H

#include <stdio.h>

typedef enum pl_style {
    PL_STYLE_PLAIN,
    PL_STYLE_HEADING, /* bold */
    PL_STYLE_BETTER,  /* green */
    PL_STYLE_WORSE,   /* red */
    PL_STYLE_NOTE,    /* yellow */
    PL_STYLE_ERROR    /* bold red */
} pl_style;

/** Whether stream is a terminal that lines can be written over on. */
int pl_terminal_is(FILE *stream);

/** Whether it shows blocks: a terminal, and the locale's characters are UTF-8. */
int pl_terminal_has_blocks(FILE *stream);

/** Columns of the terminal that stream is; 80 where it is not known. */
int pl_terminal_columns(FILE *stream);

/** Columns that a line on stream may have: those of the terminal that it is, or any number. */
int pl_terminal_room(FILE *stream);

/** Columns of lines on stream: PL_TEXT_WIDTH, or PL_TEXT_NARROW on a terminal that is narrower. */
int pl_terminal_text_width(FILE *stream);

/** Print sentence and a line end, in lines of pl_terminal_text_width() at most, broken at blanks. */
void pl_terminal_wrap(FILE *stream, const char *sentence);

/** Sequence to print before and behind a text of a style; "" without colours. */
const char *pl_style_begin(FILE *stream, pl_style style);
const char *pl_style_end(FILE *stream, pl_style style);

/** A line on standard error, which the next one is written over; nothing else may be written there
 *  before it is cleared. Cut to fit the terminal. */
void pl_line_show(const char *text);
void pl_line_clear(void);

#endif
