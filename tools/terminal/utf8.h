/* utf8: what is text. Names of files and groups are any bytes. */
#ifndef PL_TOOLS_UTF8_H
#define PL_TOOLS_UTF8_H

/** What stands for bytes that are no UTF-8: U+FFFD. */
#define PL_UTF8_REPLACEMENT "\xEF\xBF\xBD"

/** Length of the well-formed UTF-8 sequence at text, or 0; 1 for '\0'. */
int pl_utf8_length(const char *text);

#endif
