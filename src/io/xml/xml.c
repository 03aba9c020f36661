/* xml: the markup of XML files, by Expat. */
#include "io/xml/xml.h"

#include "base/status.h"

#include <string.h>

/* ---- places and failures ------------------------------------------------------------------- */

int io_xml_fail(const io_xml *xml, const char *text) {
    return io_fail_at(xml->model, xml->model->input.data + xml->tag_begin, xml->error, "%s", text);
}

void io_xml_stop(io_xml *xml) {
    xml->is_over = 1;
}

void io_xml_take_text(io_xml *xml, int64_t *begin, int64_t *end) {
    const io_bytes *input = &xml->model->input;
    *begin = xml->tag_end;
    const char *at = *begin < input->size
                         ? memchr(input->data + *begin, '<', (size_t)(input->size - *begin))
                         : NULL;
    *end = xml->text_end = at ? at - input->data : input->size;
}

int64_t io_xml_skip_blank(const io_xml *xml, int64_t at, int64_t end) {
    while (at < end && (unsigned char)xml->model->input.data[at] <= ' ')
        at++;
    return at;
}

/* ---- attributes ---------------------------------------------------------------------------- */

const char *io_xml_attribute(const io_xml *xml, const char *name) {
    for (int i = 0; xml->attributes[i]; i += 2)
        if (strcmp(xml->attributes[i], name) == 0)
            return xml->attributes[i + 1];
    return NULL;
}

int io_xml_is(const char *text, const char *other) {
    return text && strcmp(text, other) == 0;
}

int64_t io_xml_whole(const char *text) {
    int64_t value;
    io_cursor cursor = {text, text ? text + strlen(text) : text};
    if (!text || io_integer(&cursor, &value))
        return -1;
    io_skip_space(&cursor);
    return cursor.at == cursor.end && value >= 0 ? value : -1;
}

/* Expat has seen that the tag is well formed. */
void io_xml_find_value(const io_xml *xml, const char *name, int64_t *value_begin,
                       int64_t *value_end) {
    const char *data = xml->model->input.data;
    const char *at = data + xml->tag_begin, *end = data + xml->tag_end;
    const size_t length = strlen(name);
    *value_begin = *value_end = -1;
    while (at < end) {
        const char *equals = memchr(at, '=', (size_t)(end - at));
        if (!equals)
            return;
        const char *last = equals, *quote = equals + 1;
        while (last > at && (unsigned char)last[-1] <= ' ')
            last--;
        while (quote < end && *quote != '"' && *quote != '\'')
            quote++;
        const char *close = quote < end ? memchr(quote + 1, *quote, (size_t)(end - quote - 1)) : 0;
        if (!close)
            return;
        if (last - at > (int64_t)length && memcmp(last - length, name, length) == 0 &&
            (unsigned char)last[-(int64_t)length - 1] <= ' ') {
            *value_begin = quote + 1 - data;
            *value_end = close - data;
            return;
        }
        at = close + 1;
    }
}

#ifndef PL_EXPAT

int io_xml_read(io_xml *xml) {
    return pl_fail(xml->error, PLANISH_ERROR_FORMAT,
                   "%s: this planish was built without Expat, which %s files need: install it "
                   "(Debian, Ubuntu: libexpat1-dev) and build again, or write the mesh as legacy "
                   ".vtk",
                   xml->model->input.path, xml->format);
}

#else

#include <expat.h>

enum { PIECE_BYTES = 1 << 16 };

/* ---- what Expat calls ---------------------------------------------------------------------- */

/** Note where the tag is that Expat is at. */
static void note_tag(io_xml *xml) {
    xml->tag_begin = XML_GetCurrentByteIndex(xml->parser) + xml->skipped;
    xml->tag_end = xml->tag_begin + XML_GetCurrentByteCount(xml->parser);
}

/** Go on, unless there is an error or the reader has all that it wants. */
static void go_on(io_xml *xml, int status) {
    xml->status = status;
    xml->is_over |= status != 0;
    if (xml->is_over)
        XML_StopParser(xml->parser, XML_FALSE);
}

