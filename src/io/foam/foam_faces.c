/* foam_faces: faces, and the cells on their sides.
 *
 * A list of faces is text, 4(0 1 2 3) each, or compact: where the nodes of each face begin, then the
 * nodes of all. Some programs write binary faces one by one.
 */
#include "io/foam/foam_faces.h"
#include "io/foam/foam_list.h"

#include "base/memory.h"
#include "base/status.h"

enum { LEAST = 3 }; /* nodes of a face */

typedef struct face_reader {
    foam_mesh *mesh;
    foam_file file;
    int64_t n_nodes, capacity; /* of mesh->node */
    int64_t uniform;           /* text: nodes of all faces; 0: they differ */
} face_reader;

/* ---- text ----------------------------------------------------------------------------------- */

static int fail_face(const face_reader *r, const char *at, int64_t face, planish_error *error) {
    return io_fail_at(&r->file.of.view, at, error,
                      "face %lld: its nodes expected, as in 4(0 1 2 3) (the file may be cut short)",
                      (long long)face);
}

/** Take the number of nodes of a face and '('; *n -1: there is none. */
static int begin_face(const face_reader *r, io_cursor *cursor, int64_t face, int64_t *n,
                      planish_error *error) {
    foam_skip_few(cursor);
    const char *at = cursor->at;
    *n = -1;
    if (cursor->at < cursor->end && *cursor->at != '(' &&
        (foam_integer(cursor, n) || *n < LEAST || *n > cursor->end - at))
        return fail_face(r, at, face, error);
    foam_skip_few(cursor);
    if (cursor->at == cursor->end || *cursor->at != '(')
        return fail_face(r, at, face, error);
    cursor->at++;
    return PLANISH_OK;
}

/** Take the next node of a face. Return 1, 0: ')' came, or a negative status. */
static inline int next_node(const face_reader *r, io_cursor *cursor, int64_t face, int32_t *node,
                            planish_error *error) {
    int64_t number = 0;
    foam_skip_few(cursor);
    const char *at = cursor->at;
    if (cursor->at < cursor->end && *cursor->at == ')') {
        cursor->at++;
        return 0;
    }
    if (foam_integer(cursor, &number))
        return fail_face(r, at, face, error);
    if (number < 0 || number >= r->mesh->model->n_nodes)
        return io_fail_no_node(&r->file.of.view, at, "face", face, number, error);
    *node = (int32_t)number;
    return 1;
}

/** Read faces that all have as many nodes. */
static int read_uniform_faces(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const face_reader *r = context;
    for (int64_t face = begin; face < end; face++) {
        int64_t n, k = 0;
        int32_t node = 0;
        int more = begin_face(r, cursor, face, &n, error);
        while (!more && k <= r->uniform && (more = next_node(r, cursor, face, &node, error)) == 1) {
            if (k < r->uniform)
                r->mesh->node[face * r->uniform + k] = node;
            k++;
            more = 0;
        }
        if (more < 0 || k != r->uniform || (n >= 0 && n != k))
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
    }
    return PLANISH_OK;
}

/** Make room for one more node. */
static int append_node(face_reader *r, int32_t node, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    if (r->n_nodes == INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: more than %d nodes of faces",
                       r->file.of.view.input.path, INT32_MAX);
    if (r->n_nodes == r->capacity) {
        int32_t *grown =
            pl_grow(mesh->node, r->n_nodes, r->n_nodes + 1, &r->capacity, sizeof *grown);
        if (!grown)
            return pl_fail_memory(error, "faces");
        mesh->node = grown;
    }
    mesh->node[r->n_nodes++] = node;
    return PLANISH_OK;
}

static int fail_size(const face_reader *r, const char *at, int64_t face, int64_t n,
                     int64_t expected, planish_error *error) {
    if (n < LEAST)
        return io_fail_at(&r->file.of.view, at, error,
                          "face %lld has %lld nodes: three at least expected", (long long)face,
                          (long long)n);
    return io_fail_at(&r->file.of.view, at, error, "face %lld: %lld nodes follow, not %lld",
                      (long long)face, (long long)n, (long long)expected);
}

