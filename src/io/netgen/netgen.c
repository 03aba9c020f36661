/* netgen: Netgen's meshes, .vol, of two and three dimensions.
 *
 * Keywords, each with a count and that many records of words apart by white space; '#' begins a
 * comment between them. A walk finds the sections; then points are read, then elements, segments,
 * and what holds nodes. Unknown sections are passed over, as Netgen does, and behind endmesh is
 * geometry that nobody looks at here.
 *
 * A group is: of volume elements the material; of triangles the boundary condition (in two
 * dimensions the domain, which is where materials are), of segments the edge (in two dimensions the
 * boundary condition).
 */
#include "io/core/format.h"
#include "io/netgen/netgen.h"

#include "base/memory.h"
#include "base/status.h"

/* ---- keywords ----------------------------------------------------------------------------- */

static const netgen_keyword keywords[] = {
    {"points", NETGEN_POINTS, 3, 0, 0, 0, {0}},
    {"surfaceelements", NETGEN_ELEMENTS, 5, 1, 0, 2, {0}},
    {"surfaceelementsgi", NETGEN_ELEMENTS, 5, 1, 1, 2, {0}},
    {"surfaceelementsuv", NETGEN_ELEMENTS, 5, 1, 2, 2, {1}},
    {"volumeelements", NETGEN_ELEMENTS, 2, 0, 0, 3, {0}},
    {"edgesegments", NETGEN_SEGMENTS, 4, 0, 0, 2, {0}},
    {"edgesegmentsgi", NETGEN_SEGMENTS, 6, 0, 0, 2, {0}},
    {"edgesegmentsgi2", NETGEN_SEGMENTS, 12, 8, 0, 2, {9, 11}}, /* of two dimensions: 0 */
    {"edgesegmentsgi3", NETGEN_SEGMENTS, 7, 6, 0, 0, {4, 5}},
    {"pointelements", NETGEN_POINT_ELEMENTS, 2, 0, 0, 0, {0}},
    {"identifications", NETGEN_PAIRS, 3, 0, 0, 0, {0}},
    {"identificationtypes", NETGEN_PAIR_TYPES, 1, 0, 0, 0, {0}},
    {"singular_points", NETGEN_SINGULAR_POINTS, 2, 0, 0, 0, {0}},
    {"singular_edge_left", NETGEN_SINGULAR_SEGMENTS, 2, 0, 0, 0, {0}},
    {"singular_edge_right", NETGEN_SINGULAR_SEGMENTS, 2, 0, 0, 0, {0}},
    {"materials", NETGEN_NAMES, 1, 0, 0, 0, {0}},
    {"bcnames", NETGEN_NAMES, 1, 1, 0, 0, {0}},
    {"cd2names", NETGEN_NAMES, 1, 2, 0, 0, {0}},
    {"cd3names", NETGEN_NAMES, 1, 3, 0, 0, {0}},
    {"identificationnames", NETGEN_LINES, 1, 0, 0, 0, {0}},
    {"edgedescriptors", NETGEN_LINES, 1, 0, 0, 0, {0}},
    {"curvedelements", NETGEN_REFUSED, 0, 0, 0, 0, {0}},
};

static const netgen_keyword *find_keyword(const char *word, int64_t length) {
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++)
        if (io_word_is(word, length, keywords[i].name, 0))
            return &keywords[i];
    return NULL;
}

/* ---- the sections of a file --------------------------------------------------------------- */

static int take_number(netgen_reader *r, io_cursor *cursor, const char *name, int64_t *value) {
    if (io_integer(cursor, value))
        return io_fail_at(r->model, cursor->at, r->error, "a whole number expected after %s", name);
    return PLANISH_OK;
}

/** The count of a section; as many records can be in what is left of the file. */
static int take_count(netgen_reader *r, io_cursor *cursor, const netgen_keyword *k,
                      int64_t *count) {
    const int64_t words = k->words + (k->kind == NETGEN_ELEMENTS ? NETGEN_LEAST_CORNERS : 0);
    const int64_t least = k->kind == NETGEN_LINES ? 1 : 2 * words; /* lines may be empty */
    int status = take_number(r, cursor, k->name, count);
    if (!status && (*count < 0 || *count > (io_left(cursor) + 1) / least))
        return io_fail_at(r->model, cursor->at, r->error,
                          "%lld %s cannot be in the %lld bytes that are left; the count is wrong "
                          "or the file is cut short",
                          (long long)*count, k->name, (long long)io_left(cursor));
    return status;
}

/** The rest of the line as the name of group number of codimension. */
static int take_name(netgen_reader *r, io_cursor *cursor, int codimension, int64_t number) {
    const char *begin = cursor->at, *end;
    io_skip_line(cursor);
    end = cursor->at;
    while (begin < end && io_is_blank(*begin))
        begin++;
    while (end > begin && (io_is_blank(end[-1]) || end[-1] == '\n' || end[-1] == '\r'))
        end--;
    if (begin == end || codimension > r->dim)
        return PLANISH_OK;
    if (number < INT32_MIN || number > INT32_MAX)
        return io_fail_at(r->model, begin, r->error, "number %lld of a name is out of range",
                          (long long)number);
    return io_model_group(r->model, r->dim - codimension, (int32_t)number, begin, end - begin,
                          r->error);
}