static void XMLCALL on_start(void *data, const char *name, const char **attributes) {
    io_xml *xml = data;
    if (xml->is_over)
        return;
    note_tag(xml);
    xml->attributes = attributes;
    go_on(xml, xml->begin(xml, name));
}

static void XMLCALL on_end(void *data, const char *name) {
    io_xml *xml = data;
    if (xml->is_over)
        return;
    note_tag(xml);
    go_on(xml, xml->end(xml, name));
}

static void XMLCALL on_doctype(void *data, const char *name, const char *system, const char *public,
                               int has_subset) {
    io_xml *xml = data;
    (void)name, (void)system, (void)public, (void)has_subset;
    note_tag(xml);
    if (!xml->may_have_doctype)
        go_on(xml, io_xml_fail(xml, "a document type is declared; files of this format have "
                                    "none, and its entities are not read"));
}

static void fail_entity(io_xml *xml) {
    if (xml->is_over)
        return;
    note_tag(xml);
    go_on(xml, io_xml_fail(xml, "an entity is declared or used, which is not followed; put "
                                "the text that it stands for in its place"));
}

static void XMLCALL on_entity(void *data, const char *name, int is_parameter, const char *value,
                              int length, const char *base, const char *system, const char *public,
                              const char *notation) {
    (void)name, (void)is_parameter, (void)value, (void)length, (void)base, (void)system,
        (void)public, (void)notation;
    fail_entity(data);
}

static void XMLCALL on_skipped_entity(void *data, const char *name, int is_parameter) {
    (void)name;
    if (!is_parameter) /* the document type's own, which nobody reads */
        fail_entity(data);
}

/* ---- the walk ------------------------------------------------------------------------------ */

/** Fail with what Expat found wrong. */
static int fail_expat(const io_xml *xml) {
    const enum XML_Error code = XML_GetErrorCode(xml->parser);
    const io_bytes *input = &xml->model->input;
    if (code == XML_ERROR_NO_MEMORY)
        return pl_fail_memory(xml->error, "the markup of the file");
    int64_t at = XML_GetCurrentByteIndex(xml->parser) + xml->skipped;
    if (at < 0 || at > input->size)
        at = input->size;
    return io_fail_at(xml->model, input->data + at, xml->error,
                      "XML: %s (the file may be cut short)", XML_ErrorString(code));
}

/** Expat looks at bytes more than once: it is given a copy, which cannot change meanwhile. */
static enum XML_Status parse_copy(const io_xml *xml, const char *bytes, int size, int is_last) {
    if (size == 0)
        return XML_Parse(xml->parser, bytes, 0, is_last);
    void *copy = XML_GetBuffer(xml->parser, size);
    if (!copy)
        return XML_STATUS_ERROR;
    memcpy(copy, bytes, (size_t)size);
    return XML_ParseBuffer(xml->parser, size, is_last);
}

/** Give Expat the file, as far as the walk goes. */
static int feed_expat(io_xml *xml) {
    const io_bytes *input = &xml->model->input;
    int64_t at = 0;
    while (!xml->is_over) {
        if (at < xml->text_end) {
            xml->skipped += xml->text_end - at;
            at = xml->text_end;
        }
        const int64_t left = input->size - at;
        const int size = left < PIECE_BYTES ? (int)left : PIECE_BYTES;
        const enum XML_Status status = parse_copy(xml, input->data + at, size, size == left);
        if (status != XML_STATUS_OK && !xml->is_over)
            return fail_expat(xml);
        at += size;
        if (size == left)
            break;
    }
    return xml->status;
}

int io_xml_read(io_xml *xml) {
    xml->parser = XML_ParserCreate(NULL);
    if (!xml->parser)
        return pl_fail_memory(xml->error, "the markup of the file");
    XML_SetUserData(xml->parser, xml);
    XML_SetElementHandler(xml->parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(xml->parser, on_doctype);
    XML_SetEntityDeclHandler(xml->parser, on_entity);
    XML_SetSkippedEntityHandler(xml->parser, on_skipped_entity);
    const int status = feed_expat(xml);
    XML_ParserFree(xml->parser);
    return status;
}

#endif
