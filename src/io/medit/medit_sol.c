/* medit_sol: the solution at vertices that Medit's programs keep beside a mesh: sizes and metrics.
 *
 * A file of text (.sol) or binary (.solb) as Medit's meshes are (medit.c), with SolAtVertices: the number
 * of vertices, the number of solutions and the type of each, and for each vertex their reals. In binary
 * number and types have 32 bits in all versions. Read is the first solution that is a scalar or a symmetric
 * tensor, which stands as its lower triangle by rows; the others are passed over.
 */
#include "io/core/bytes.h"
#include "io/medit/medit_reader.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/status.h"

enum {
    WORD_SIZE = 4,
    SCALAR = 1, /* types of solutions */
    VECTOR,
    SYMMETRIC,
    MATRIX,
    MOST_SOLUTIONS = 1000 /* of libMeshb */
};

static const medit_keyword keyword = {{"SolAtVertices", IO_POINT, 1, 0}, 62, MEDIT_SOLUTION};

/** The solutions of vertices, and the one that is taken. */
typedef struct solution {
    medit_reader reader;
    int n_reals;      /* of a vertex, */
    int first, width; /* those that are taken; width 0: none yet */
    double *values;   /* [n][width] */
} solution;

/** Return the number of reals of a type of solutions; 0: there is no such type. */
static int reals_of(int64_t type, int dim) {
    return type == SCALAR      ? 1
           : type == VECTOR    ? dim
           : type == SYMMETRIC ? dim * (dim + 1) / 2
           : type == MATRIX    ? dim * dim
                               : 0;
}

/** Read the number of solutions and their types, behind which the section's data begin then. */
static int read_types(solution *s, io_section *section) {
    medit_reader *r = &s->reader;
    const io_record_kind kind = {r->model, "solution", r->model->is_binary ? WORD_SIZE : 0,
                                 r->swapped};
    io_cursor cursor = {section->data, section->end};
    int64_t n, type;
    int status = io_take_whole(&kind, &cursor, 0, 1, MOST_SOLUTIONS, &n, r->error);
    for (int64_t i = 0; !status && i < n; i++) {
        status = io_take_whole(&kind, &cursor, i + 1, SCALAR, MATRIX, &type, r->error);
        if (status)
            return status;
        const int n_reals = reals_of(type, r->dim);
        if (s->width == 0 && (type == SCALAR || type == SYMMETRIC)) {
            s->first = s->n_reals;
            s->width = n_reals;
        }
        s->n_reals += n_reals;
    }
    if (!status && s->width == 0)
        return io_fail_at(r->model, section->data, r->error,
                          "none of the solutions is a scalar (type 1) or a symmetric tensor (type "
                          "3), as sizes are");
    section->data = cursor.at;
    return status;
}

/** Take a real of text, behind comments, or binary. Return 0 or -1. */
static int take_real(const medit_reader *r, io_cursor *cursor, double *value) {
    if (!r->model->is_binary) {
        io_skip_space_comments(cursor, '#');
        return io_real(cursor, value);
    }
    *value = r->real_size == (int)sizeof(float) ? (double)io_load_f32(cursor->at, r->swapped)
                                                : io_load_f64(cursor->at, r->swapped);
    cursor->at += r->real_size;
    return 0;
}

static int read_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const solution *s = context;
    const io_model *model = s->reader.model;
    for (int64_t i = begin; i < end; i++) {
        for (int k = 0; k < s->n_reals; k++) {
            const int at = k - s->first;
            double value;
            if (take_real(&s->reader, cursor, &value))
                return io_fail_at(model, cursor->at, error,
                                  "SolAtVertices: a number expected for vertex %lld (the file may "
                                  "be cut short)",
                                  (long long)(i + 1));
            if (at < 0 || at >= s->width)
                continue;
            if (!isfinite(value))
                return io_fail_at(model, cursor->at, error,
                                  "SolAtVertices: the value of vertex %lld is not finite",
                                  (long long)(i + 1));
            s->values[i * s->width + at] = value;
        }
    }
    return PLANISH_OK;
}

/** Check that the solutions are of the mesh's dimension and vertices. */
static int check_mesh(const medit_reader *r, const io_section *section, int dim,
                      int64_t n_vertices) {
    if (r->dim < dim)
        return io_fail_at(r->model, section->data, r->error,
                          "Dimension is %d, and the mesh is in %d dimensions", r->dim, dim);
    if (section->count != n_vertices)
        return io_fail_at(r->model, section->data, r->error,
                          "there are solutions of %lld vertices, and the mesh has %lld nodes",
                          (long long)section->count, (long long)n_vertices);
    return PLANISH_OK;
}

/** Read the section to data, which the caller releases on failure. */
static int read_section(solution *s, io_section section, planish_data *data) {
    medit_reader *r = &s->reader;
    int status = read_types(s, &section);
    const int64_t size = (int64_t)s->n_reals * r->real_size;
    if (!status)
        status = io_check_count(r->model, (io_cursor){section.data, section.end}, section.count,
                                size, "solutions", r->error);
    if (status)
        return status;
    *data = (planish_data){.n_components = s->width, .n = section.count};
    data->values = s->values = pl_alloc(data->n * s->width, sizeof *data->values);
    if (!s->values)
        return pl_fail_memory(r->error, "the solution");
    return io_section_records(&r->text, &section, "solutions", s->n_reals, size, read_vertices, s,
                              r->error);
}

static int read_file(io_model *model, int dim, int64_t n_vertices, planish_data *data,
                     planish_error *error) {
    solution s = {
        .reader = {.model = model, .error = error, .keywords = &keyword, .n_keywords = 1}};
    medit_reader *r = &s.reader;
    int status = medit_find_sections(r);
    if (!status && r->sections.n == 0)
        status = io_fail_at(model, io_input_end(model), error,
                            "there is no SolAtVertices (the file may be cut short)");
    if (!status)
        status = check_mesh(r, &r->sections.section[0], dim, n_vertices);
    io_text_init(&r->text, model);
    if (!status)
        status = read_section(&s, r->sections.section[0], data);
    io_text_release(&r->text);
    io_sections_release(&r->sections);
    return status;
}

int planish_sol_read(const char *path, int dim, int64_t n_vertices, planish_data *data,
                     planish_error *error) {
    if (data)
        *data = (planish_data){.n = 0};
    if (!path || !data || (dim != 2 && dim != 3) || n_vertices < 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "path and data must not be NULL, dim must be 2 or 3, and n_vertices 0 or "
                       "more");
    io_model model = {.threads = 1};
    const pl_outside outside = pl_call_enter(NULL);
    int status = io_bytes_open(path, IO_LARGEST_COPY, &model.input, error);
    if (!status) {
        status = read_file(&model, dim, n_vertices, data, error);
        io_model_destroy(&model);
    }
    if (status) {
        pl_free(data->values);
        *data = (planish_data){.n = 0};
    }
    pl_call_leave(&outside);
    return status;
}
