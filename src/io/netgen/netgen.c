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
 *
 * Elements of second order list the mids of their edges behind the corners. Curved elements of any
 * order (curvedelements) have their shape apart from the nodes, and are refused.
 */
#include "io/core/format.h"
#include "io/netgen/netgen_reader.h"

#include "base/memory.h"
#include "base/status.h"

/* ---- keywords ----------------------------------------------------------------------------- */

const netgen_keyword netgen_keywords[] = {
    {"points", NETGEN_POINTS, 0, 3, 0, 0, 0, {0}},
    {"surfaceelements", NETGEN_ELEMENTS, 2, 5, 1, 0, 0, {0}},
    {"surfaceelementsgi", NETGEN_ELEMENTS, 2, 5, 1, 1, 0, {0}},
    {"surfaceelementsuv", NETGEN_ELEMENTS, 2, 5, 1, 2, 0, {1}},
    {"volumeelements", NETGEN_ELEMENTS, 3, 2, 0, 0, 0, {0}},
    {"edgesegments", NETGEN_SEGMENTS, 1, 4, 0, 0, 2, {0}},
    {"edgesegmentsgi", NETGEN_SEGMENTS, 1, 6, 0, 0, 2, {0}},
    {"edgesegmentsgi2", NETGEN_SEGMENTS, 1, 12, 8, 0, 2, {9, 11}}, /* of two dimensions: 0 */
    {"edgesegmentsgi3", NETGEN_SEGMENTS, 1, 7, 6, 0, 0, {4, 5}},
    {"pointelements", NETGEN_POINT_ELEMENTS, 0, 2, 0, 0, 0, {0}},
    {"identifications", NETGEN_PAIRS, 0, 3, 0, 0, 0, {0}},
    {"identificationtypes", NETGEN_PAIR_TYPES, 0, 1, 0, 0, 0, {0}},
    {"singular_points", NETGEN_SINGULAR_POINTS, 0, 2, 0, 0, 0, {0}},
    {"singular_edge_left", NETGEN_SINGULAR_SEGMENTS, 0, 2, 0, 0, 0, {0}},
    {"singular_edge_right", NETGEN_SINGULAR_SEGMENTS, 0, 2, 0, 0, 0, {0}},
    {"materials", NETGEN_NAMES, 0, 1, 0, 0, 0, {0}},
    {"bcnames", NETGEN_NAMES, 0, 1, 1, 0, 0, {0}},
    {"cd2names", NETGEN_NAMES, 0, 1, 2, 0, 0, {0}},
    {"cd3names", NETGEN_NAMES, 0, 1, 3, 0, 0, {0}},
    {"identificationnames", NETGEN_LINES, 0, 1, 0, 0, 0, {0}},
    {"edgedescriptors", NETGEN_LINES, 0, 1, 0, 0, 0, {0}},
    {"curvedelements", NETGEN_REFUSED, 0, 0, 0, 0, 0, {0}},
};

enum { N_KEYWORDS = sizeof netgen_keywords / sizeof *netgen_keywords };

/* ---- the sections of a file --------------------------------------------------------------- */

/** Read count lines, which may be anything, keywords as well; NETGEN_NAMES: of a number and the
 *  name of the group of that number. */
