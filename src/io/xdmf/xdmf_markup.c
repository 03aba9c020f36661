/* xdmf_markup: the elements of an XDMF file, and those that it refers to.
 *
 * References are paths of XPath, as far as programs write them: steps of names or '*', with the
 * conditions [number], [@Name="value"] and [self::Name or self::Name]; and XPointer's element(/1/2).
 */
#include "io/xdmf/xdmf_markup.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/number.h"
#include "io/xml/xml.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { NO_ELEMENT = -1, MOST_REFERENCES = 16, MOST_PATH = 4096, MOST_ATTRIBUTES = 256 };

/* Elements that all paths and walks of a file may look at, once for each reference to them. */
static const int64_t MOST_LOOKED_AT = INT64_C(1) << 28;

/* ---- reading ------------------------------------------------------------------------------- */

/** Keep a word: its place, or -1 without memory. */
static int64_t keep_word(xdmf_document *d, const char *word) {
    const int64_t length = (int64_t)strlen(word) + 1, place = d->n_text;
    char *text = pl_grow(d->text, place, place + length, &d->text_capacity, 1);
    if (!text)
        return -1;
    memcpy(text + place, word, (size_t)length);
    d->text = text;
    d->n_text += length;
    return place;
}

static int fail_memory(const xdmf_document *d) {
    return pl_fail_memory(d->error, "the markup of the file");
}

/** Return the name behind its prefix, if it has one (xi:include). */
static const char *local_name(const char *name) {
    const char *colon = strchr(name, ':');
    return colon ? colon + 1 : name;
}

static int begin_element(io_xml *xml, const char *name) {
    xdmf_document *d = xml->user;
    if (d->n == 0 && strcasecmp(name, "Xdmf") != 0)
        return io_xml_fail(xml, "Xdmf expected: this is not an XDMF file");
    xdmf_element e = {.parent = d->open,
                      .child = NO_ELEMENT,
                      .last = NO_ELEMENT,
                      .next = NO_ELEMENT,
                      .name = keep_word(d, local_name(name)),
                      .attributes = d->n_attributes,
                      .tag = xml->tag_begin,
                      .begin = xml->tag_end,
                      .end = xml->tag_end};
    int is_kept = e.name >= 0;
    for (int n = 0; xml->attributes[n]; n++) /* each question to the element looks at all */
        if (n == 2 * MOST_ATTRIBUTES)
            return io_xml_fail(xml, "an element with more than 256 attributes");
    for (; is_kept && xml->attributes[e.n_attributes]; e.n_attributes++) {
        const int64_t place = keep_word(d, xml->attributes[e.n_attributes]);
        is_kept = place >= 0 && pl_append(&d->attribute, &d->n_attributes, &d->attribute_capacity,
                                          &place, sizeof place);
    }
    if (xml->model->input.data[xml->tag_end - 1] == '>' &&
        xml->model->input.data[xml->tag_end - 2] != '/')
        io_xml_take_text(xml, &e.begin, &e.end);
    if (!is_kept || !pl_append(&d->element, &d->n, &d->capacity, &e, sizeof e))
        return fail_memory(d);
    const int64_t index = d->n - 1;
    if (d->open != NO_ELEMENT) {
        xdmf_element *parent = &d->element[d->open];
        if (parent->last == NO_ELEMENT)
            parent->child = index;
        else
            d->element[parent->last].next = index;
        parent->last = index;
    }
    d->open = index;
    return PLANISH_OK;
}

/** Leave white space around the text of an element out. */
static void trim_text(const char *data, xdmf_element *e) {
    while (e->begin < e->end && io_is_space(data[e->begin]))
        e->begin++;
    while (e->begin < e->end && io_is_space(data[e->end - 1]))
        e->end--;
}

static int end_element(io_xml *xml, const char *name) {
    xdmf_document *d = xml->user;
    xdmf_element *e = &d->element[d->open];
    (void)name;
    e->is_broken = e->child == NO_ELEMENT && xml->tag_begin > e->begin && e->end != xml->tag_begin;
    trim_text(xml->model->input.data, e);
    d->open = e->parent;
    return PLANISH_OK;
}

int xdmf_markup_read(const io_model *model, xdmf_document *d, planish_error *error) {
    *d = (xdmf_document){.view = {.input = model->input,
                                  .threads = io_model_threads(model),
                                  .largest_copy = model->largest_copy},
                         .error = error,
                         .open = NO_ELEMENT};
    io_xml xml = {.model = &d->view,
                  .error = error,
                  .begin = begin_element,
                  .end = end_element,
                  .user = d,
                  .format = "XDMF",
                  .may_have_doctype = 1};
    return io_xml_read(&xml);
}

