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
    *filler = (io_array_filler){.model = model};
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
    const int64_t n = io_model_n_elements(model);
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

/** Whether the cell of that number, no lower than those asked before, is an element. */
static int is_element(io_array_filler *filler, int64_t cell) {
    const int dim = io_model_dim(filler->model), lists[] = {dim, io_others_list(dim)};
    for (int k = 0; k < 2; k++) {
        const io_list list = io_model_list(filler->model, lists[k]);
        int64_t *next = &filler->next[k];
        while (*next < list.n && io_list_number(&list, *next) < cell)
            ++*next;
        if (*next < list.n && io_list_number(&list, *next) == cell)
            return 1;
    }
    return 0;
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

/** Value of element i of a list; 0: it has none. */
static int64_t value_of(const io_model *model, const io_array *array, const io_list *list,
                        int64_t i) {
    int64_t at = i;
    if (!array->by_element)
        at = io_list_number(list, i);
    else if (list->dim != io_model_dim(model))
        return 0;
    else if (list->others)
        at += io_model_elements(model)->n;
    if (at >= array->n)
        return 0;
    return array->wide ? array->wide[at] : array->narrow[at];
}

/** The model's arrays as the library takes them; behind them the file's own entities, if it has
 *  any, which tell regions in any case. */
typedef struct array_view {
    planish_cell_array *of; /* [n_arrays + has_entities] */
    void **owned;           /* [n_arrays + 1] */
} array_view;

static void release_view(const io_model *model, array_view *v) {
    for (int i = 0; v->owned && i <= model->n_arrays; i++)
        pl_free(v->owned[i]);
    pl_free(v->owned);
    pl_free(v->of);
}

/** Copy the values of an array at the elements, which do not stand one after another in it; array
 *  NULL: their entities. NULL without memory. */
static void *copy_values(const io_model *model, const io_array *array) {
    const size_t size = array && array->wide ? sizeof *array->wide : sizeof(int32_t);
    const int dim = io_model_dim(model), lists[] = {dim, io_others_list(dim)};
    void *copy = pl_alloc(io_model_n_elements(model), size);
    int64_t n = 0;
    for (int k = 0; copy && k < 2; k++) {
        const io_list list = io_model_list(model, lists[k]);
        for (int64_t i = 0; i < list.n; i++, n++) {
            const int64_t value = array ? value_of(model, array, &list, i) : list.entity[i];
            if (size == sizeof(int64_t))
                ((int64_t *)copy)[n] = value;
            else
                ((int32_t *)copy)[n] = (int32_t)value;
        }
    }
    return copy;
}

static int make_view(const io_model *model, array_view *v, planish_error *error) {
    const io_cells *cells = io_model_elements(model);
    const int n = model->n_arrays, is_plain = io_model_other_elements(model)->n == 0;
    v->of = pl_alloc_zero((int64_t)n + 1, sizeof *v->of);
    v->owned = pl_alloc_zero((int64_t)n + 1, sizeof *v->owned);
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
        if (array->by_element || (is_plain && !cells->number && first + cells->n <= array->n)) {
            v->of[i].values = all + (size_t)first * size;
            continue;
        }
        v->of[i].values = v->owned[i] = copy_values(model, array);
        if (!v->owned[i])
            return fail_arrays(error);
    }
    if (!model->has_entities)
        return PLANISH_OK;
    if (!is_plain && !(v->owned[n] = copy_values(model, NULL)))
        return fail_arrays(error);
    v->of[n] = (planish_cell_array){.values = is_plain ? cells->entity : v->owned[n],
                                    .type = PLANISH_NUMBER_INT32,
                                    .is_region = 1};
    return PLANISH_OK;
}

/** The array by whose values groups are named: the one of the most telling name; else the first
 *  that tells regions. -1: none. */
