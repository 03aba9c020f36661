/* arrays: arrays of one number per cell, and the regions of cells that they make. */
#include "io/core/arrays.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

/* ---- reading ------------------------------------------------------------------------------ */

/** The simplices that are going to be smoothed. */
static const io_cells *elements_of(const io_model *model) {
    return model->tetrahedron.n > 0 ? &model->tetrahedron : &model->triangle;
}

static int dim_of(const io_model *model) {
    return model->tetrahedron.n > 0 ? 3 : 2;
}

/** The number of a cell, from 0, among those of the file. */
static int64_t place_of(const io_cells *cells, int64_t i) {
    return cells->number ? cells->number[i] : cells->first_number + i;
}

static int fail_arrays(planish_error *error) {
    return pl_fail_memory(error, "the arrays of cells");
}

int io_array_begin(const io_model *model, const char *name, int64_t n_cells,
                   io_array_filler *filler, planish_error *error) {
    *filler = (io_array_filler){.elements = elements_of(model)};
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
    const int64_t n = elements_of(model)->n;
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

/** Whether cell is an element; cells are asked for in ascending order. */
static int is_element(io_array_filler *filler, int64_t cell) {
    const io_cells *elements = filler->elements;
    while (filler->next < elements->n && place_of(elements, filler->next) < cell)
        filler->next++;
    return filler->next < elements->n && place_of(elements, filler->next) == cell;
}

int io_array_put(io_array_filler *filler, int64_t cell, int is_whole, int64_t value,
                 planish_error *error) {
    io_array *array = &filler->array;
    if (is_whole && array->narrow && value >= INT32_MIN && value <= INT32_MAX) {
        array->narrow[cell] = (int32_t)value;
        return PLANISH_OK;
    }
    if (!is_element(filler, cell))
        return PLANISH_OK; /* what other cells have does not matter */
    if (!is_whole) {
        filler->is_broken = 1;
        return PLANISH_OK;
    }
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
    int64_t capacity = model->array_capacity;
    if (filler->is_broken || !io_array_is_full(filler) || model->n_arrays == IO_MOST_ARRAYS) {
        io_array_drop(filler);
        return PLANISH_OK;
    }
    io_array *grown = pl_grow(model->array, model->n_arrays, (int64_t)model->n_arrays + 1,
                              &capacity, sizeof *grown);
    if (!grown) {
        io_array_drop(filler);
        return fail_arrays(error);
    }
    model->array = grown;
    model->array_capacity = (int)capacity;
    model->array[model->n_arrays++] = filler->array;
    filler->array = (io_array){.name = NULL};
    io_array_drop(filler);
    return PLANISH_OK;
}

/* ---- regions of cells --------------------------------------------------------------------- */

/** Value of cell i of cells; elements: those that are smoothed. */
static int64_t value_of(const io_array *array, const io_cells *elements, const io_cells *cells,
                        int64_t i) {
    const int64_t at = array->by_element ? i : place_of(cells, i);
    if (at >= array->n || (array->by_element && cells != elements))
        return 0;
    return array->wide ? array->wide[at] : array->narrow[at];
}

/** Give the cells the entities of their values. */
static int store_entities(io_model *model, io_cells *cells, int dim, const io_array *array,
                          planish_error *error) {
    int32_t last = 0, entity = -1;
    cells->entity = pl_alloc(cells->n, sizeof *cells->entity);
    if (!cells->entity)
        return pl_fail_memory(error, "the regions of cells");
    for (int64_t i = 0; i < cells->n; i++) {
        const int32_t value = (int32_t)value_of(array, elements_of(model), cells, i);
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

/** Forget the regions that arrays have made; the file's own entities stay. */
static void clear_regions(io_model *model) {
    io_cells *const cells[] = {&model->line, &model->triangle, &model->tetrahedron};
    if (model->has_entities) {
        io_cells *elements = io_model_cells(model, dim_of(model));
        pl_free(elements->region);
        elements->region = NULL;
        return;
    }
    for (int i = 0; i < 3; i++) {
        pl_free(cells[i]->entity);
        pl_free(cells[i]->region);
        cells[i]->entity = cells[i]->region = NULL;
    }
    io_model_clear_entities(model);
}

/** The values of the elements, in their order: those of the array, or a copy, *owned. */
static const void *element_values(const io_model *model, const io_array *array, void **owned) {
    const io_cells *cells = elements_of(model);
    const size_t size = array->wide ? sizeof *array->wide : sizeof *array->narrow;
    const int64_t first = array->by_element ? 0 : cells->first_number;
    *owned = NULL;
    if (array->by_element || (!cells->number && first + cells->n <= array->n))
        return array->wide ? (const void *)(array->wide + first)
                           : (const void *)(array->narrow + first);
    char *copy = *owned = pl_alloc(cells->n, size);
    for (int64_t i = 0; copy && i < cells->n; i++)
        if (array->wide)
            ((int64_t *)*owned)[i] = value_of(array, cells, cells, i);
        else
            ((int32_t *)*owned)[i] = (int32_t)value_of(array, cells, cells, i);
    return copy;
}

/** The model's arrays as the library takes them; behind them the file's own entities, if it has
 *  such, which tell regions in any case. */
typedef struct view {
    planish_cell_array *of; /* [n_arrays + has_entities] */
    void **owned;           /* [n_arrays] */
} view;

static void release_view(const io_model *model, view *v) {
    for (int i = 0; v->owned && i < model->n_arrays; i++)
        pl_free(v->owned[i]);
    pl_free(v->owned);
    pl_free(v->of);
}

static int make_view(const io_model *model, view *v, planish_error *error) {
    const int n = model->n_arrays;
    v->of = pl_alloc_zero((int64_t)n + 1, sizeof *v->of);
    v->owned = pl_alloc_zero(n, sizeof *v->owned);
    for (int i = 0; v->of && v->owned && i < n; i++) {
        const io_array *array = &model->array[i];
        v->of[i].name = array->name;
        v->of[i].type = array->wide ? PLANISH_NUMBER_INT64 : PLANISH_NUMBER_INT32;
        v->of[i].is_region = array->is_region;
        v->of[i].values = element_values(model, array, &v->owned[i]);
        if (!v->of[i].values)
            return fail_arrays(error);
    }
    if (v->of && model->has_entities)
        v->of[n] = (planish_cell_array){
            .values = elements_of(model)->entity, .type = PLANISH_NUMBER_INT32, .is_region = 1};
    return v->of && v->owned ? PLANISH_OK : fail_arrays(error);
}

/** The array by whose values groups are named: first, that asked for; else the one of the most
 *  telling name; else the first that tells regions. -1: none. */
static int find_primary(const io_model *model, int first) {
    int best = -1, best_rank = 0;
    for (int i = 0; first < 0 && i < model->n_arrays; i++) {
        const int rank = planish_region_name(model->array[i].name);
        if (rank > 0 && (best < 0 || rank < best_rank)) {
            best = i;
            best_rank = rank;
        }
    }
    for (int i = 0; first < 0 && best < 0 && i < model->n_arrays; i++)
        if (model->array[i].is_region)
            best = i;
    return first < 0 ? best : first;
}

/** Whether entities, which are the file's own or those of the primary array, say all that there is
 *  to say. */
static int is_alone(const io_model *model, int primary) {
    for (int i = 0; i < model->n_arrays; i++)
        if (model->array[i].is_region &&
            (model->has_entities || i != primary || model->array[i].wide))
            return 0;
    return 1;
}

static int combine(io_model *model, const view *v, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim_of(model));
    cells->region = pl_alloc(cells->n, sizeof *cells->region);
    if (!cells->region)
        return pl_fail_memory(error, "the regions of cells");
    return planish_combine_regions(cells->n, v->of, model->n_arrays + model->has_entities,
                                   cells->region, NULL, error);
}

/** Make the regions of cells from the arrays whose is_region is set. The file's own entities stay,
 *  and regions are parts of theirs. */
static int make_regions(io_model *model, const view *v, int first, planish_error *error) {
    const int primary = find_primary(model, first);
    const int has_tags = !model->has_entities && primary >= 0 && !model->array[primary].wide;
    int status = PLANISH_OK;
    clear_regions(model);
    for (int dim = 1; dim <= 3 && has_tags && !status; dim++)
        status =
            store_entities(model, io_model_cells(model, dim), dim, &model->array[primary], error);
    if (!status && !is_alone(model, primary))
        status = combine(model, v, error);
    return status;
}

/** The lists of names that users are given. */
static int list_names(io_model *model, planish_error *error) {
    int n = 0;
    if (!model->array_name)
        model->array_name = pl_alloc_zero((int64_t)model->n_arrays + 1, sizeof *model->array_name);
    if (!model->region_name)
        model->region_name =
            pl_alloc_zero((int64_t)model->n_arrays + 1, sizeof *model->region_name);
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

/** What is no mesh has no regions to find: the caller is told so when it makes a plan. */
static int ask(io_model *model, view *v, planish_error *error) {
    const io_cells *cells = elements_of(model);
    const planish_mesh mesh = {.dim = dim_of(model),
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
    const int primary = find_primary(model, -1);
    if (primary >= 0)
        v->of[primary].is_region = model->array[primary].is_region = 1;
    return PLANISH_OK;
}

int io_arrays_settle(io_model *model, planish_error *error) {
    view v = {.of = NULL};
    if (model->n_arrays == 0 || elements_of(model)->n == 0)
        return PLANISH_OK;
    model->has_entities = elements_of(model)->entity != NULL;
    int status = make_view(model, &v, error);
    if (!status)
        status = ask(model, &v, error);
    if (!status)
        status = make_regions(model, &v, -1, error);
    if (!status)
        status = list_names(model, error);
    release_view(model, &v);
    return status;
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

/** All arrays of that name; *first becomes the first of them. */
static int choose_name(io_model *model, const char *name, int *first, planish_error *error) {
    int found = 0;
    for (int i = 0; i < model->n_arrays; i++) {
        if (strcmp(model->array[i].name, name) != 0)
            continue;
        if (*first < 0)
            *first = i;
        found = model->array[i].is_region = 1;
    }
    return found ? PLANISH_OK : fail_name(model, name, error);
}

static int choose_names(io_model *model, const char *const *names, int n_names,
                        planish_error *error) {
    int first = -1, status = PLANISH_OK;
    view v = {.of = NULL};
    for (int i = 0; i < model->n_arrays; i++)
        model->array[i].is_region = 0;
    for (int i = 0; i < n_names && !status; i++)
        status = choose_name(model, names[i], &first, error);
    if (!status)
        status = make_view(model, &v, error);
    if (!status)
        status = make_regions(model, &v, first, error);
    if (!status)
        status = list_names(model, error);
    release_view(model, &v);
    return status;
}

static int is_known(const io_model *model, const char *name) {
    for (int i = 0; i < model->n_arrays; i++)
        if (strcmp(model->array[i].name, name) == 0)
            return 1;
    return 0;
}

int io_arrays_choose(io_model *model, const char *const *names, int n_names, planish_error *error) {
    int status = PLANISH_OK;
    for (int i = 0; i < n_names && !status; i++)
        if (!is_known(model, names[i]))
            status = fail_name(model, names[i], error);
    if (!status && n_names > 0 && model->arrays_are_gone)
        status =
            pl_fail(error, PLANISH_ERROR_ARGUMENT,
                    "%s: the arrays that tell regions have been chosen already", model->input.path);
    if (!status && n_names > 0)
        status = choose_names(model, names, n_names, error);
    for (int i = 0; i < model->n_arrays && !status; i++) {
        pl_free(model->array[i].narrow);
        pl_free(model->array[i].wide);
        model->array[i].narrow = NULL;
        model->array[i].wide = NULL;
    }
    if (!status)
        model->arrays_are_gone = 1;
    return status;
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
