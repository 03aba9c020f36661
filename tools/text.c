/* text: names and sentences in lines of a given width. */
#include "text.h"

#include <string.h>

/** Whether c begins a character of UTF-8, or is one of another encoding. */
static int begins(char c) {
    return ((unsigned char)c & 0xC0) != 0x80;
}

int pl_text_columns(const char *text) {
    int columns = 0;
    for (const char *c = text; *c; c++)
        columns += begins(*c);
    return columns;
}

/** Append the characters first .. last - 1 of name to text [size]. */
static void append(const char *name, int first, int last, char *text, size_t size) {
    size_t used = strlen(text);
    int character = -1;
    for (const char *c = name; *c && used + 1 < size; c++) {
        character += begins(*c);
        if (character >= first && character < last)
            text[used++] = (unsigned char)*c < ' ' || *c == 127 ? '?' : *c;
    }
    text[used] = '\0';
}

const char *pl_text_fit(const char *name, int columns, char *text, size_t size) {
    static const char dots[] = "...";
    const int length = pl_text_columns(name), n_dots = (int)strlen(dots);
    text[0] = '\0';
    if (length <= columns || columns <= n_dots) {
        append(name, 0, columns, text, size);
        return text;
    }
    const int head = (columns - n_dots) / 2, tail = columns - n_dots - head; /* the end says more */
    append(name, 0, head, text, size);
    append(dots, 0, n_dots, text, size);
    append(name, length - tail, length, text, size);
    return text;
}

void pl_text_wrap(FILE *stream, const char *sentence) {
    int column = 0;
    for (const char *word = sentence; *word;) {
        const int length = (int)strcspn(word, " ");
        if (column > 0 && column + 1 + length > PL_TEXT_WIDTH) {
            fputc('\n', stream);
            column = 0;
        }
        column += fprintf(stream, "%s%.*s", column > 0 ? " " : "", length, word);
        word += length;
        word += strspn(word, " ");
    }
    fputc('\n', stream);
}