/** Names may be anything, keywords as well: lines are counted. */
static int read_lines(netgen_reader *r, io_cursor *cursor, const netgen_keyword *k) {
    int64_t count = 0, number;
    int status = take_count(r, cursor, k, &count);
    if (k->kind == NETGEN_LINES)
        io_skip_line(cursor); /* that of the count */
    for (int64_t i = 0; i < count && !status; i++) {
        if (k->kind == NETGEN_NAMES)
            io_skip_space(cursor);
        if (cursor->at == cursor->end || (k->kind == NETGEN_NAMES && io_integer(cursor, &number)))
            return io_fail_at(r->model, cursor->at, r->error,
                              "%s: line %lld of %lld expected%s (the file may be cut short)",
                              k->name, (long long)i + 1, (long long)count,
                              k->kind == NETGEN_NAMES ? ", which begins with a number" : "");
        if (k->kind == NETGEN_NAMES)
            status = take_name(r, cursor, k->group, number);
        else
            io_skip_line(cursor);
    }
    return status;
}

static int add_section(netgen_reader *r, io_cursor *cursor, const netgen_keyword *k) {
    int64_t count;
    int status = take_count(r, cursor, k, &count);
    if (status)
        return status;
    netgen_section *grown =
        pl_grow(r->sections, r->n_sections, r->n_sections + 1, &r->capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the sections of the file");
    const char *data = cursor->at;
    io_skip_numbers(cursor);
    r->sections = grown;
    r->sections[r->n_sections++] = (netgen_section){k, count, data, cursor->at};
    return PLANISH_OK;
}

static int read_dimension(netgen_reader *r, io_cursor *cursor) {
    int64_t dim;
    int status = take_number(r, cursor, "dimension", &dim);
    if (!status && dim != 2 && dim != 3)
        return io_fail_at(r->model, cursor->at, r->error,
                          "dimension %lld: only meshes of 2 or 3 dimensions can be smoothed",
                          (long long)dim);
    r->dim = (int)dim;
    return status;
}

static int read_keyword(netgen_reader *r, io_cursor *cursor, const char *word, int64_t length) {
    const netgen_keyword *k = find_keyword(word, length);
    r->last = k;
    if (io_word_is(word, length, "dimension", 0))
        return read_dimension(r, cursor);
    if (!k) {
        io_skip_numbers(cursor);
        return PLANISH_OK;
    }
    if (k->kind == NETGEN_REFUSED)
        return io_fail_at(r->model, word, r->error,
                          "%s: curved elements cannot be smoothed; save the mesh before Curve()",
                          k->name);
    return k->kind == NETGEN_NAMES || k->kind == NETGEN_LINES ? read_lines(r, cursor, k)
                                                              : add_section(r, cursor, k);
}

/** Whether the file may end here without endmesh: behind a section whose records are counted, at
 * the end of a line. Netgen reads such a file as whole, too. */
static int may_end(const netgen_reader *r) {
    const io_bytes *input = &r->model->input;
    const char last = input->size > 0 ? input->data[input->size - 1] : '\0';
    return r->last && (last == '\n' || last == '\r');
}

static int walk_file(netgen_reader *r) {
    io_cursor cursor = io_begin_text(r->model->input.data, r->model->input.size);
    int status = PLANISH_OK;
    for (int is_first = 1; !status; is_first = 0) {
        int64_t length;
        io_skip_space_comments(&cursor, '#');
        const char *word = io_word(&cursor, &length);
        if (is_first && !io_word_is(word, length, "mesh3d", 0))
            return io_fail_at(r->model, word, r->error,
                              "no mesh3d in the first line: this is no mesh of Netgen's");
        if (io_word_is(word, length, "endmesh", 0) || (length == 0 && may_end(r)))
            break;
        if (length == 0)
            return io_fail_at(r->model, word, r->error,
                              "there is no endmesh (the file may be cut short)");
        if (!is_first)
            status = read_keyword(r, &cursor, word, length);
    }
    return status;
}

/** The sections of one kind, which may be anywhere in the file. */
static int read_sections(netgen_reader *r, netgen_kind wanted) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        if (r->sections[i].keyword->kind == wanted)
            status = netgen_read_section(r, &r->sections[i]);
    return status;
}

static int read_all(netgen_reader *r) {
    int status = walk_file(r);
    if (!status)
        status = read_sections(r, NETGEN_POINTS);
    if (!status && !r->model->xyz)
        return io_fail_at(r->model, r->model->input.data + r->model->input.size, r->error,
                          "there are no points (the file may be cut short)");
    for (netgen_kind k = NETGEN_ELEMENTS; k < NETGEN_N_READ && !status; k++)
        status = read_sections(r, k);
    return status;
}

static int read_netgen(io_model *model, planish_error *error) {
    netgen_reader r = {.model = model, .error = error, .dim = 3};
    io_text_init(&r.text, model);
    int status = read_all(&r);
    io_text_release(&r.text);
    pl_free(r.is_periodic);
    pl_free(r.sections);
    return status;
}

static int recognise_netgen(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    int64_t length;
    io_skip_space_comments(&cursor, '#');
    const char *word = io_word(&cursor, &length);
    return io_word_is(word, length, "mesh3d", 0);
}

static const char *const extensions[] = {".vol", NULL};

const io_format io_format_netgen = {
    .name = "netgen", .extensions = extensions, .recognise = recognise_netgen, .read = read_netgen};
