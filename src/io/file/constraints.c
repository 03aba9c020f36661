/* constraints: which nodes a file holds: on its lower elements, marked, between regions, named; and
 * the minimum volumes of the elements of named groups.
 */
#include "io/core/cell_types.h"
#include "io/file/plane.h"
#include "io/file/tags.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/nearer.h"
#include "base/status.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- understanding tags ------------------------------------------------------------------- */

/** Number of a group that is chosen. */
typedef struct chosen_number {
    int dim;
    int32_t number;
    int is_physical; /* entities have it as a physical group */
} chosen_number;

static int compare_numbers(const void *a, const void *b) {
    const chosen_number *x = a, *y = b;
    if (x->dim != y->dim)
        return x->dim < y->dim ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static chosen_number *find_number(chosen_number *numbers, int64_t n, int dim, int32_t number) {
    const chosen_number key = {dim, number, 0};
    return bsearch(&key, numbers, (size_t)n, sizeof key, compare_numbers);
}

/** Choose the entities that have numbers [n], sorted and distinct, as physical groups; of_file: they are
 *  the file's. Returns whether there are any. */
static int choose_physical(const io_model *model, chosen_number *numbers, int64_t n, int of_file,
                           uint8_t *chosen) {
    int is_any = 0;
    for (int32_t i = 0; i < model->n_entities && n > 0; i++) {
        const io_entity *e = &model->entity[i];
        for (int k = 0; k < e->n_physical; k++) {
            const int32_t number =
                of_file ? io_model_file_number(model, e->physical[k]) : e->physical[k];
            chosen_number *found = find_number(numbers, n, e->dim, number);
            if (found)
                is_any = found->is_physical = chosen[i] = 1;
        }
    }
    return is_any;
}

/** Choose the entities whose own tags are numbers [n] that choose_physical did not find. Returns whether
 *  there are any. */
static int choose_own(const io_model *model, chosen_number *numbers, int64_t n, uint8_t *chosen) {
    int is_any = 0;
    for (int32_t i = 0; i < model->n_entities && n > 0; i++) {
        const io_entity *e = &model->entity[i];
        const chosen_number *found = find_number(numbers, n, e->dim, e->tag);
        if (found && !found->is_physical)
            is_any = chosen[i] = 1;
    }
    return is_any;
}

/** Choose the entities (of dimension dim, -1: any) of a number: by physical groups, else by their
 *  own tags. Returns whether there are any. */
static int choose_number(const io_model *model, int dim, int64_t number, uint8_t *chosen) {
    chosen_number numbers[4];
    int n = 0;
    if (number < INT32_MIN || number > INT32_MAX ||
        io_model_file_number(model, (int32_t)number) != number)
        return 0;
    for (int d = 0; d <= 3; d++)
        if (dim < 0 || dim == d)
            numbers[n++] = (chosen_number){d, (int32_t)number, 0};
    return choose_physical(model, numbers, n, 1, chosen) || choose_own(model, numbers, n, chosen);
}

/** Choose the entities of numbers [n], which are sorted for that, each as choose_number does: groups of
 *  one name may be many, and entities, too. */
static void choose_numbers(const io_model *model, chosen_number *numbers, int64_t n,
                           uint8_t *chosen) {
    int64_t n_kept = 0;
    qsort(numbers, (size_t)n, sizeof *numbers, compare_numbers);
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || compare_numbers(&numbers[i], &numbers[n_kept - 1]) != 0)
            numbers[n_kept++] = numbers[i];
    choose_physical(model, numbers, n_kept, 0, chosen);
    choose_own(model, numbers, n_kept, chosen);
}

enum { MOST_LISTED = 10, TAG_SIZE = 64 };

/** Put a tag in a list of n for a message, unless it is in there already. Return how many there are
 *  then; at most MOST_LISTED. */
static int list_tag(char list[][TAG_SIZE], int n, const char *text) {
    char cut[TAG_SIZE];
    snprintf(cut, sizeof cut, "%s", text);
    for (int i = 0; i < n; i++)
        if (strcmp(list[i], cut) == 0)
            return n;
    if (n < MOST_LISTED)
        memcpy(list[n++], cut, sizeof cut);
    return n;
}

