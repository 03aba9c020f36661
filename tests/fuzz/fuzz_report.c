/* Any bytes as the JSON that `planish report` makes a page of. The page has tags that are known and
 * closed in order, so that no text of the JSON has become markup; its text is UTF-8 without control
 * characters; drawings have finite numbers.
 */
#include "fuzz_require.h"

#include "report/page.h"
#include "terminal/text.h"

#include <ctype.h>
#include <string.h>

enum { MOST_OPEN = 64, NAME_SIZE = 32 };

/** Where the reading of a page is, and the elements that are open. */
typedef struct reading {
    const char *at, *end;
    char open[MOST_OPEN][NAME_SIZE];
    int n_open;
} reading;

static int is_one_of(const char *name, const char *const *list) {
    while (*list && strcmp(name, *list) != 0)
        list++;
    return *list != NULL;
}

/** A name of tag or attribute. */
static void take_name(reading *r, char name[NAME_SIZE]) {
    int n = 0;
    while (r->at < r->end && (isalnum((unsigned char)*r->at) || *r->at == '-') && n < NAME_SIZE - 1)
        name[n++] = *r->at++;
    name[n] = '\0';
    fuzz_require(n > 0, "a name was expected in a tag");
}

/** The value of an attribute, in quotes. */
static void take_value(reading *r, const char *name) {
    static const char *const numeric[] = {"d",  "points", "x",      "y",         "x1",
                                          "x2", "y1",     "y2",     "cx",        "cy",
                                          "r",  "width",  "height", "transform", NULL};
    fuzz_require(r->at < r->end && *r->at++ == '"', "a value is in quotes");
    const char *close = memchr(r->at, '"', (size_t)(r->end - r->at));
    fuzz_require(close != NULL, "quotes are closed");
    for (const char *c = r->at; c < close; c++) {
        fuzz_require(*c != '<' && *c != '>', "values of attributes are escaped");
        if (is_one_of(name, numeric))
            fuzz_require(strncmp(c, "nan", 3) != 0 && strncmp(c, "inf", 3) != 0,
                         "drawings have finite numbers");
    }
    r->at = close + 1;
}

/** Attributes up to '>'; whether "/>" ends the tag. */
static int take_attributes(reading *r) {
    char name[NAME_SIZE];
    for (;;) {
        while (r->at < r->end && isspace((unsigned char)*r->at))
            r->at++;
        fuzz_require(r->at < r->end, "a tag has an end");
        if (*r->at == '>') {
            r->at++;
            return 0;
        }
        if (*r->at == '/') {
            r->at += 2;
            fuzz_require(r->at[-1] == '>', "a tag has an end");
            return 1;
        }
        take_name(r, name);
        if (*r->at == '=') {
            r->at++;
            take_value(r, name);
        }
    }
}

static void take_close(reading *r) {
    char name[NAME_SIZE];
    take_name(r, name);
    fuzz_require(r->n_open > 0 && strcmp(name, r->open[r->n_open - 1]) == 0,
                 "elements are closed in order");
    fuzz_require(*r->at++ == '>', "a tag has an end");
    r->n_open--;
}

static void take_open(reading *r) {
    static const char *const empty[] = {"meta", "br", "hr", "input", "img", "link", NULL};
    char name[NAME_SIZE], close[NAME_SIZE + 4];
    take_name(r, name);
    if (take_attributes(r) || is_one_of(name, empty))
        return;
    if (strcmp(name, "style") == 0 || strcmp(name, "script") == 0) {
        snprintf(close, sizeof close, "</%s>", name);
        r->at = strstr(r->at, close);
        fuzz_require(r->at != NULL, "style and script have an end");
        r->at += strlen(close);
        return;
    }
    fuzz_require(r->n_open < MOST_OPEN, "elements are not nested without end");
    strcpy(r->open[r->n_open++], name);
}

static void check_page(const pl_markup *page) {
    static const char doctype[] = "<!DOCTYPE html>";
    reading r = {.at = page->text, .end = page->text + page->length};
    fuzz_require(strncmp(r.at, doctype, sizeof doctype - 1) == 0, "a page begins as such");
    r.at += sizeof doctype - 1;
    while (r.at < r.end) {
        const char c = *r.at++;
        fuzz_require((unsigned char)c >= ' ' || c == '\n' || c == '\t', "text is printable");
        if (c == '<' && r.at < r.end && *r.at == '/') {
            r.at++;
            take_close(&r);
        } else if (c == '<') {
            take_open(&r);
        }
    }
    fuzz_require(r.n_open == 0, "all elements are closed");
}

static void check_utf8(const pl_markup *page) {
    for (const char *c = page->text; *c;) {
        const int length = pl_utf8_length(c);
        fuzz_require(length > 0, "a page is UTF-8");
        c += length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *end;
    pl_figures figures;
    pl_markup page = {0};
    cJSON *result = cJSON_ParseWithLengthOpts((const char *)data, size, &end, 0);
    if (result && !pl_figures_find(result, &figures)) {
        pl_page_make(&page, &figures, NULL, size % 2 ? "there is <none> & \"so\"" : NULL);
        fuzz_require(!page.failed && page.text[page.length] == '\0', "the page is made");
        check_page(&page);
        check_utf8(&page);
    }
    pl_markup_free(&page);
    cJSON_Delete(result);
    return 0;
}