static int read_lines(netgen_reader *r, io_cursor *cursor, const netgen_keyword *k, int64_t count) {
    const int has_names = k->kind == NETGEN_NAMES;
    int64_t number = 0;
    if (!has_names)
        io_skip_line(cursor); /* that of the count */
    for (int64_t i = 0; i < count; i++) {
        if (has_names)
            io_skip_space(cursor);
        if (cursor->at == cursor->end || (has_names && io_integer(cursor, &number)))
            return io_fail_at(r->model, cursor->at, r->error,
                              "%s: line %lld of %lld expected%s (the file may be cut short)",
                              k->name, (long long)i + 1, (long long)count,
                              has_names ? ", which begins with a number" : "");
        const io_slice name = io_slice_trim(io_next_line(cursor));
        const int dim = r->dim - k->group;
        if (!has_names || io_slice_length(name) == 0 || dim < 0)
            continue;
        if (number < INT32_MIN || number > INT32_MAX)
            return io_fail_at(r->model, name.begin, r->error,
                              "number %lld of a name is out of range", (long long)number);
        const int status = io_model_group(r->model, dim, (int32_t)number, name.begin,
                                          io_slice_length(name), r->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Read what follows a keyword, word, or pass over it; keyword: its row, N_KEYWORDS: none. */
static int read_keyword(netgen_reader *r, io_cursor *cursor, io_slice word, int keyword) {
    const io_model *model = r->model;
    const netgen_keyword *k = keyword < N_KEYWORDS ? &netgen_keywords[keyword] : NULL;
    const int is_dimension = io_slice_is(word, "dimension", 0);
    int64_t number;
    if (!k && !is_dimension) {
        io_skip_numbers(cursor);
        return PLANISH_OK;
    }
    if (k && k->kind == NETGEN_REFUSED)
        return io_fail_at(model, word.begin, r->error,
                          "%s: curved elements cannot be smoothed; save the mesh before Curve()",
                          k->name);
    if (io_integer(cursor, &number))
        return io_fail_at(model, cursor->at, r->error, "a whole number expected after %.*s",
                          (int)io_slice_length(word), word.begin);
    if (is_dimension && number != 2 && number != 3)
        return io_fail_at(model, cursor->at, r->error,
                          "dimension %lld: only meshes of 2 or 3 dimensions can be smoothed",
                          (long long)number);
    if (!k) {
        r->dim = (int)number;
        return PLANISH_OK;
    }
    const int64_t words = k->words + (k->kind == NETGEN_ELEMENTS ? NETGEN_LEAST_CORNERS : 0);
    const int64_t least = k->kind == NETGEN_LINES ? 1 : 2 * words; /* lines may be empty */
    const int status = io_check_count(model, *cursor, number, least, k->name, r->error);
    if (status)
        return status;
    if (k->kind == NETGEN_NAMES || k->kind == NETGEN_LINES)
        return read_lines(r, cursor, k, number);
    const char *data = cursor->at;
    io_skip_numbers(cursor);
    return io_sections_add(&r->sections, (io_section){keyword, number, data, cursor->at, 0},
                           r->error);
}

/** Find the sections. The file may end without endmesh behind a section whose records are counted,
 *  at the end of a line: Netgen reads such a file as whole, too. */
static int walk_file(netgen_reader *r) {
    const io_bytes *input = &r->model->input;
    const char last = input->size > 0 ? input->data[input->size - 1] : '\0';
    io_cursor cursor = io_begin_text(input->data, input->size);
    io_skip_space_comments(&cursor, '#');
    io_slice word = io_next_word(&cursor);
    if (!io_slice_is(word, "mesh3d", 0))
        return io_fail_at(r->model, word.begin, r->error,
                          "no mesh3d in the first line: this is not a mesh of Netgen");
    for (int keyword = N_KEYWORDS;;) {
        io_skip_space_comments(&cursor, '#');
        word = io_next_word(&cursor);
        if (io_slice_is(word, "endmesh", 0))
            return PLANISH_OK;
        if (io_slice_length(word) == 0) {
            if (keyword < N_KEYWORDS && (last == '\n' || last == '\r'))
                return PLANISH_OK;
            return io_fail_at(r->model, word.begin, r->error,
                              "there is no endmesh (the file may be cut short)");
        }
        for (keyword = 0; keyword < N_KEYWORDS; keyword++)
            if (io_slice_is(word, netgen_keywords[keyword].name, 0))
                break;
        const int status = read_keyword(r, &cursor, word, keyword);
        if (status)
            return status;
    }
}

/* ---- the format --------------------------------------------------------------------------- */

static int netgen_read(io_model *model, planish_error *error) {
    netgen_reader r = {.model = model, .error = error, .dim = 3};
    io_text_init(&r.text, model);
    model->node_order = netgen_node_orders;
    int status = walk_file(&r);
    for (int kind = 0; kind < NETGEN_N_READ && !status; kind++) {
        for (int64_t i = 0; i < r.sections.n && !status; i++)
            if (netgen_keywords[r.sections.section[i].keyword].kind == (netgen_kind)kind)
                status = netgen_read_section(&r, &r.sections.section[i]);
        if (!status && !model->xyz)
            status = io_fail_at(model, io_input_end(model), error,
                                "there are no points (the file may be cut short)");
    }
    if (!status && model->node_entity)
        status = io_model_index_tags_but(model, 0, 0, model->node_entity, model->n_nodes, error);
    io_reduce_cell_numbers(&model->triangle);
    io_reduce_cell_numbers(&model->tetrahedron);
    io_text_release(&r.text);
    pl_free(r.is_periodic);
    io_sections_release(&r.sections);
    return status;
}

static int netgen_recognise(const char *data, int64_t size) {
    return io_slice_is(io_first_word(data, size), "mesh3d", 0);
}

static const char *const extensions[] = {".vol", NULL};

const io_format io_format_netgen = {
    .name = "netgen", .extensions = extensions, .recognise = netgen_recognise, .read = netgen_read};
