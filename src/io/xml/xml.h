/* xml: the markup of XML files, by Expat, for the readers of formats in XML.
 *
 *   io_xml, io_xml_read                      walk over the elements of a file
 *   io_xml_attribute, _whole, _is            attributes of the element that begins
 *   io_xml_find_value                        the place of one in its tag
 *   io_xml_take_text                         text that Expat is not given
 *   io_xml_stop, io_xml_fail                 end the walk
 *
 * Expat gets the file in pieces, without the text of elements whose visitor asks for that: from
 * behind a start tag to the next '<' there are only numbers. So gigabytes of numbers are not looked
 * at twice. Entities are refused, and no other file is opened for a document type.
 */
#ifndef PL_IO_XML_XML_H
#define PL_IO_XML_XML_H

#include "io/core/text.h"

typedef struct io_xml io_xml;

/** Take an element that begins or ends. A status; not 0 ends the walk. */
typedef int io_xml_take(io_xml *xml, const char *name);

/** A walk over the markup of a file. The reader sets the fields above the line. */
struct io_xml {
    const io_model *model; /* whose input is read */
    planish_error *error;
    io_xml_take *begin, *end;
    void *user;
    const char *format;   /* for messages: "VTU" */
    int may_have_doctype; /* a document type may be declared, without entities */
    /* ---- */
    const char **attributes;    /* of the element that begins: name, value, ..., NULL */
    int64_t tag_begin, tag_end; /* of the element that begins or ends: bytes of the file */
    void *parser;
    int status, is_over;
    int64_t text_end; /* of the text that Expat is not given, */
    int64_t skipped;  /* bytes that it was not given until now */
};

/** Walk over all elements of the input. Errors: _FORMAT, _MEMORY, those of the functions, and that
 *  planish was built without Expat. */
int io_xml_read(io_xml *xml);

/** Return the attribute called name, or NULL. */
const char *io_xml_attribute(const io_xml *xml, const char *name);

/** Return whether there is a text and it is that one. */
int io_xml_is(const char *text, const char *other);

/** Return the whole number that text is, at least 0, else -1. */
int64_t io_xml_whole(const char *text);

/** Find where the value of an attribute stands in the tag; -1: nowhere. */
void io_xml_find_value(const io_xml *xml, const char *name, int64_t *begin, int64_t *end);

/** Let the text from here, behind a tag, to the next '<' or the end be passed over: its bytes. */
void io_xml_take_text(io_xml *xml, int64_t *begin, int64_t *end);

/** Skip control characters and blanks from byte at on, up to end. */
int64_t io_xml_skip_blank(const io_xml *xml, int64_t at, int64_t end);

/** Read nothing more: the rest is no XML, or does not matter. */
void io_xml_stop(io_xml *xml);

/** Fail at the tag. */
int io_xml_fail(const io_xml *xml, const char *text);

#endif
