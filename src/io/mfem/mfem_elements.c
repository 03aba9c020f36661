/* mfem_elements: lists of elements and boundary elements, read and given to the model. */
#include "io/mfem/mfem_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- reading -------------------------------------------------------------------------------- */

typedef struct list_job {
    const mfem_reader *r;
    mfem_list *list;
    io_record_kind kind;
    int geometry; /* of all elements, or -1: they differ */
} list_job;

/** Read elements: attribute, geometry, vertices. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const list_job *job = context;
    const mfem_list *list = job->list;
    int64_t attribute = 0, geometry = 0, vertex = 0;
    for (int64_t i = begin; i < end; i++) {
        int status = io_take_whole(&job->kind, cursor, i, INT32_MIN, INT32_MAX, &attribute, error);
        const char *at = cursor->at;
        if (!status)
            status =
                io_take_whole(&job->kind, cursor, i, 0, MFEM_N_GEOMETRIES - 1, &geometry, error);
        if (status)
            return status;
        if (job->geometry >= 0 && geometry != job->geometry)
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
        const mfem_geometry *g = &mfem_geometries[geometry];
        if (g->dim != list->dim)
            return io_fail_at(job->r->model, at, error,
                              "%s %lld: geometry %lld has %d dimensions; %d expected",
                              job->kind.what, (long long)i, (long long)geometry, g->dim, list->dim);
        for (int k = 0; k < g->corners; k++) {
            status =
                io_take_whole(&job->kind, cursor, i, 0, job->r->n_vertices - 1, &vertex, error);
            if (status)
                return status;
            list->vertex[i * list->stride + k] = (int32_t)vertex;
        }
        list->attribute[i] = (int32_t)attribute;
        list->geometry[i] = (uint8_t)geometry;
    }
    return PLANISH_OK;
}

/** Return the geometry of the first element of a section; -1: none that is known. */
static int first_geometry(const io_section *section) {
    io_cursor cursor = {section->data, section->end};
    int64_t attribute, geometry;
    const int is_known = section->count > 0 && io_integer(&cursor, &attribute) == 0 &&
                         io_integer(&cursor, &geometry) == 0 && geometry >= 0 &&
                         geometry < MFEM_N_GEOMETRIES;
    return is_known ? (int)geometry : -1;
}

int mfem_read_list(mfem_reader *r, const io_section *section, const char *what, mfem_list *list) {
    list_job job = {r, list, {.model = r->model, .what = what}, first_geometry(section)};
    planish_error ignored;
    int status = PLANISH_ERROR_FORMAT;
    list->n = section->count;
    list->geometry = pl_alloc(list->n, sizeof *list->geometry);
    list->attribute = pl_alloc(list->n, sizeof *list->attribute);
    if (!list->geometry || !list->attribute)
        return pl_fail_memory(r->error, "the elements of the file");
    /* As a rule all elements are like the first, and threads can read them. */
    for (int is_rest = job.geometry < 0; status && is_rest < 2; is_rest++) {
        list->stride = is_rest ? MFEM_MOST_CORNERS : mfem_geometries[job.geometry].corners;
        job.geometry = is_rest ? -1 : job.geometry;
        pl_free(list->vertex);
        list->vertex = pl_alloc(list->n, (size_t)list->stride * sizeof *list->vertex);
        if (!list->vertex)
            return pl_fail_memory(r->error, "the elements of the file");
        status = io_section_records(&r->text, section, what, is_rest ? 0 : 2 + list->stride, 0,
                                    read_elements, &job, is_rest ? r->error : &ignored);
    }
    return status;
}

void mfem_list_release(mfem_list *list) {
    pl_free(list->geometry);
    pl_free(list->attribute);
    pl_free(list->vertex);
    *list = (mfem_list){.n = 0};
}

/* ---- the model ------------------------------------------------------------------------------ */

/** Make room for the elements of a list, simplices and others. */
static int reserve(mfem_reader *r, const mfem_list *list, int order) {
    int64_t n[MFEM_N_GEOMETRIES] = {0}, n_simplices = 0, n_others = 0, n_nodes = 0;
    for (int64_t i = 0; i < list->n; i++)
        n[list->geometry[i]]++;
    for (int k = 0; k < MFEM_N_GEOMETRIES; k++) {
        const mfem_geometry *g = &mfem_geometries[k];
        const int is_simplex = g->corners == list->dim + 1;
        n_simplices += is_simplex ? n[k] : 0;
        n_others += is_simplex ? 0 : n[k];
        n_nodes += is_simplex ? 0 : n[k] * mfem_count_nodes(g, order);
    }
    int status = io_cells_reserve(r->model, list->dim, n_simplices, 1, n_others > 0, r->error);
    if (!status && order == 2 && n_simplices > 0)
        status = io_cells_reserve_mids(r->model, list->dim, r->error);
    if (!status && n_others > 0)
        status = io_others_reserve(r->model, list->dim, n_others, n_nodes, 1, r->error);
    return status;
}

/** Add element i of a list, of n nodes, to those of the model, which has room. */
static void add_element(mfem_reader *r, const mfem_list *list, int64_t i, const int32_t *nodes,
                        int n) {
    const mfem_geometry *g = &mfem_geometries[list->geometry[i]];
    io_model *model = r->model;
    if (g->corners == list->dim + 1) {
        io_cells *cells = io_model_cells(model, list->dim);
        memcpy(cells->nodes + cells->n * g->corners, nodes, g->corners * sizeof *nodes);
        cells->entity[cells->n] = list->attribute[i];
        if (cells->number)
            cells->number[cells->n] = i;
        if (n > g->corners)
            io_cells_set_mids(model, list->dim, cells->n, nodes);
        cells->n++;
        return;
    }
    io_others *others = io_model_others(model, list->dim);
    io_others_set(model, others->n, others->n_nodes, io_cell_type(g->shape, n), nodes, i);
    others->entity[others->n++] = list->attribute[i];
    others->n_nodes += n;
    model->n_other++;
}

int mfem_add_elements(mfem_reader *r, const mfem_list *list, int is_boundary) {
    const int order = is_boundary && r->space > MFEM_CONTINUOUS ? 1 : r->order;
    mfem_walk walk = {0};
    int status = reserve(r, list, order);
    for (int64_t i = 0; i < list->n && !status; i++) {
        int32_t nodes[IO_CELL_NODES];
        const int n =
            is_boundary ? mfem_boundary_nodes(r, i, nodes) : mfem_element_nodes(r, i, &walk, nodes);
        if (n > 0)
            add_element(r, list, i, nodes, n);
        else
            r->model->n_lower++;
    }
    if (status)
        return status;
    const io_cells *cells = io_model_cells(r->model, list->dim);
    status = io_model_index_tags(r->model, list->dim, cells->entity, cells->n, r->error);
    if (status || list->dim == 1)
        return status;
    const io_others *others = io_model_others(r->model, list->dim);
    return io_model_index_tags(r->model, list->dim, others->entity, others->n, r->error);
}