/** List the tags of dimension dim (-1: any): "a, b, 3:1, ...". */
static void list_tags(const io_model *model, int dim, char *text, size_t size) {
    enum { LOOKED_AT = 64 }; /* entities that are searched for tags */
    const int32_t n_numbered = model->groups_by_name ? 0 : model->n_entities;
    char list[MOST_LISTED][TAG_SIZE];
    int n = 0;
    for (int32_t i = 0; i < model->n_groups; i++)
        if (dim < 0 || model->group[i].dim == dim)
            n = list_tag(list, n, model->group[i].name);
    for (int32_t i = 0; i < n_numbered && i < LOOKED_AT; i++) {
        const io_entity *entity = &model->entity[i];
        for (int j = 0; j < entity->n_physical || j == 0; j++) {
            char number[TAG_SIZE];
            snprintf(number, sizeof number, "%d:%d", entity->dim,
                     entity->n_physical ? io_model_file_number(model, entity->physical[j])
                                        : entity->tag);
            if (dim < 0 || entity->dim == dim)
                n = list_tag(list, n, number);
        }
    }
    size_t used = (size_t)snprintf(text, size, "%s", n ? list[0] : "none");
    for (int i = 1; i < n && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, ", %s", list[i]);
    if (n == MOST_LISTED && used < size)
        snprintf(text + used, size - used, ", ...");
}

static int is_called(const io_group *group, const char *text) {
    return group->ignores_case ? strcasecmp(group->name, text) == 0
                               : strcmp(group->name, text) == 0;
}

/** Return the dimension of a group of that name, or -1: there is none. */
static int dim_of_group(const io_model *model, const char *text) {
    for (int32_t i = 0; i < model->n_groups; i++)
        if (is_called(&model->group[i], text))
            return model->group[i].dim;
    return -1;
}

/** Fail as there is no group text of dimension dim (-1: any), and say what was perhaps meant. */
static int fail_tag(const io_model *model, const char *text, int dim, planish_error *error) {
    static const char *const kind[] = {"of nodes", "of lines", "of triangles or quadrilaterals",
                                       "of solid elements"};
    const char *path = io_model_opened(model)->path, *nearest = NULL;
    const int found = dim_of_group(model, text);
    char list[256];
    list_tags(model, dim, list, sizeof list);
    if (found >= 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: '%s' is a group %s, but one %s is needed; the file has: %s", path, text,
                       kind[found], kind[dim], list);
    for (int64_t i = 0; i < model->strange_groups.n; i++)
        if (strcasecmp(model->strange_groups.name[i], text) == 0)
            return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                           "%s: '%s' is a *SURFACE that planish does not take as a group; give the "
                           "set of nodes or elements that it is made of",
                           path, text);
    for (int32_t i = 0; i < model->n_groups; i++)
        if (dim < 0 || model->group[i].dim == dim)
            nearest = pl_nearer(text, nearest, model->group[i].name);
    if (nearest)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: there is no group '%s' %s; did you mean '%s'?", path, text,
                       dim < 0 ? "to hold" : kind[dim], nearest);
    return pl_fail(error, PLANISH_ERROR_ARGUMENT, "%s: there is no group '%s' %s; the file has: %s",
                   path, text, dim < 0 ? "to hold" : kind[dim], list);
}

/** Choose the entities of the group that text names, among those of dimension dim (-1: any): by its
 *  name, or by a number, which entities have or which only a name knows. */
static int choose_tag(const io_model *model, const char *text, int dim, uint8_t *chosen,
                      planish_error *error) {
    io_tag t = io_tag_parse(text, dim);
    t.has_number = t.has_number && !model->groups_by_name;
    int found = 0;
    int64_t n = 0;
    chosen_number *numbers = pl_alloc(model->n_groups, sizeof *numbers);
    if (!numbers)
        return pl_fail_memory(error, "the groups of nodes");
    for (int32_t i = 0; i < model->n_groups; i++) {
        const io_group *group = &model->group[i];
        if (dim >= 0 && group->dim != dim)
            continue;
        if (!is_called(group, text) &&
            !(t.has_number && io_model_file_number(model, group->tag) == t.number &&
              (t.dim < 0 || t.dim == group->dim)))
            continue;
        numbers[n++] = (chosen_number){group->dim, group->tag, 0};
        found = 1;
    }
    choose_numbers(model, numbers, n, chosen);
    pl_free(numbers);
    if (t.has_number && (dim < 0 || t.dim == dim))
        found |= choose_number(model, t.dim, t.number, chosen);
    return found ? PLANISH_OK : fail_tag(model, text, dim, error);
}