void xdmf_markup_release(xdmf_document *d) {
    pl_free(d->element);
    pl_free(d->attribute);
    pl_free(d->text);
    pl_free(d->last_path);
    pl_free(d->last_found.element);
}

/* ---- questions ----------------------------------------------------------------------------- */

int xdmf_is(const xdmf_document *d, int64_t element, const char *name) {
    return strcasecmp(d->text + d->element[element].name, name) == 0;
}

const char *xdmf_attribute(const xdmf_document *d, int64_t element, const char *name) {
    const xdmf_element *e = &d->element[element];
    for (int64_t i = 0; i + 1 < e->n_attributes; i += 2)
        if (strcasecmp(d->text + d->attribute[e->attributes + i], name) == 0)
            return d->text + d->attribute[e->attributes + i + 1];
    return NULL;
}

io_slice xdmf_text(const xdmf_document *d, int64_t element) {
    const xdmf_element *e = &d->element[element];
    const char *data = d->view.input.data;
    return (io_slice){data + e->begin, data + e->end};
}

int xdmf_fail(const xdmf_document *d, int64_t element, const char *format, ...) {
    char text[320];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const xdmf_element *e = &d->element[element];
    const char *name = xdmf_attribute(d, element, "Name");
    return io_fail_at(&d->view, d->view.input.data + e->tag, d->error, "%s%s%.60s%s: %s",
                      d->text + e->name, name ? " '" : "", name ? name : "", name ? "'" : "", text);
}

/* ---- paths --------------------------------------------------------------------------------- */

static int add(const xdmf_document *d, xdmf_list *list, int64_t element) {
    return pl_append(&list->element, &list->n, &list->capacity, &element, sizeof element)
               ? PLANISH_OK
               : fail_memory(d);
}

/** Return the element behind another one in the same element; the first in none is the outermost. */
static int64_t first_in(const xdmf_document *d, int64_t element) {
    return element == NO_ELEMENT ? 0 : d->element[element].child;
}

enum { MOST_NAMES = 4, NAME_SIZE = 64, VALUE_SIZE = 256 };

/** Condition of a step: a position from 1, or a value of an attribute, or one of some names. */
typedef struct condition {
    int64_t position;
    char name[MOST_NAMES][NAME_SIZE], value[VALUE_SIZE];
    int n_names, is_attribute;
} condition;

/** A path while it is followed. */
typedef struct path_walk {
    xdmf_document *d;
    io_cursor rest;
    int is_bad; /* what stands there is not understood */
} path_walk;

/** Take text, behind white space, if it stands there. */
static int take(path_walk *w, const char *text) {
    const int64_t length = (int64_t)strlen(text);
    io_skip_space(&w->rest);
    if (w->rest.end - w->rest.at < length || memcmp(w->rest.at, text, (size_t)length) != 0)
        return 0;
    w->rest.at += length;
    return 1;
}

static void demand(path_walk *w, const char *text) {
    w->is_bad |= !take(w, text);
}

