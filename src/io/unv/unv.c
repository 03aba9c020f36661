/* unv: universal files of I-DEAS, as Salome, Gmsh, FreeCAD and others write them.
 *
 * Datasets stand between lines of -1; their first line is a number that says what they are. A walk
 * finds them; then coordinate systems are read, nodes, elements and groups. Other datasets are passed
 * over, units (164) among them: lengths are the file's.
 */
#include "io/unv/unv_reader.h"

#include "io/core/format.h"
#include "io/core/number.h"

#include "base/memory.h"
#include "base/status.h"

const unv_dataset unv_datasets[] = {
    {2411, UNV_NODES, 0, 0, 0, 0},    {781, UNV_NODES, 0, 0, 0, 0},
    {15, UNV_NODE_LINES, 0, 0, 0, 0}, {2412, UNV_ELEMENTS, 6, 1, 2, 3},
    {780, UNV_ELEMENTS, 8, 1, 3, 5},  {71, UNV_REFUSED, 0, 0, 0, 0},
    {2417, UNV_GROUPS, 2, 0, 0, 0},   {2429, UNV_GROUPS, 2, 0, 0, 0},
    {2430, UNV_GROUPS, 2, 0, 0, 0},   {2432, UNV_GROUPS, 2, 0, 0, 0},
    {2435, UNV_GROUPS, 4, 0, 0, 0},   {2452, UNV_GROUPS, 4, 0, 0, 0},
    {2467, UNV_GROUPS, 4, 0, 0, 0},   {2477, UNV_GROUPS, 4, 0, 0, 0},
    {2420, UNV_SYSTEMS, 0, 0, 0, 0},  {18, UNV_OLD_SYSTEMS, 0, 0, 0, 0},
};

enum { N_DATASETS = sizeof unv_datasets / sizeof *unv_datasets };

/** Return whether a line is what parts datasets. */
static int is_mark(io_slice line) {
    return io_slice_is(io_slice_trim(line), "-1", 0);
}

/** Take the next line that is not empty. */
static io_slice take_line(io_cursor *cursor) {
    io_slice line = io_next_line(cursor);
    while (cursor->at < cursor->end && io_slice_length(io_slice_trim(line)) == 0)
        line = io_next_line(cursor);
    return line;
}

/** Find the end of a dataset: the mark behind it. *n_lines: those before it that are not empty. */
static int find_end(const unv_reader *r, io_cursor *cursor, int64_t number, int64_t *n_lines,
                    const char **end) {
    *n_lines = 0;
    while (cursor->at < cursor->end) {
        const io_slice line = io_next_line(cursor);
        *end = line.begin;
        const io_slice text = io_slice_trim(line);
        if (io_slice_is(text, "-1", 0))
            return PLANISH_OK;
        *n_lines += io_slice_length(text) > 0;
    }
    return io_fail_at(r->model, cursor->end, r->error,
                      "dataset %lld has no line of -1 behind it (the file may be cut short)",
                      (long long)number);
}

/** Find the datasets that are read. */
static int walk_file(unv_reader *r) {
    io_cursor cursor = io_begin_text(r->model->input.data, r->model->input.size);
    int status = PLANISH_OK;
    while (!status) {
        io_slice line = take_line(&cursor);
        if (io_slice_length(io_slice_trim(line)) == 0)
            break;
        if (!is_mark(line))
            return io_fail_at(r->model, line.begin, r->error,
                              "a line of -1 expected, which begins a dataset");
        line = take_line(&cursor);
        if (is_mark(line)) /* one too many, as some programs write them */
            line = take_line(&cursor);
        io_cursor text = {line.begin, line.end};
        int64_t number = 0, n_lines;
        int row = 0;
        const char *data = cursor.at, *end = data;
        io_integer(&text, &number);
        while (row < N_DATASETS && unv_datasets[row].number != number)
            row++;
        if (row < N_DATASETS && unv_datasets[row].kind == UNV_REFUSED)
            return io_fail_at(r->model, line.begin, r->error,
                              "elements of dataset %lld are not read; write them as 2412",
                              (long long)number);
        status = find_end(r, &cursor, number, &n_lines, &end);
        if (!status && row < N_DATASETS)
            status = io_sections_add(
                &r->sections,
                (io_section){.keyword = row, .count = n_lines, .data = data, .end = end}, r->error);
    }
    return status;
}

/** Call read for the datasets of a kind. */
static int read_datasets(unv_reader *r, unv_kind kind,
                         int (*read)(unv_reader *r, const io_section *s)) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->sections.n && !status; i++) {
        const io_section *s = &r->sections.section[i];
        r->dataset = &unv_datasets[s->keyword];
        if (r->dataset->kind == kind)
            status = read(r, s);
    }
    return status;
}

/* ---- the format ---------------------------------------------------------------------------- */

static int unv_read(io_model *model, planish_error *error) {
    unv_reader r = {.model = model, .error = error};
    model->node_order = unv_node_orders;
    io_text_init(&r.text, model);
    int status = walk_file(&r);
    if (!status)
        status = read_datasets(&r, UNV_SYSTEMS, unv_read_systems);
    if (!status)
        status = read_datasets(&r, UNV_OLD_SYSTEMS, unv_read_systems);
    if (!status)
        status = unv_read_nodes(&r);
    if (!status)
        status = read_datasets(&r, UNV_ELEMENTS, unv_find_runs);
    if (!status)
        status = unv_read_elements(&r);
    if (!status)
        status = unv_make_entities(&r);
    for (int dim = 1; dim <= 3; dim++)
        io_reduce_cell_numbers(io_model_cells(model, dim));
    io_text_release(&r.text);
    io_sections_release(&r.sections);
    io_sections_release(&r.runs);
    pl_free(r.run_dataset);
    pl_free(r.system);
    return status;
}

/** Recognise a line of -1 and a line that begins with the number of a dataset. */
static int unv_recognise(const char *data, int64_t size) {
    enum { MOST_NUMBER = 99999 };
    io_cursor cursor = io_begin_text(data, size);
    int64_t number;
    if (!is_mark(take_line(&cursor)))
        return 0;
    const io_slice line = take_line(&cursor);
    io_cursor text = {line.begin, line.end};
    const io_slice word = io_next_word(&text);
    const char *at = word.begin;
    return io_parse_integer(&at, word.end, &number) == 0 && number > 0 && number <= MOST_NUMBER &&
           (at == word.end || io_slice_is((io_slice){at, word.end}, "b", 1));
}

static const char *const extensions[] = {".unv", ".uff", NULL};

const io_format io_format_unv = {.name = "unv",
                                 .extensions = extensions,
                                 .recognise = unv_recognise,
                                 .read = unv_read,
                                 .field = unv_field};
