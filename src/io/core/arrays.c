/* arrays: arrays of one number per cell, and the regions of cells that they make. */
#include "io/core/arrays.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

/* ---- reading ------------------------------------------------------------------------------ */

static int fail_arrays(planish_error *error) {
    return pl_fail_memory(error, "the arrays of cells");
}

int io_array_begin(const io_model *model, const char *name, int64_t n_cells,
                   io_array_filler *filler, planish_error *error) {
    *filler = (io_array_filler){.elements = io_model_elements(model)};
    filler->array.n = n_cells;
    filler->array.name = pl_copy_text(name);
    filler->array.narrow = pl_alloc_zero(n_cells, sizeof *filler->array.narrow);
    if (filler->array.name && filler->array.narrow)
        return PLANISH_OK;
    io_array_drop(filler);
    return fail_arrays(error);
}

int io_array_begin_elements(const io_model *model, const char *name, io_array_filler *filler,
                            planish_error *error) {
    const int64_t n = io_model_elements(model)->n;
    const int status = io_array_begin(model, name, n, filler, error);
    if (status)
        return status;
    filler->array.by_element = 1;
    filler->has = pl_alloc_zero(n, sizeof *filler->has);
    if (filler->has)
        return PLANISH_OK;
    io_array_drop(filler);
    return fail_arrays(error);
}

void io_array_drop(io_array_filler *filler) {
    pl_free(filler->array.name);
    pl_free(filler->array.narrow);
    pl_free(filler->array.wide);
    pl_free(filler->has);
    filler->array = (io_array){.name = NULL};
    filler->has = NULL;
}

int io_array_whole(double real, int64_t *value) {
    const double limit = 9223372036854775808.0; /* 2^63 */
    if (!(real >= -limit && real < limit))
        return 0;
    *value = (int64_t)real;
    return (double)*value == real;
}

/** From now on values have 64 bits. */
static int widen(io_array *array, int64_t n_done, planish_error *error) {
    array->wide = pl_alloc_zero(array->n, sizeof *array->wide);
    if (!array->wide)
        return fail_arrays(error);
    for (int64_t i = 0; i < n_done; i++)
        array->wide[i] = array->narrow[i];
    pl_free(array->narrow);
    array->narrow = NULL;
    return PLANISH_OK;
}

int io_array_put(io_array_filler *filler, int64_t cell, int is_whole, int64_t value,
                 planish_error *error) {
    const io_cells *elements = filler->elements;
    io_array *array = &filler->array;
    if (is_whole && array->narrow && value >= INT32_MIN && value <= INT32_MAX) {
        array->narrow[cell] = (int32_t)value;
        return PLANISH_OK;
    }
    while (filler->next < elements->n && io_cell_number(elements, filler->next) < cell)
        filler->next++;
    if (filler->next == elements->n || io_cell_number(elements, filler->next) != cell)
        return PLANISH_OK; /* what other cells have does not matter */
    filler->is_broken |= !is_whole;
    if (!is_whole)
        return PLANISH_OK;
    const int status = array->wide ? PLANISH_OK : widen(array, cell, error);
    if (!status)
        array->wide[cell] = value;
    return status;
}

int io_array_put_element(io_array_filler *filler, int64_t element, int is_whole, int64_t value,
                         planish_error *error) {
    io_array *array = &filler->array;
    filler->is_broken |= !is_whole;
    if (!is_whole)
        return PLANISH_OK;
    if (array->narrow && (value < INT32_MIN || value > INT32_MAX)) {
        const int status = widen(array, array->n, error);
        if (status)
            return status;
    }
    if (array->wide)
        array->wide[element] = value;
    else
        array->narrow[element] = (int32_t)value;
    filler->n_has += !filler->has[element];
    filler->has[element] = 1;
    return PLANISH_OK;
}

int io_array_is_full(const io_array_filler *filler) {
    return !filler->has || filler->n_has == filler->array.n;
}

int io_array_end(io_model *model, io_array_filler *filler, planish_error *error) {
    int64_t n = model->n_arrays;
    int status = PLANISH_OK;
    if (!filler->is_broken && io_array_is_full(filler) && model->n_arrays < IO_MOST_ARRAYS) {
        if (pl_append(&model->array, &n, &model->array_capacity, &filler->array,
                      sizeof filler->array)) {
            model->n_arrays++;
            filler->array = (io_array){.name = NULL};
        } else {
            status = fail_arrays(error);
        }
    }
    io_array_drop(filler);
    return status;
}

/* ---- regions of cells --------------------------------------------------------------------- */

/** Value of cell i of cells; elements: those that are smoothed. */
static int64_t value_of(const io_array *array, const io_cells *elements, const io_cells *cells,
                        int64_t i) {
    const int64_t at = array->by_element ? i : io_cell_number(cells, i);
    if (at >= array->n || (array->by_element && cells != elements))
        return 0;
    return array->wide ? array->wide[at] : array->narrow[at];
}

/** The model's arrays as the library takes them; behind them the file's own entities, if it has
 *  any, which tell regions in any case. */