/** Choose the entities of n tags: *chosen [n_entities], owned, in any case. */
static int choose_tags(const io_model *model, const char *const *tags, int n, int dim,
                       uint8_t **chosen, planish_error *error) {
    *chosen = pl_alloc_zero(model->n_entities, 1);
    int status = *chosen ? PLANISH_OK : pl_fail_memory(error, "the groups of nodes");
    for (int i = 0; i < n && !status; i++)
        status = choose_tag(model, tags[i], dim, *chosen, error);
    return status;
}

static int are_given(const char *const *tags, int n) {
    for (int i = 0; i < n; i++)
        if (!tags || !tags[i])
            return 0;
    return n >= 0;
}

/* ---- holding ------------------------------------------------------------------------------ */

/* Functions that hold nodes set a bit in flags [n_nodes]. */

/** Hold the nodes, mids among them, of the first n elements of a list that are of a chosen entity. */
static void hold_list(const io_list *list, int64_t n, const uint8_t *chosen, uint8_t bit,
                      uint8_t *flags) {
    int32_t node[IO_CELL_NODES];
    for (int64_t i = 0; list->entity && i < n; i++) {
        if (!chosen[list->entity[i]])
            continue;
        const int n_nodes = io_list_nodes(list, i, node, NULL);
        for (int j = 0; j < n_nodes; j++)
            flags[node[j]] |= bit;
    }
}

/** Hold the nodes of the groups that hold names. */
static int hold_tags(const io_model *model, const planish_hold *hold, uint8_t bit, uint8_t *flags,
                     planish_error *error) {
    uint8_t *chosen = NULL;
    if (!hold || hold->n_tags == 0)
        return PLANISH_OK;
    const int status = choose_tags(model, hold->tags, hold->n_tags, -1, &chosen, error);
    if (!status) {
        for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
            const io_list list = io_model_list(model, k);
            hold_list(&list, list.n, chosen, bit, flags);
        }
        for (int64_t i = 0; model->node_entity && i < model->n_nodes; i++)
            if (model->node_entity[i] >= 0 && chosen[model->node_entity[i]])
                flags[i] |= bit;
    }
    pl_free(chosen);
    return status;
}

/** Return the simplices that facets of the mesh are; of a surface in space its edges. */
static const io_cells *facet_cells(const io_model *model) {
    return io_model_dim(model) == 3 ? &model->triangle : &model->line;
}

/** Hold the nodes of facets that are in none of the groups to be slid on. */
static int hold_unchosen(const io_model *model, const planish_hold *hold, uint8_t *constraint,
                         planish_error *error) {
    const int dim = io_model_dim(model) - 1;
    const io_list simplices = io_model_list(model, dim);
    const io_list others = io_model_list(model, IO_FLAT_LIST);
    uint8_t *chosen = NULL;
    const int status =
        choose_tags(model, hold->slide_tags, hold->n_slide_tags, dim, &chosen, error);
    for (int32_t i = 0; i < model->n_entities && !status; i++)
        chosen[i] = !chosen[i];
    if (!status)
        hold_list(&simplices, io_cells_telling(simplices.cells), chosen, PLANISH_CONSTRAINT_FIXED,
                  constraint);
    if (!status && dim == 2)
        hold_list(&others, io_others_telling(others.others), chosen, PLANISH_CONSTRAINT_FIXED,
                  constraint);
    pl_free(chosen);
    return status;
}

/** Hold the nodes of elements of different regions, unless regions are to be ignored: also mids, which may
 *  move on their own elsewhere. */