/** Read faces of text in order. */
static int read_faces(face_reader *r, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    io_cursor *cursor = &r->file.cursor;
    r->n_nodes = 0;
    for (int64_t face = 0; face < mesh->n_faces; face++) {
        int64_t n;
        int32_t node = 0;
        const char *at = cursor->at;
        int status = begin_face(r, cursor, face, &n, error), more = 0;
        mesh->start[face] = (int32_t)r->n_nodes;
        while (!status && (more = next_node(r, cursor, face, &node, error)) == 1)
            status = append_node(r, node, error);
        status = more < 0 ? more : status;
        const int64_t found = r->n_nodes - mesh->start[face];
        if (!status && (found < LEAST || (n >= 0 && n != found)))
            status = fail_size(r, at, face, found, n, error);
        if (status)
            return status;
    }
    mesh->start[mesh->n_faces] = (int32_t)r->n_nodes;
    return PLANISH_OK;
}

/** Count the nodes of the first face; 0: it is not written as most are. */
static int64_t count_first(const face_reader *r) {
    io_cursor cursor = r->file.cursor;
    int64_t n;
    foam_skip(&cursor);
    return io_parse_integer(&cursor.at, cursor.end, &n) || n < LEAST || n > 8 ? 0 : n;
}

static int read_text_faces(face_reader *r, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    planish_error ignored;
    r->uniform = count_first(r);
    r->capacity = r->uniform * mesh->n_faces;
    if (r->capacity > io_left(&r->file.cursor) / 2 + 1 || r->capacity > INT32_MAX)
        r->uniform = r->capacity = 0;
    if (r->uniform) {
        mesh->node = pl_alloc(r->capacity, sizeof *mesh->node);
        if (!mesh->node)
            return pl_fail_memory(error, "faces");
        io_text text;
        io_text_init(&text, &r->file.of.view);
        io_cursor from = r->file.cursor;
        foam_skip(&from);
        const int differ = io_text_records(&text, &from, mesh->n_faces, r->uniform,
                                           read_uniform_faces, r, &ignored);
        io_text_release(&text);
        for (int64_t i = 0; i <= mesh->n_faces && !differ; i++)
            mesh->start[i] = (int32_t)(i * r->uniform);
        if (!differ) {
            r->file.cursor = from;
            return PLANISH_OK;
        }
    }
    return read_faces(r, error);
}

/* ---- binary --------------------------------------------------------------------------------- */

/** Read faces that are lists of their own, in binary. */
static int read_single_faces(face_reader *r, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    int status = PLANISH_OK;
    for (int64_t face = 0; face < mesh->n_faces && !status; face++) {
        const char *at = r->file.cursor.at;
        int32_t *nodes = NULL;
        int64_t n = 0;
        status = foam_labels(&r->file, "nodes of a face", 0, mesh->model->n_nodes - 1, &nodes, &n,
                             error);
        mesh->start[face] = (int32_t)r->n_nodes;
        if (!status && n < LEAST)
            status = fail_size(r, at, face, n, n, error);
        else if (!status && n > r->file.cursor.at - at) /* 65536{0}: equal ones take no room */
            status = fail_face(r, at, face, error);
        for (int64_t k = 0; k < n && !status; k++)
            status = append_node(r, nodes[k], error);
        pl_free(nodes);
    }
    mesh->start[mesh->n_faces] = (int32_t)r->n_nodes;
    return status;
}

/** Read compact faces: where the nodes of each begin, then all nodes. */
static int read_compact_faces(face_reader *r, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    int64_t n_starts = 0;
    const char *at = r->file.cursor.at;
    int status =
        foam_labels(&r->file, "beginnings of faces", 0, INT32_MAX, &mesh->start, &n_starts, error);
    const int32_t *start = mesh->start;
    if (!status && n_starts == 0)
        status = io_fail_at(&r->file.of.view, at, error, "there are no faces");
    if (!status)
        status = foam_labels(&r->file, "nodes of faces", 0, mesh->model->n_nodes - 1, &mesh->node,
                             &r->n_nodes, error);
    mesh->n_faces = status ? 0 : n_starts - 1;
    for (int64_t i = 1; i < n_starts && !status; i++)
        if (start[i] - (int64_t)start[i - 1] < LEAST)
            status = fail_size(r, at, i - 1, start[i] - (int64_t)start[i - 1], 0, error);
    if (!status && (start[0] != 0 || start[mesh->n_faces] != r->n_nodes))
        status =
            io_fail_at(&r->file.of.view, at, error,
                       "the faces have other numbers of nodes than there are nodes in the list");
    return status;
}

