/* xdmf_markup: the elements of an XDMF file, and those that it refers to.
 *
 *   xdmf_element, xdmf_document      all elements, as a tree
 *   xdmf_markup_read, _release       read it
 *   xdmf_is, xdmf_attribute, xdmf_text, xdmf_fail    questions to an element
 *   xdmf_children, xdmf_resolve      elements in an element, behind references and inclusions
 *
 * Names of elements and attributes may have any letter case. An element is an index, -1: none.
 */
#ifndef PL_IO_XDMF_XDMF_MARKUP_H
#define PL_IO_XDMF_XDMF_MARKUP_H

#include "base/printf.h"

#include "io/core/text.h"

typedef struct xdmf_element {
    int64_t parent, child, last,
        next;                         /* next: sibling; child, last: the first and last one in it */
    int64_t name;                     /* place in xdmf_document.text */
    int64_t attributes, n_attributes; /* of xdmf_document.attribute */
    int64_t tag, begin, end;          /* bytes of the file: its tag; its text before any markup, */
    int is_broken;                    /* without white space around it; markup stands among it */
} xdmf_element;

/** List of elements. */
typedef struct xdmf_list {
    int64_t *element; /* [n] owned */
    int64_t n, capacity;
} xdmf_list;

typedef struct xdmf_document {
    io_model
        view; /* of the file: its bytes, for errors and texts; and files that are read beside it */
    planish_error *error;
    xdmf_element *element; /* [n] owned, in the file's order; 0 is the outermost */
    int64_t n, capacity;
    int64_t *attribute; /* [n_attributes] owned: places of names and values in text, in turn */
    int64_t n_attributes, attribute_capacity;
    char *text; /* [n_text] owned: words, each with its '\0' */
    int64_t n_text, text_capacity;
    int64_t n_looked_at; /* elements, by paths and walks */
    int64_t open;        /* while it is read: the element that has begun last and not ended */
    char *last_path;     /* that was followed, and its elements; owned */
    xdmf_list last_found;
} xdmf_document;

/** Read the markup of model->input, which must stay. Release in any case. */
int xdmf_markup_read(const io_model *model, xdmf_document *document, planish_error *error);
void xdmf_markup_release(xdmf_document *document);

/** Return whether an element has that name. */
int xdmf_is(const xdmf_document *document, int64_t element, const char *name);

/** Return the value of an attribute, or NULL. */
const char *xdmf_attribute(const xdmf_document *document, int64_t element, const char *name);

/** Return the text of an element without white space around it. */
io_slice xdmf_text(const xdmf_document *document, int64_t element);

/** Fail at an element. */
int xdmf_fail(const xdmf_document *document, int64_t element, const char *format, ...)
    PL_PRINTF(3, 4);

/** List the elements called name in an element, and in those that are included or referred to there.
 *  The list is emptied first, and released by pl_free in any case. */
int xdmf_children(xdmf_document *document, int64_t element, const char *name, xdmf_list *list);

/** Find the element that an element with a Reference stands for: *found, itself without one. */
int xdmf_resolve(xdmf_document *document, int64_t element, int64_t *found);

#endif
