/* su2: meshes of SU2, of two and three dimensions.
 *
 * Lines KEY= VALUE, some with a count and that many lines behind them; '%' begins a comment. A walk
 * finds the sections; then points are read, then elements, then markers. A line of NELEM is the
 * number of a type (VTK's), its nodes and perhaps its number; a line of NPOIN two or three
 * coordinates and perhaps a number. Points and elements are counted from 0 in the order of the file:
 * SU2 does not look at the numbers. Zones (NZONE, IZONE) are meshes of their own, whose points and
 * elements are counted on through the file here. A marker (MARKER_TAG, MARKER_ELEMS) is a named group
 * of lines, or of facets in three dimensions. Keys that are not known here are passed over.
 */
#include "io/core/format.h"
#include "io/core/runs.h"

#include "base/memory.h"
#include "base/status.h"

enum { MOST_NODES = 27, MOST_TYPE = 29 };

/** Types by their numbers, which are VTK's, as are the orders of nodes. SU2 has those of first order
 *  alone. */
static const io_element_type types[MOST_TYPE + 1] = {
    [1] = {"point", IO_POINT, 1, 1},
    [3] = {"line", IO_LINE, 1, 2},
    [5] = {"triangle", IO_TRIANGLE, 1, 3},
    [9] = {"quadrilateral", IO_QUADRILATERAL, 1, 4},
    [10] = {"tetrahedron", IO_TETRAHEDRON, 1, 4},
    [12] = {"hexahedron", IO_HEXAHEDRON, 1, 8},
    [13] = {"prism", IO_PRISM, 1, 6},
    [14] = {"pyramid", IO_PYRAMID, 1, 5},
};

typedef enum su2_kind {
    DIMENSION,
    ZONES,
    ZONE,
    POINTS,
    ELEMENTS,
    MARKER,
    MARKER_ELEMENTS,
    HALO /* between MARKER_ELEMS and its lines */
} su2_kind;

static const struct {
    const char *name;
    su2_kind kind;
} keys[] = {{"NDIME", DIMENSION},
            {"NZONE", ZONES},
            {"IZONE", ZONE},
            {"NPOIN", POINTS},
            {"NELEM", ELEMENTS},
            {"MARKER_TAG", MARKER},
            {"MARKER_ELEMS", MARKER_ELEMENTS},
            {"SEND_RECV", HALO},
            {"SEND_TO", HALO}};

enum { N_KEYS = sizeof keys / sizeof *keys };

/** Points of a zone, one after another. */
typedef struct su2_zone {
    int64_t first, n;
} su2_zone;

/** A section of lines: points or elements. */
typedef struct su2_section {
    int is_points;
    int64_t marker; /* whose elements they are; 0: the mesh's */
    int64_t zone;   /* from 0 */
    io_section lines;
} su2_section;

typedef struct su2_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    int64_t dim, n_zones, zone; /* 0 so far; zone: the number of IZONE that have been met */
    int has_points;             /* of the zone that is walked over */
    su2_zone *points;           /* [zone or 1] owned: of each zone */
    su2_section *section;       /* [n_sections] owned, in the file's order */
    int64_t n_sections, section_capacity;
    io_slice *marker; /* [n_markers] owned: names, borrowed, by number from 1 */
    int64_t n_markers, marker_capacity;
    int is_marker_open;   /* a name whose elements have not been met */
    int64_t n_elements;   /* that have been read */
    int64_t first, n;     /* node of the zone that is read, and how many it has */
    io_run run;           /* that is read */
    int32_t tag;          /* of its elements, */
    int64_t first_number; /* and the number of the first of them */
    int has_numbers;      /* behind the nodes */
} su2_reader;

/* ---- the walk over the file ----------------------------------------------------------------- */

/** Split a line at its '='; return 0 where it is none such. */
static int split_line(io_slice line, io_slice *key, io_slice *value) {
    const char *mark = memchr(line.begin, '=', (size_t)io_slice_length(line));
    if (!mark)
        return 0;
    const char *comment = memchr(mark, '%', (size_t)(line.end - mark));
    *key = io_slice_trim((io_slice){line.begin, mark});
    *value = io_slice_trim((io_slice){mark + 1, comment ? comment : line.end});
    return 1;
}

/** Read the whole number that a value begins with. */
static int take_count(const su2_reader *r, io_slice key, io_slice value, int64_t *count) {
    io_cursor cursor = {value.begin, value.end};
    if (io_integer(&cursor, count) == 0 && *count >= 0)
        return PLANISH_OK;
    return io_fail_at(r->model, value.begin, r->error, "%.*s: a count expected", IO_QUOTED(key));
}