static int hold_interfaces(const planish_file *file, const planish_hold *hold, uint8_t bit,
                           uint8_t *flags, planish_error *error) {
    const io_model *model = &file->model;
    const int32_t *of_cell = io_file_regions(file);
    const int lists[] = {io_model_dim(model), io_others_list(io_model_dim(model))};
    int64_t element = 0;
    if (file->n_regions <= 1 || (hold && hold->ignore_regions))
        return PLANISH_OK;
    int32_t *region = pl_alloc(file->model.n_nodes, sizeof *region);
    if (!region)
        return pl_fail_memory(error, "the regions of nodes");
    for (int64_t i = 0; i < file->model.n_nodes; i++)
        region[i] = -1;
    for (int k = 0; k < 2; k++) {
        const io_list list = io_model_list(model, lists[k]);
        for (int64_t i = 0; i < list.n; i++) {
            int32_t node[IO_CELL_NODES], here = of_cell[element++];
            const int n = io_list_nodes(&list, i, node, NULL);
            for (int j = 0; j < n; j++) {
                if (region[node[j]] < 0)
                    region[node[j]] = here;
                else if (region[node[j]] != here)
                    flags[node[j]] |= bit;
            }
        }
    }
    pl_free(region);
    return PLANISH_OK;
}

/** Check hold, which may be NULL. */
static int check_hold(const planish_hold *hold, planish_error *error) {
    if (!hold)
        return PLANISH_OK;
    if (!are_given(hold->tags, hold->n_tags) || !are_given(hold->slide_tags, hold->n_slide_tags))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "hold: there are fewer tags than n_tags and n_slide_tags say");
    return pl_check_reserved("planish_hold", hold->reserved, sizeof hold->reserved, error);
}

int planish_file_constraints(const planish_file *file, const planish_hold *hold,
                             uint8_t *constraint, planish_error *error) {
    if (!file || !constraint)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and constraint must not be NULL");
    int status = check_hold(hold, error);
    if (status)
        return status;
    const io_model *model = &file->model;
    const int slide = hold && hold->slide;
    const unsigned periodic = io_model_is_surface(model) ? 0 : IO_HELD_PERIODIC; /* has no pairs */
    const unsigned undecided = (slide ? IO_HELD_BY_LINE | IO_HELD_BY_FACE | periodic : 0) |
                               (hold && hold->ignore_marked ? IO_HELD_MARKED : 0) |
                               IO_HAS_PARAMETERS;
    uint8_t *found = pl_alloc(model->n_nodes, 1);
    status = found ? PLANISH_OK : pl_fail_memory(error, "the constraints of nodes");
    for (int64_t i = 0; i < model->n_nodes && !status; i++)
        found[i] = model->hold[i] & ~undecided ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
    if (!status && slide && hold->n_slide_tags > 0)
        status = hold_unchosen(model, hold, found, error);
    if (!status && !slide)
        status = hold_interfaces(file, hold, PLANISH_CONSTRAINT_FIXED, found, error);
    if (!status)
        status = hold_tags(model, hold, PLANISH_CONSTRAINT_FIXED, found, error);
    if (!status)
        memcpy(constraint, found, (size_t)model->n_nodes);
    pl_free(found);
    return status;
}

int planish_file_get_held(const planish_file *file, const planish_hold *hold, uint8_t *reason,
                          planish_error *error) {
    if (!file || !reason)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and reason must not be NULL");
    int status = check_hold(hold, error);
    if (status)
        return status;
    uint8_t *found = pl_alloc(file->model.n_nodes, 1);
    status = found ? PLANISH_OK : pl_fail_memory(error, "the reasons of nodes");
    const unsigned required = IO_HELD_REQUIRED | (hold && hold->ignore_marked ? 0 : IO_HELD_MARKED);
    for (int64_t i = 0; i < file->model.n_nodes && !status; i++) {
        const unsigned bits = file->model.hold[i];
        found[i] =
            (uint8_t)((bits & (IO_HELD_BY_POINT | IO_HELD_BY_LINE) ? PLANISH_FILE_LINE_OR_POINT
                                                                   : 0) |
                      (bits & IO_HELD_BY_FACE ? PLANISH_FILE_FACE : 0) |
                      (bits & IO_HELD_BY_OTHER ? PLANISH_FILE_OTHER_ELEMENT : 0) |
                      (bits & IO_HELD_PERIODIC ? PLANISH_FILE_PERIODIC : 0) |
                      (bits & required ? PLANISH_FILE_REQUIRED : 0));
    }
    if (!status)
        status = hold_interfaces(file, hold, PLANISH_FILE_INTERFACE, found, error);
    if (!status)
        status = hold_tags(&file->model, hold, PLANISH_FILE_FIX, found, error);
    if (!status)
        memcpy(reason, found, (size_t)file->model.n_nodes);
    pl_free(found);
    return status;
}