static int read_face_file(face_reader *r, planish_error *error) {
    foam_mesh *mesh = r->mesh;
    int status = foam_open(mesh->model, "faces", 1, &r->file, error);
    if (status)
        return status;
    if (io_slice_is(r->file.class, "faceCompactList", 0))
        return read_compact_faces(r, error);
    const int64_t shortest = 7; /* (0 1 2), or in binary 3() and what is between */
    status = foam_begin_list(&r->file, "faces", shortest, &mesh->n_faces, error);
    if (!status && !(mesh->start = pl_alloc_zero(mesh->n_faces + 1, sizeof *mesh->start)))
        status = pl_fail_memory(error, "faces");
    if (status || mesh->n_faces == 0)
        return status;
    status = r->file.of.view.is_binary ? read_single_faces(r, error) : read_text_faces(r, error);
    return status ? status : foam_end_list(&r->file, "faces", error);
}

/* ---- the cells on their sides --------------------------------------------------------------- */

/** Read a list of cells, one for each face: *cells [n] is owned. */
static int read_cells(const foam_mesh *mesh, const char *name, int64_t first, int32_t **cells,
                      int64_t *n, planish_error *error) {
    foam_file f;
    *cells = NULL;
    *n = 0;
    int status = foam_open(mesh->model, name, 1, &f, error);
    const char *at = f.cursor.at;
    if (!status)
        status = foam_labels(&f, name, first, INT32_MAX - 1, cells, n, error);
    if (!status && *n > mesh->n_faces)
        status = io_fail_at(&f.of.view, at, error, "%lld cells for %lld faces", (long long)*n,
                            (long long)mesh->n_faces);
    if (!status && first == 0 && *n < mesh->n_faces)
        status = io_fail_at(&f.of.view, at, error, "%lld cells for %lld faces", (long long)*n,
                            (long long)mesh->n_faces);
    foam_close(&f);
    return status;
}

/** Count the cells. Each has faces, so that there cannot be more of them than sides of faces. */
static int count_cells(foam_mesh *mesh, planish_error *error) {
    int64_t n_sides = mesh->n_faces;
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        const int32_t a = mesh->owner[i], b = foam_neighbour(mesh, i);
        n_sides += b >= 0;
        mesh->n_cells = mesh->n_cells > a ? mesh->n_cells : (int64_t)a + 1;
        mesh->n_cells = mesh->n_cells > b ? mesh->n_cells : (int64_t)b + 1;
        if (a == b)
            return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: face %lld has cell %d on both sides",
                           mesh->model->input.path, (long long)i, a);
    }
    if (mesh->n_cells > n_sides)
        return pl_fail(
            error, PLANISH_ERROR_FORMAT,
            "%s: owner and neighbour name cell %lld, which is more than the faces can have",
            mesh->model->input.path, (long long)mesh->n_cells - 1);
    return PLANISH_OK;
}

int foam_read_faces(foam_mesh *mesh, planish_error *error) {
    face_reader r = {.mesh = mesh};
    int64_t n = 0;
    int status = read_face_file(&r, error);
    foam_close(&r.file);
    if (!status)
        status = read_cells(mesh, "owner", 0, &mesh->owner, &n, error);
    if (!status)
        status = read_cells(mesh, "neighbour", -1, &mesh->neighbour, &mesh->n_listed, error);
    return status ? status : count_cells(mesh, error);
}

void foam_release_mesh(foam_mesh *mesh) {
    pl_free(mesh->start);
    pl_free(mesh->node);
    pl_free(mesh->owner);
    pl_free(mesh->neighbour);
    pl_free(mesh->thing);
    pl_free(mesh->base);
}