/** Note the name of a marker, whose elements are to come: those of MARKER_ELEMS. */
static int note_marker(su2_reader *r, io_slice name) {
    r->is_marker_open = 1;
    if (r->n_markers == INT32_MAX)
        return io_fail_at(r->model, name.begin, r->error, "too many markers");
    return pl_append(&r->marker, &r->n_markers, &r->marker_capacity, &name, sizeof name)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the markers of the file");
}

static int note_dimension(su2_reader *r, io_slice value, int64_t dim) {
    if ((dim != 2 && dim != 3) || (r->dim && r->dim != dim))
        return io_fail_at(r->model, value.begin, r->error,
                          "NDIME= %lld: one dimension of 2 or 3 expected", (long long)dim);
    r->dim = dim;
    return PLANISH_OK;
}

/** Note a section of count lines, the next of which is at rest. */
static int note_section(su2_reader *r, io_slice key, su2_kind kind, io_cursor rest, int64_t count) {
    const su2_section section = {.is_points = kind == POINTS,
                                 .marker = kind == MARKER_ELEMENTS ? r->n_markers : 0,
                                 .zone = r->zone > 0 ? r->zone - 1 : 0,
                                 .lines = {.count = count, .data = rest.at, .end = rest.end}};
    if (section.is_points && r->has_points)
        return io_fail_at(r->model, key.begin, r->error, "NPOIN for the second time");
    r->has_points |= section.is_points;
    if (kind == MARKER_ELEMENTS && !r->is_marker_open)
        return io_fail_at(r->model, key.begin, r->error, "MARKER_ELEMS without MARKER_TAG");
    if (kind == MARKER_ELEMENTS)
        r->is_marker_open = 0;
    const int status = io_check_count(r->model, rest, count, 2 * 2,
                                      section.is_points ? "points" : "elements", r->error);
    if (status)
        return status;
    return pl_append(&r->section, &r->n_sections, &r->section_capacity, &section, sizeof section)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the sections of the file");
}

/** Understand a line KEY= VALUE; rest: behind it. */
static int read_key(su2_reader *r, su2_kind kind, io_slice key, io_slice value, io_cursor rest) {
    int64_t count = 0;
    if (kind == MARKER)
        return note_marker(r, value);
    const int status = take_count(r, key, value, &count);
    if (status)
        return status;
    switch (kind) {
    case DIMENSION:
        return note_dimension(r, value, count);
    case ZONES:
        r->n_zones = count;
        return PLANISH_OK;
    case ZONE:
        r->has_points &= r->zone == 0; /* what stands before the first is of that */
        return ++r->zone == count
                   ? PLANISH_OK
                   : io_fail_at(r->model, value.begin, r->error, "IZONE= %lld: zone %lld expected",
                                (long long)count, (long long)r->zone);
    default:
        return note_section(r, key, kind, rest, count);
    }
}

/** Find the sections: lines with a '=' that begin with a letter end one. */
static int walk_file(su2_reader *r) {
    io_cursor cursor = io_begin_text(r->model->input.data, r->model->input.size);
    int status = PLANISH_OK, is_open = 0; /* the last section has not ended */
    while (cursor.at < cursor.end && !status) {
        const io_slice line = io_slice_trim(io_next_line(&cursor));
        const char first = line.begin < line.end ? io_upper(*line.begin) : '\0';
        io_slice key, value;
        int i = 0;
        if (first < 'A' || first > 'Z' || !split_line(line, &key, &value))
            continue;
        while (i < N_KEYS && !io_slice_is(key, keys[i].name, 0))
            i++;
        if (is_open && i < N_KEYS && keys[i].kind == HALO) {
            r->section[r->n_sections - 1].lines.data = cursor.at;
            continue;
        }
        if (is_open)
            r->section[r->n_sections - 1].lines.end = line.begin;
        const int64_t n = r->n_sections;
        if (i < N_KEYS && keys[i].kind != HALO)
            status = read_key(r, keys[i].kind, key, value, cursor);
        is_open = r->n_sections > n;
    }
    if (!status && r->n_zones > 1 && r->zone != r->n_zones)
        status = io_fail_at(r->model, cursor.end, r->error,
                            "zone %lld of %lld expected (the file may be cut short)",
                            (long long)r->zone + 1, (long long)r->n_zones);
    return status;
}

/* ---- points --------------------------------------------------------------------------------- */