/** Count the nodes that have a bit of io_model.hold; has [n_nodes], or NULL, says which. */
static int64_t count_nodes(const planish_file *file, uint8_t bit, uint8_t *has) {
    int64_t n = 0;
    for (int64_t i = 0; file && i < file->model.n_nodes; i++) {
        const uint8_t has_it = (file->model.hold[i] & bit) != 0;
        n += has_it;
        if (has)
            has[i] = has_it;
    }
    return n;
}

int64_t planish_file_get_marked(const planish_file *file, uint8_t *marked) {
    return count_nodes(file, IO_HELD_MARKED, marked);
}

int64_t planish_file_get_parametric(const planish_file *file, uint8_t *parametric) {
    return count_nodes(file, IO_HAS_PARAMETERS, parametric);
}

int64_t planish_file_get_supported(const planish_file *file, uint8_t *supported) {
    int64_t n = 0;
    for (int64_t i = 0; file && i < file->model.n_nodes; i++) {
        const uint8_t is = file->model.supported && file->model.supported[i];
        n += is;
        if (supported)
            supported[i] = is;
    }
    return n;
}

planish_surface planish_file_surface(const planish_file *file, const planish_hold *hold) {
    if (!file)
        return (planish_surface){.n_facets = 0};
    const pl_outside outside = pl_call_enter(NULL);
    const io_model *model = &file->model;
    const io_cells *facets = facet_cells(model);
    const int is_surface = io_model_is_surface(model);
    planish_surface surface = {.region =
                                   hold && hold->ignore_regions ? NULL : io_file_regions(file),
                               .n_facets = is_surface ? 0 : io_cells_telling(facets),
                               .facets = facets->nodes,
                               .facet_tag = io_cells_regions(facets),
                               .tagged_only = !is_surface && hold && hold->n_slide_tags > 0,
                               .tolerance = io_tolerance_of_digits(model, file->format)};
    if (file->facet_offset) {
        surface.n_facets += io_others_telling(&model->flat);
        surface.facets = file->facet;
        surface.facet_offset = file->facet_offset;
        surface.facet_tag = file->facet_tag;
    }
    if (model->dim == 3) {
        surface.n_edges = io_cells_telling(&model->line);
        surface.edges = model->line.nodes;
        surface.edge_tag = io_cells_regions(&model->line);
    }
    pl_call_leave(&outside);
    return surface;
}

/* ---- minimum volumes ------------------------------------------------------------------------ */

int planish_file_min_volumes(const planish_file *file, const char *const *tags,
                             const double *values, int n_tags, double *min_volume,
                             planish_error *error) {
    if (!file || !min_volume || !are_given(tags, n_tags) || (n_tags > 0 && !values))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, min_volume and each of n_tags tags and values must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    const io_model *model = &file->model;
    double *least = pl_alloc_zero(model->n_entities, sizeof *least);
    int status = least ? PLANISH_OK : pl_fail_memory(error, "minimum volumes of groups");
    for (int i = 0; i < n_tags && !status; i++) {
        uint8_t *chosen = NULL;
        if (values[i] > 0 && values[i] <= DBL_MAX)
            status = choose_tags(model, &tags[i], 1, io_model_dim(model), &chosen, error);
        else
            status =
                pl_fail(error, PLANISH_ERROR_ARGUMENT,
                        "the minimum volume of group '%s' must be positive and finite", tags[i]);
        for (int32_t k = 0; k < model->n_entities && !status; k++)
            if (chosen[k] && values[i] > least[k])
                least[k] = values[i];
        pl_free(chosen);
    }
    for (int64_t i = 0; i < io_model_n_elements(model) && !status; i++) {
        const int32_t entity = io_element_entity(model, i);
        min_volume[i] = entity >= 0 ? least[entity] : 0;
    }
    pl_free(least);
    pl_call_leave(&outside);
    return status;
}