typedef struct array_view {
    planish_cell_array *of; /* [n_arrays + has_entities] */
    void **owned;           /* [n_arrays] */
} array_view;

static void release_view(const io_model *model, array_view *v) {
    for (int i = 0; v->owned && i < model->n_arrays; i++)
        pl_free(v->owned[i]);
    pl_free(v->owned);
    pl_free(v->of);
}

static int make_view(const io_model *model, array_view *v, planish_error *error) {
    const io_cells *cells = io_model_elements(model);
    const int n = model->n_arrays;
    v->of = pl_alloc_zero((int64_t)n + 1, sizeof *v->of);
    v->owned = pl_alloc_zero(n, sizeof *v->owned);
    if (!v->of || !v->owned)
        return fail_arrays(error);
    for (int i = 0; i < n; i++) {
        const io_array *array = &model->array[i];
        const size_t size = array->wide ? sizeof *array->wide : sizeof *array->narrow;
        const char *all = array->wide ? (const char *)array->wide : (const char *)array->narrow;
        const int64_t first = array->by_element ? 0 : cells->first_number;
        v->of[i].name = array->name;
        v->of[i].type = array->wide ? PLANISH_NUMBER_INT64 : PLANISH_NUMBER_INT32;
        v->of[i].is_region = array->is_region;
        if (array->by_element || (!cells->number && first + cells->n <= array->n)) {
            v->of[i].values = all + (size_t)first * size;
            continue;
        }
        /* Elements do not stand one after another: a copy of their values does. */
        v->of[i].values = v->owned[i] = pl_alloc(cells->n, size);
        if (!v->owned[i])
            return fail_arrays(error);
        for (int64_t k = 0; k < cells->n; k++)
            if (array->wide)
                ((int64_t *)v->owned[i])[k] = value_of(array, cells, cells, k);
            else
                ((int32_t *)v->owned[i])[k] = (int32_t)value_of(array, cells, cells, k);
    }
    if (model->has_entities)
        v->of[n] = (planish_cell_array){
            .values = cells->entity, .type = PLANISH_NUMBER_INT32, .is_region = 1};
    return PLANISH_OK;
}

/** The array by whose values groups are named: the one of the most telling name; else the first
 *  that tells regions. -1: none. */
static int find_primary(const io_model *model) {
    int best = -1, best_rank = 0;
    for (int i = 0; i < model->n_arrays; i++) {
        const int rank = planish_region_name(model->array[i].name);
        if (rank > 0 && (best < 0 || rank < best_rank)) {
            best = i;
            best_rank = rank;
        }
    }
    for (int i = 0; best < 0 && i < model->n_arrays; i++)
        if (model->array[i].is_region)
            best = i;
    return best;
}

/** Give the cells of a dimension the entities of their values. */
static int store_entities(io_model *model, int dim, const io_array *array, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    int32_t last = 0, entity = -1;
    cells->entity = pl_alloc(cells->n, sizeof *cells->entity);
    if (!cells->entity)
        return pl_fail_memory(error, "the regions of cells");
    for (int64_t i = 0; i < cells->n; i++) {
        const int32_t value = (int32_t)value_of(array, io_model_elements(model), cells, i);
        if (entity < 0 || value != last) {
            last = value;
            entity = io_model_entity(model, dim, last, 0, NULL, error);
            if (entity < 0)
                return entity;
        }
        cells->entity[i] = entity;
    }
    return PLANISH_OK;
}

/** Make the regions of cells from the arrays whose is_region is set; primary: the one by whose
 *  values groups are named, or -1. The file's own entities stay, and regions are parts of theirs.
 */
static int make_regions(io_model *model, const array_view *v, int primary, planish_error *error) {
    io_cells *elements =
        io_model_cells(model, io_model_elements(model) == &model->triangle ? 2 : 3);
    const int has_tags = !model->has_entities && primary >= 0 && !model->array[primary].wide;
    /* Forget the regions that arrays have made. */
    for (int dim = 1; dim <= 3; dim++) {
        io_cells *cells = io_model_cells(model, dim);
        if (model->has_entities && cells != elements)
            continue;
        pl_free(cells->region);
        cells->region = NULL;
        if (model->has_entities)
            continue;
        pl_free(cells->entity);
        cells->entity = NULL;
    }
    if (!model->has_entities)
        io_model_clear_entities(model);
    for (int dim = 1; dim <= 3 && has_tags; dim++) {
        const int status = store_entities(model, dim, &model->array[primary], error);
        if (status)
            return status;
    }
    /* Entities, the file's own or those of the primary array, may say all that there is to say. */
    int is_alone = 1;
    for (int i = 0; i < model->n_arrays; i++)
        is_alone &= !model->array[i].is_region ||
                    (!model->has_entities && i == primary && !model->array[i].wide);
    if (is_alone)
        return PLANISH_OK;
    elements->region = pl_alloc(elements->n, sizeof *elements->region);
    if (!elements->region)
        return pl_fail_memory(error, "the regions of cells");
    return planish_combine_regions(elements->n, v->of, model->n_arrays + model->has_entities,
                                   elements->region, NULL, error);
}