/** Count the words of the first line of a section. */
static int64_t count_words(const io_section *s) {
    io_cursor cursor = {s->data, s->end};
    io_skip_space_comments(&cursor, '%');
    io_cursor line = io_take_line(&cursor);
    int64_t n = 0;
    while (io_slice_length(io_next_word(&line)) > 0)
        n++;
    return n;
}

/** Read points, each in a line of its own, in which a number may follow. */
static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const su2_reader *r = context;
    for (int64_t i = r->first + begin; i < r->first + end; i++) {
        io_skip_space_comments(cursor, '%');
        io_cursor line = io_take_line(cursor);
        int64_t number;
        int status = io_read_node(r->model, &line, i, error);
        io_skip_space(&line);
        if (!status && line.at < line.end && *line.at != '%' && io_integer(&line, &number))
            status = io_fail_at(r->model, line.at, error,
                                "point %lld: %d coordinates and perhaps a number expected",
                                (long long)i, r->model->columns);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Find where the points of each zone begin, and how many there are: *n in all. */
static int find_points(su2_reader *r, int64_t *n) {
    *n = 0;
    r->points = pl_alloc_zero(r->zone + 1, sizeof *r->points);
    if (!r->points)
        return pl_fail_memory(r->error, "the zones of the file");
    for (int64_t i = 0; i < r->n_sections; i++) {
        const su2_section *s = &r->section[i];
        if (!s->is_points)
            continue;
        r->points[s->zone] = (su2_zone){*n, s->lines.count};
        *n += s->lines.count;
    }
    return PLANISH_OK;
}

/** Read the points of all zones, one after the other. */
static int read_all_points(su2_reader *r) {
    io_model *model = r->model;
    int64_t n;
    int status = find_points(r, &n);
    if (!status && (!r->dim || n == 0))
        return io_fail_at(model, io_input_end(model), r->error,
                          "there is no %s (the file may be cut short)", r->dim ? "NPOIN" : "NDIME");
    model->columns = (int)r->dim;
    const io_cursor all = io_begin_text(model->input.data, model->input.size);
    if (!status) /* of one zone they may be in the file, but not those of all */
        status = io_check_count(model, all, n, 2 * 2, "points", r->error);
    if (!status)
        status = io_model_make_nodes(model, n, 8, 0, 0, NULL, r->error);
    r->first = 0;
    for (int64_t i = 0; i < r->n_sections && !status; i++) {
        const io_section *s = &r->section[i].lines;
        if (!r->section[i].is_points)
            continue;
        const int64_t words = count_words(s);
        status = io_section_records(&r->text, s, "points", words > r->dim ? words : r->dim, 0,
                                    read_points, r, r->error);
        r->first += s->count;
    }
    return status;
}

/* ---- elements ------------------------------------------------------------------------------- */

/** Find the runs of elements of one type, with numbers or without, in a section. */
static int find_runs(const su2_reader *r, const io_section *s, io_sections *runs) {
    const io_model *model = r->model;
    io_cursor cursor = {s->data, s->end};
    int status = PLANISH_OK;
    for (int64_t i = 0; i < s->count && !status; i++) {
        io_skip_space_comments(&cursor, '%');
        const char *at = cursor.at;
        io_cursor line = io_take_line(&cursor);
        int64_t type;
        if (io_integer(&line, &type))
            return io_fail_at(model, at, r->error,
                              "element %lld of %lld: the number of its type expected (the file may "
                              "be cut short)",
                              (long long)i + 1, (long long)s->count);
        if (type > MOST_TYPE)
            return io_fail_at(model, at, r->error,
                              "element %lld: type %lld, of high order, is not read", (long long)i,
                              (long long)type);
        if (type < 0 || !types[type].name)
            return io_fail_at(model, at, r->error, "element %lld: SU2 has no type %lld",
                              (long long)i, (long long)type);
        const int n = types[type].nodes;
        /* Behind the node of a point of SEND_RECEIVE stands the number of a rotation. */
        int64_t words = 1;
        while (words <= 1 + n && io_slice_length(io_next_word(&line)) > 0)
            words++;
        status =
            io_runs_add(runs, (int)type, words > 1 + n ? 2 + n : 1 + n, at, cursor.at, r->error);
    }
    return status;
}

/** Read the elements of a run, each in a line of its own. */
static int read_run(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                    planish_error *error) {
    const su2_reader *r = context;
    const io_element_type *type = r->run.row;
    for (int64_t i = begin; i < end; i++) {
        const int64_t number = r->first_number + i;
        int64_t value;
        int32_t nodes[MOST_NODES];
        io_skip_space_comments(cursor, '%');
        const char *at = cursor->at;
        io_cursor line = io_take_line(cursor);
        if (io_integer(&line, &value) || value < 0 || value > MOST_TYPE || &types[value] != type)
            return io_fail_at(r->model, at, error, "element %lld: type of a %s expected",
                              (long long)number, type->name);
        for (int k = 0; k < type->nodes; k++) {
            if (io_integer(&line, &value))
                return io_fail_at(r->model, line.at, error,
                                  "element %lld: a %s has %d nodes in one line (the file may be "
                                  "cut short)",
                                  (long long)number, type->name, (int)type->nodes);
            if (value < 0 || value >= r->n)
                return io_fail_no_node(r->model, at, "element", number, value, error);
            nodes[k] = (int32_t)(r->first + value);
        }
        if (r->has_numbers && io_integer(&line, &value))
            return io_fail_at(r->model, line.at, error,
                              "element %lld: a whole number expected behind the nodes",
                              (long long)number);
        io_skip_space(&line);
        if (line.at < line.end && *line.at != '%')
            return io_fail_at(r->model, line.at, error,
                              "element %lld: no more than a number may follow the %d nodes of a %s",
                              (long long)number, (int)type->nodes, type->name);
        io_run_set(&r->run, i, nodes, r->tag, number);
    }
    return PLANISH_OK;
}

/** Read the elements of a section: of the mesh, whose zones are regions, or of a marker. */
static int read_section(su2_reader *r, const su2_section *section) {
    const io_section *s = &section->lines;
    io_sections runs = {0};
    int status = find_runs(r, s, &runs);
    r->first = r->points[section->zone].first;
    r->n = r->points[section->zone].n;
    r->tag = (int32_t)(section->marker ? section->marker : -section->zone);
    r->first_number = section->marker ? 0 : r->n_elements;
    for (int64_t i = 0; i < runs.n && !status; i++) {
        const io_section *run = &runs.section[i];
        const io_element_type *type = &types[run->keyword];
        r->has_numbers = run->tokens > 1 + type->nodes;
        status = io_run_read(r->model, &r->text, run, type, read_run, r, &r->run, r->error);
        r->first_number += run->count;
    }
    if (!section->marker)
        r->n_elements += s->count;
    io_cursor rest = {runs.n > 0 ? runs.section[runs.n - 1].end : s->data, s->end};
    io_sections_release(&runs);
    io_skip_space_comments(&rest, '%');
    if (!status && rest.at < rest.end && (*rest.at < 'A' || *rest.at > 'z'))
        return io_fail_at(r->model, rest.at, r->error, "more than %lld elements follow",
                          (long long)s->count);
    return status;
}

/** Make the groups of markers: of the dimensions that their elements have, which may be none. */
static int make_groups(su2_reader *r) {
    int status = PLANISH_OK;
    for (int32_t i = 0; i < r->n_markers && !status; i++) {
        const io_slice name = r->marker[i];
        const int32_t tag = i + 1;
        for (int dim = 1; dim <= 2 && !status; dim++)
            if (dim == r->dim - 1 || io_model_has_entity(r->model, dim, tag))
                status =
                    io_model_group(r->model, dim, tag, name.begin, io_slice_length(name), r->error);
    }
    return status;
}

/* ---- the format ----------------------------------------------------------------------------- */

static int su2_read(io_model *model, planish_error *error) {
    su2_reader r = {.model = model, .error = error};
    model->groups_by_name = 1;
    io_text_init(&r.text, model);
    r.text.comment = '%';
    int status = walk_file(&r);
    if (!status)
        status = read_all_points(&r);
    for (int64_t i = 0; i < r.n_sections && !status; i++)
        if (!r.section[i].is_points)
            status = read_section(&r, &r.section[i]);
    if (!status && r.is_marker_open)
        status = io_fail_at(model, io_input_end(model), error,
                            "the last MARKER_TAG has no MARKER_ELEMS (the file may be cut short)");
    if (!status)
        status = io_runs_index_tags(model, error);
    if (!status)
        status = make_groups(&r);
    io_text_release(&r.text);
    pl_free(r.section);
    pl_free(r.points);
    pl_free(r.marker);
    return status;
}

/** Recognise NDIME= or NZONE= in the first line that is no comment. */
static int su2_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space_comments(&cursor, '%');
    io_slice key, value;
    if (!split_line(io_next_line(&cursor), &key, &value))
        return 0;
    for (int i = 0; i < N_KEYS; i++)
        if (io_slice_is(key, keys[i].name, 0))
            return 1;
    return 0;
}

static const char *const extensions[] = {".su2", NULL};

const io_format io_format_su2 = {.name = "su2",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = su2_recognise,
                                 .read = su2_read};