static int is_in_name(char c) {
    return (io_upper(c) >= 'A' && io_upper(c) <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.' || c == '*';
}

static void take_name(path_walk *w, char *name) {
    size_t n = 0;
    io_skip_space(&w->rest);
    for (; w->rest.at < w->rest.end && is_in_name(*w->rest.at) && n + 1 < NAME_SIZE; w->rest.at++)
        name[n++] = *w->rest.at;
    name[n] = '\0';
    w->is_bad |= n == 0;
}

/** Take a value between quotes. */
static void take_value(path_walk *w, char *value) {
    const char *quote = take(w, "\"") ? "\"" : take(w, "'") ? "'" : NULL;
    size_t n = 0;
    for (; quote && w->rest.at < w->rest.end && *w->rest.at != *quote && n + 1 < VALUE_SIZE; n++)
        value[n] = *w->rest.at++;
    value[n] = '\0';
    w->is_bad |= !quote;
    if (quote)
        demand(w, quote);
}

/** Take a condition, behind its '['. */
static void take_condition(path_walk *w, condition *c) {
    *c = (condition){.position = 0};
    if (io_parse_integer(&w->rest.at, w->rest.end, &c->position) == 0) {
        w->is_bad |= c->position < 1;
    } else if (take(w, "@")) {
        c->is_attribute = 1;
        take_name(w, c->name[0]);
        demand(w, "=");
        take_value(w, c->value);
    } else {
        do {
            demand(w, "self::");
            w->is_bad |= c->n_names == MOST_NAMES;
            if (!w->is_bad)
                take_name(w, c->name[c->n_names++]);
        } while (!w->is_bad && take(w, "or"));
    }
    demand(w, "]");
}

static int is_true(const xdmf_document *d, const condition *c, int64_t element, int64_t position) {
    if (c->position > 0)
        return position == c->position;
    if (c->is_attribute) {
        const char *has = xdmf_attribute(d, element, c->name[0]);
        return has && strcmp(has, c->value) == 0;
    }
    for (int i = 0; i < c->n_names; i++)
        if (xdmf_is(d, element, c->name[i]))
            return 1;
    return 0;
}

/** Note that n more elements have been looked at; paths that look at too many are not followed. */
static void count_looks(path_walk *w, int64_t n) {
    w->d->n_looked_at += n;
    w->is_bad |= w->d->n_looked_at > MOST_LOOKED_AT;
}

/** Return the position that the condition at the cursor asks for; 0: it asks for none. */
static int64_t position_ahead(const path_walk *w) {
    path_walk ahead = *w;
    int64_t position;
    return take(&ahead, "[") && !io_parse_integer(&ahead.rest.at, ahead.rest.end, &position) &&
                   position > 0
               ? position
               : 0;
}

/** Add the elements called name in an element, those for which the conditions at the cursor hold. */
static int add_children(path_walk *w, int64_t element, const char *name, xdmf_list *to) {
    const int64_t first = to->n, position = position_ahead(w);
    int status = PLANISH_OK;
    for (int64_t c = first_in(w->d, element);
         c != NO_ELEMENT && !status && (position == 0 || to->n - first < position);
         c = element == NO_ELEMENT ? NO_ELEMENT : w->d->element[c].next, count_looks(w, 1))
        if (strcmp(name, "*") == 0 || xdmf_is(w->d, c, name))
            status = add(w->d, to, c);
    while (!status && !w->is_bad && take(w, "[")) {
        condition c;
        int64_t n = first;
        take_condition(w, &c);
        count_looks(w, to->n - first);
        for (int64_t i = first; i < to->n; i++)
            if (is_true(w->d, &c, to->element[i], i - first + 1))
                to->element[n++] = to->element[i];
        to->n = n;
    }
    return status;
}

/** Replace the elements of the list by those that the next step leads to. */
static int take_step(path_walk *w, xdmf_list *list) {
    xdmf_list from = *list, to = {0};
    char name[NAME_SIZE];
    int status = PLANISH_OK;
    const int is_deep = take(w, "/"); /* from any element within, too */
    take_name(w, name);
    for (int64_t i = 0; is_deep && i < from.n && !status && !w->is_bad; i++)
        for (int64_t e = from.element[i], c = first_in(w->d, e); c != NO_ELEMENT && !status;
             c = e == NO_ELEMENT ? NO_ELEMENT : w->d->element[c].next, count_looks(w, 1)) {
            w->is_bad |= from.n > w->d->n; /* some are in it twice */
            status = w->is_bad ? PLANISH_OK : add(w->d, &from, c);
        }
    const io_cursor conditions = w->rest;
    for (int64_t i = 0; i < from.n && !status && !w->is_bad; i++) {
        w->rest = conditions;
        status = add_children(w, from.element[i], name, &to);
        w->is_bad |= to.n > w->d->n; /* some are in it twice */
    }
    if (from.n == 0)
        w->rest.at = w->rest.end;
    pl_free(from.element);
    *list = to;
    return status;
}

/** Follow XPointer's child sequence: /1/2, of elements that are counted from 1. */
static void take_counts(path_walk *w, xdmf_list *list) {
    int64_t count, at = NO_ELEMENT;
    do {
        demand(w, "/");
        w->is_bad |= io_parse_integer(&w->rest.at, w->rest.end, &count) != 0 || count < 1;
        at = w->is_bad ? NO_ELEMENT : first_in(w->d, at);
        for (; at != NO_ELEMENT && count > 1; count--)
            at = w->d->element[at].next;
    } while (!w->is_bad && at != NO_ELEMENT && w->rest.at < w->rest.end && *w->rest.at == '/');
    list->n = at != NO_ELEMENT;
    list->element[0] = at;
}

/** Take the steps of a path, from the list of NO_ELEMENT alone on. */
static int take_steps(path_walk *w, xdmf_list *list) {
    int status = PLANISH_OK;
    if (take(w, "element(")) {
        take_counts(w, list);
        demand(w, ")");
    } else {
        const int is_pointer = take(w, "xpointer(");
        do {
            demand(w, "/");
            status = w->is_bad ? PLANISH_OK : take_step(w, list);
            io_skip_space(&w->rest);
        } while (!status && !w->is_bad && w->rest.at < w->rest.end && *w->rest.at == '/');
        if (is_pointer && w->rest.at < w->rest.end)
            demand(w, ")");
    }
    io_skip_space(&w->rest);
    w->is_bad |= w->rest.at < w->rest.end;
    return status;
}

/** Find the elements that the path, which stands in an element, leads to: d->last_found, which the path
 *  before leaves where it is the same. */
static int follow(xdmf_document *d, int64_t element, io_slice path) {
    const int64_t length = io_slice_length(path);
    if (length > MOST_PATH)
        return xdmf_fail(d, element, "its path of %lld characters is too long", (long long)length);
    if (d->last_path && (int64_t)strlen(d->last_path) == length &&
        memcmp(d->last_path, path.begin, (size_t)length) == 0)
        return PLANISH_OK;
    pl_free(d->last_path);
    d->last_path = NULL;
    d->last_found.n = 0;
    char *text = pl_alloc(length + 1, 1);
    int status = text ? add(d, &d->last_found, NO_ELEMENT) : fail_memory(d);
    if (text) {
        memcpy(text, path.begin, (size_t)length);
        text[length] = '\0';
    }
    path_walk w = {d, {text, text ? text + length : NULL}, 0};
    if (!status)
        status = take_steps(&w, &d->last_found);
    if (!status && d->n_looked_at > MOST_LOOKED_AT)
        status = xdmf_fail(d, element,
                           "its path and those before it pass too many elements; write what it "
                           "refers to in its place");
    else if (!status && w.is_bad)
        status = xdmf_fail(d, element,
                           "the path '%.100s' is not understood; planish follows paths "
                           "such as /Xdmf/Domain/Grid[1]/Topology",
                           text);
    if (status)
        pl_free(text);
    else
        d->last_path = text;
    return status;
}

/* ---- elements in an element ----------------------------------------------------------------- */

int xdmf_resolve(xdmf_document *d, int64_t element, int64_t *found) {
    int n = 0;
    const char *reference;
    for (*found = element; (reference = xdmf_attribute(d, *found, "Reference")); *found = element) {
        /* The path is the attribute, or the text where that says XML. */
        const io_slice attribute = {reference, reference + strlen(reference)};
        const int status =
            follow(d, element, *reference == '/' ? attribute : xdmf_text(d, element));
        if (status)
            return status;
        if (d->last_found.n == 0 || ++n > MOST_REFERENCES)
            return xdmf_fail(d, element,
                             n > MOST_REFERENCES ? "it refers to itself"
                                                 : "it refers to something that does not exist");
        element = d->last_found.element[0];
    }
    return PLANISH_OK;
}

/** Add an element to the list if it has the name, or those that it includes. */
static int add_named(xdmf_document *d, int64_t element, const char *name, xdmf_list *list) {
    if (xdmf_is(d, element, name))
        return add(d, list, element);
    if (!xdmf_is(d, element, "include"))
        return PLANISH_OK;
    const char *file = xdmf_attribute(d, element, "href");
    const char *path = xdmf_attribute(d, element, "xpointer");
    if ((file && *file) || !path)
        return xdmf_fail(d, element,
                         "another XML file is included, which is not read; put its "
                         "content into this file");
    int status = follow(d, element, (io_slice){path, path + strlen(path)});
    if (!status && d->last_found.n == 0)
        return xdmf_fail(d, element, "it includes something that does not exist");
    /* A path such as /Xdmf/Domain/Grid/Geometry means the first one. */
    for (int64_t i = 0; i < d->last_found.n && !status; i++)
        if (xdmf_is(d, d->last_found.element[i], name))
            return add(d, list, d->last_found.element[i]);
    return status;
}

int xdmf_children(xdmf_document *d, int64_t element, const char *name, xdmf_list *list) {
    int status = PLANISH_OK;
    list->n = 0;
    for (int64_t c = d->element[element].child; c != NO_ELEMENT && !status; c = d->element[c].next)
        status = ++d->n_looked_at > MOST_LOOKED_AT
                     ? xdmf_fail(d, element, "it is referred to too many times")
                     : add_named(d, c, name, list);
    return status;
}