/** Make the lists of names that users are given. */
static int list_names(io_model *model, planish_error *error) {
    const int64_t room = (int64_t)model->n_arrays + 1;
    int n = 0;
    if (!model->array_name)
        model->array_name = pl_alloc_zero(room, sizeof *model->array_name);
    if (!model->region_name)
        model->region_name = pl_alloc_zero(room, sizeof *model->region_name);
    if (!model->array_name || !model->region_name)
        return pl_fail_memory(error, "the names of arrays");
    for (int i = 0; i < model->n_arrays; i++) {
        model->array_name[i] = model->array[i].name;
        if (model->array[i].is_region)
            model->region_name[n++] = model->array[i].name;
    }
    model->region_name[n] = NULL;
    return PLANISH_OK;
}

/** Ask the library which arrays tell regions. What is no mesh has none to find: the caller is told
 *  so when it makes a plan. */
static int find_region_arrays(io_model *model, array_view *v, planish_error *error) {
    const io_cells *cells = io_model_elements(model);
    const planish_mesh mesh = {.dim = cells == &model->triangle ? 2 : 3,
                               .n_nodes = model->n_nodes,
                               .n_elements = cells->n,
                               .coordinates = model->xyz,
                               .elements = cells->nodes,
                               .node_stride = 3,
                               .component_stride = 1};
    const int status = planish_find_regions(&mesh, v->of, model->n_arrays, model->threads, error);
    for (int i = 0; i < model->n_arrays && !status; i++)
        model->array[i].is_region = v->of[i].is_region;
    if (status != PLANISH_ERROR_MESH)
        return status;
    const int primary = find_primary(model);
    if (primary >= 0)
        v->of[primary].is_region = model->array[primary].is_region = 1;
    return PLANISH_OK;
}

/** Make regions, and the lists of names, by the arrays that are chosen, of which first is the one
 *  that groups are named by; or (is_chosen 0) by those that the library finds. */
static int apply_arrays(io_model *model, int is_chosen, int first, planish_error *error) {
    array_view v = {.of = NULL};
    int status = make_view(model, &v, error);
    if (!status && !is_chosen)
        status = find_region_arrays(model, &v, error);
    if (!status)
        status = make_regions(model, &v, is_chosen ? first : find_primary(model), error);
    if (!status)
        status = list_names(model, error);
    release_view(model, &v);
    return status;
}

int io_arrays_find_regions(io_model *model, planish_error *error) {
    if (model->n_arrays == 0 || io_model_elements(model)->n == 0)
        return PLANISH_OK;
    model->has_entities = io_model_elements(model)->entity != NULL;
    return apply_arrays(model, 0, -1, error);
}

/* ---- choosing ----------------------------------------------------------------------------- */

static int fail_name(const io_model *model, const char *name, planish_error *error) {
    enum { LISTED = 10 };
    char list[256] = "none";
    size_t used = 0;
    for (int i = 0; i < model->n_arrays && i < LISTED && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "",
                                 model->array[i].name);
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "%s: there is no array '%s' of one whole number per element; the file has: %s%s",
                   model->input.path, name, list,
                   model->n_arrays > LISTED && used < sizeof list ? ", ..." : "");
}

static int choose_names(io_model *model, const char *const *names, int n_names,
                        planish_error *error) {
    int first = -1;
    for (int i = 0; i < model->n_arrays; i++)
        model->array[i].is_region = 0;
    for (int k = 0; k < n_names; k++)
        for (int i = 0; i < model->n_arrays; i++)
            if (strcmp(model->array[i].name, names[k]) == 0) {
                first = first < 0 ? i : first;
                model->array[i].is_region = 1;
            }
    return apply_arrays(model, 1, first, error);
}

int io_arrays_choose(io_model *model, const char *const *names, int n_names, planish_error *error) {
    for (int k = 0; k < n_names; k++) {
        int i = 0;
        while (i < model->n_arrays && strcmp(model->array[i].name, names[k]) != 0)
            i++;
        if (i == model->n_arrays)
            return fail_name(model, names[k], error);
    }
    if (n_names > 0 && model->arrays_are_gone)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: the arrays that tell regions have been chosen already",
                       model->input.path);
    const int status = n_names > 0 ? choose_names(model, names, n_names, error) : PLANISH_OK;
    if (status)
        return status;
    for (int i = 0; i < model->n_arrays; i++) {
        pl_free(model->array[i].narrow);
        pl_free(model->array[i].wide);
        model->array[i].narrow = NULL;
        model->array[i].wide = NULL;
    }
    model->arrays_are_gone = 1;
    return PLANISH_OK;
}

void io_arrays_destroy(io_model *model) {
    for (int i = 0; i < model->n_arrays; i++) {
        pl_free(model->array[i].name);
        pl_free(model->array[i].narrow);
        pl_free(model->array[i].wide);
    }
    pl_free(model->array);
    pl_free(model->array_name);
    pl_free(model->region_name);
}
