/* text: names and sentences in lines of a given width.
 *
 *     pl_text_columns, _fit           widths
 *     pl_text_put_word                a word for a shell
 *     pl_text_clean, _put, _control   characters that a terminal may not get
 *     pl_utf8_length                  whether bytes are UTF-8
 */
#ifndef PL_TOOLS_TEXT_H
#define PL_TOOLS_TEXT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Columns of all that is printed for people, and of what narrow terminals get. */
enum { PL_TEXT_WIDTH = 80, PL_TEXT_NARROW = 60 };

/** Columns that text takes: two for each wide character (of Chinese, say), none for an accent of
 * its own; bytes that are not UTF-8 are characters of Latin-1. */
int pl_text_columns(const char *text);

/** Replace each control character of text, C1 (U+0080 to U+009F) too, by '?', in place. */
void pl_text_clean(char *text);

/** Print text, cleaned like that. */
void pl_text_put(FILE *stream, const char *text);

/** Print text as one word for a shell: in quotes where it needs some, with \ooo for controls. */
void pl_text_put_word(FILE *stream, const char *text);

/** Name in columns at most: if it is longer, with "..." for its middle; control characters become
 *  '?'. text [size] is filled in and returned, with what there is room for; strlen(name) + 4 is
 *  always enough, 4 * columns + 1 for characters without accents of their own. */
const char *pl_text_fit(const char *name, int columns, char *text, size_t size);

/** Bytes of the character that text begins with if a terminal may not get it: a control, or one
 *  that changes the direction of what follows; *code: its number. Else 0. */
int pl_text_control(const char *text, uint32_t *code);

/** Replacement of bytes that are not UTF-8: U+FFFD. */
#define PL_UTF8_REPLACEMENT "\xEF\xBF\xBD"

/** Length of the well-formed UTF-8 sequence at text, or 0; 1 for '\0'. Names of files and groups
 * are any bytes. */
int pl_utf8_length(const char *text);

#endif