static int find_primary(const io_model *model) {
    int best = -1, best_rank = 0;
    for (int i = 0; i < model->n_arrays; i++) {
        const int rank = planish_rank_region_name(model->array[i].name);
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

/** Return where the entities of a list are. */
static int32_t **entities_of(io_model *model, int list) {
    return list >= IO_FLAT_LIST ? &io_model_others(model, list - 2)->entity
                                : &io_model_cells(model, list)->entity;
}

/** Give the elements of a list the entities of their values. */
static int store_entities(io_model *model, int number, const io_array *array,
                          planish_error *error) {
    const io_list list = io_model_list(model, number);
    int32_t last = 0, entity = -1;
    int32_t *to = *entities_of(model, number) = pl_alloc(list.n, sizeof *to);
    if (!to)
        return pl_fail_memory(error, "the regions of cells");
    for (int64_t i = 0; i < list.n; i++) {
        const int32_t value = (int32_t)value_of(model, array, &list, i);
        if (entity < 0 || value != last) {
            last = value;
            entity = io_model_entity(model, list.dim, last, 0, NULL, error);
            if (entity < 0)
                return entity;
        }
        to[i] = entity;
    }
    return PLANISH_OK;
}

/** Forget the regions of all lists that arrays have made. */
static void forget_regions(io_model *model) {
    const int dim = io_model_dim(model);
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const int has_elements = k == dim || k == io_others_list(dim);
        if (model->has_entities && !has_elements)
            continue;
        pl_free(*io_model_regions(model, k));
        *io_model_regions(model, k) = NULL;
        if (model->has_entities)
            continue;
        pl_free(*entities_of(model, k));
        *entities_of(model, k) = NULL;
    }
    if (!model->has_entities)
        io_model_clear_entities(model);
}

/** Combine the values of v to regions of the elements. */
static int combine_regions(io_model *model, const array_view *v, planish_error *error) {
    const int dim = io_model_dim(model);
    const int64_t n = io_model_elements(model)->n, n_others = io_model_other_elements(model)->n;
    int32_t *of_others = NULL, *region = pl_alloc(n + n_others, sizeof *region);
    if (!region || (n_others > 0 && !(of_others = pl_alloc(n_others, sizeof *of_others)))) {
        pl_free(region);
        return pl_fail_memory(error, "the regions of cells");
    }
    *io_model_regions(model, dim) = region;
    *io_model_regions(model, io_others_list(dim)) = of_others;
    const int status = planish_combine_regions(
        n + n_others, v->of, model->n_arrays + model->has_entities, region, NULL, error);
    if (of_others)
        memcpy(of_others, region + n, (size_t)n_others * sizeof *region);
    return status;
}

/** Make the regions of cells from the arrays whose is_region is set; primary: the one by whose
 *  values groups are named, or -1. The file's own entities stay, and regions are parts of theirs.
 */
static int make_regions(io_model *model, const array_view *v, int primary, planish_error *error) {
    const int has_tags = !model->has_entities && primary >= 0 && !model->array[primary].wide;
    forget_regions(model);
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS && has_tags; k++) {
        const int status = store_entities(model, k, &model->array[primary], error);
        if (status)
            return status;
    }
    /* Entities, the file's own or those of the primary array, may say all that there is to say. */
    int is_alone = 1;
    for (int i = 0; i < model->n_arrays; i++)
        is_alone &= !model->array[i].is_region ||
                    (!model->has_entities && i == primary && !model->array[i].wide);
    return is_alone ? PLANISH_OK : combine_regions(model, v, error);
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
static int find_region_arrays(io_model *model, const planish_cells *cells, array_view *v,
                              planish_error *error) {
    const planish_mesh mesh = {.dim = io_model_dim(model),
                               .n_nodes = model->n_nodes,
                               .n_elements = io_model_n_elements(model),
                               .coordinates = model->xyz,
                               .elements = cells ? NULL : io_model_elements(model)->nodes,
                               .cells = cells,
                               .node_stride = 3,
                               .component_stride = 1};
    const int status =
        planish_find_regions(&mesh, v->of, model->n_arrays, io_model_threads(model), error);
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
 *  that groups are named by; or (is_chosen 0) by those that the library finds, cells as in
 *  io_arrays_find_regions. */
static int apply_arrays(io_model *model, const planish_cells *cells, int is_chosen, int first,
                        planish_error *error) {
    array_view v = {.of = NULL};
    int status = make_view(model, &v, error);
    if (!status && !is_chosen)
        status = find_region_arrays(model, cells, &v, error);
    if (!status)
        status = make_regions(model, &v, is_chosen ? first : find_primary(model), error);
    if (!status)
        status = list_names(model, error);
    release_view(model, &v);
    return status;
}

int io_arrays_find_regions(io_model *model, const planish_cells *cells, planish_error *error) {
    if (model->n_arrays == 0 || io_model_n_elements(model) == 0)
        return PLANISH_OK;
    model->has_entities =
        io_model_elements(model)->entity || io_model_other_elements(model)->entity;
    return apply_arrays(model, cells, 0, -1, error);
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
    return apply_arrays(model, NULL, 1, first, error);
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
