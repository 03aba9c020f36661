/* numbers: from the file's node numbers to indices, whatever their order and gaps; and nodes that a
 * file gives more than once, with the same coordinates.
 *
 * The model has each of these once, at the index of the first; the places in the file stay as they
 * are, and what is written goes to all of them. Programs that own such formats take the same node
 * again, too. One that is given at different places is refused: which is meant, nobody knows.
 */
#include "base/hash.h"
#include "base/memory.h"
#include "base/status.h"
#include "io/core/model.h"

#include <stdlib.h>
#include <string.h>

/* Up to this many places per number (and a few) a table by number beats a search. */
enum { PLACES_PER_NUMBER = 4, PLACES_AT_LEAST = 1024 };

typedef struct numbered {
    int64_t number;
    int32_t index;
} numbered;

static int compare_numbers(const void *a, const void *b) {
    const int64_t p = ((const numbered *)a)->number, q = ((const numbered *)b)->number;
    return (p > q) - (p < q);
}

/** By number, then by index. */
static int compare_copies(const void *a, const void *b) {
    const int32_t p = ((const numbered *)a)->index, q = ((const numbered *)b)->index;
    const int order = compare_numbers(a, b);
    return order ? order : (p > q) - (p < q);
}

/** The numbers [n] with their indices, sorted; owned, NULL without memory. */
static numbered *sort_numbers(const int64_t *numbers, int64_t n) {
    numbered *sorted = pl_alloc(n, sizeof *sorted);
    for (int64_t i = 0; sorted && i < n; i++)
        sorted[i] = (numbered){numbers[i], (int32_t)i};
    if (sorted && n > 0)
        qsort(sorted, (size_t)n, sizeof *sorted, compare_copies);
    return sorted;
}

/* ---- a table of numbers -------------------------------------------------------------------- */

struct io_numbers {
    int64_t n, first, last; /* numbers first .. last occur */
    int32_t *index;         /* [last - first + 1] index or -1; NULL: see sorted */
    numbered *sorted;       /* [n] by number */
};

int io_numbers_create(const char *path, const char *what, const int64_t *numbers, int64_t n,
                      io_numbers **out, planish_error *error) {
    io_numbers *table = pl_alloc_zero(1, sizeof *table);
    if (!table)
        return pl_fail_memory(error, "node numbers");
    int64_t first = n ? INT64_MAX : 0, last = n ? INT64_MIN : -1, twice = -1;
    for (int64_t i = 0; i < n; i++) {
        first = numbers[i] < first ? numbers[i] : first;
        last = numbers[i] > last ? numbers[i] : last;
    }
    const uint64_t range = (uint64_t)last - (uint64_t)first;
    if (range < (uint64_t)n * PLACES_PER_NUMBER + PLACES_AT_LEAST) {
        table->index = pl_alloc((int64_t)range + 1, sizeof *table->index);
        for (int64_t i = 0; table->index && i <= last - first; i++)
            table->index[i] = -1;
        for (int64_t i = 0; table->index && i < n && twice < 0; i++) {
            int32_t *index = &table->index[numbers[i] - first];
            twice = *index < 0 ? -1 : i;
            *index = (int32_t)i;
        }
    } else {
        table->sorted = sort_numbers(numbers, n);
        for (int64_t i = 1; table->sorted && i < n && twice < 0; i++)
            if (table->sorted[i].number == table->sorted[i - 1].number)
                twice = table->sorted[i].index;
    }
    table->n = n;
    table->first = first;
    table->last = last;
    int status = PLANISH_OK;
    if (!table->index && !table->sorted)
        status = pl_fail_memory(error, "node numbers");
    else if (twice >= 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: %s number %lld occurs twice", path, what,
                         (long long)numbers[twice]);
    if (status)
        io_numbers_destroy(table);
    else
        *out = table;
    return status;
}

int64_t io_numbers_find(const io_numbers *table, int64_t number) {
    if (number < table->first || number > table->last)
        return -1;
    if (table->index)
        return table->index[number - table->first];
    const numbered key = {number, 0};
    const numbered *found =
        bsearch(&key, table->sorted, (size_t)table->n, sizeof key, compare_numbers);
    return found ? found->index : -1;
}

void io_numbers_destroy(io_numbers *table) {
    if (!table)
        return;
    pl_free(table->index);
    pl_free(table->sorted);
    pl_free(table);
}

/* ---- copies of nodes ----------------------------------------------------------------------- */

void io_unite_places(io_model *model, int32_t *first) {
    const int64_t n = model->n_nodes;
    int32_t kept = 0;
    /* Close the gaps that copies leave; first becomes the node of each place. */
    for (int64_t i = 0; i < n; i++) {
        if (first[i] != i) { /* the first stands before it, and is a node already */
            first[i] = first[first[i]];
            model->hold[first[i]] |= model->hold[i];
            continue;
        }
        memmove(model->xyz + 3 * (int64_t)kept, model->xyz + 3 * i, 3 * sizeof *model->xyz);
        if (model->node_number)
            model->node_number[kept] = model->node_number[i];
        model->hold[kept] = model->hold[i];
        first[i] = kept++;
    }
    model->n_nodes = kept;
    model->n_places = n;
    model->place_node = first;
}

/** Make one node of all that have the same number: model->place_node. Fail if their coordinates
 *  differ. */
static int unite_copies(io_model *model, planish_error *error) {
    const int64_t n = model->n_nodes;
    int32_t *first = pl_alloc(n, sizeof *first); /* place of the same number, the first */
    numbered *sorted = sort_numbers(model->node_number, n);
    int status = first && sorted ? PLANISH_OK : pl_fail_memory(error, "node numbers");
    for (int64_t i = 0, begin = 0; i < n && !status; i++) {
        if (sorted[i].number != sorted[begin].number)
            begin = i;
        first[sorted[i].index] = sorted[begin].index;
        const double *a = model->xyz + 3 * (int64_t)sorted[begin].index;
        const double *b = model->xyz + 3 * (int64_t)sorted[i].index;
        if (a[0] != b[0] || a[1] != b[1] || a[2] != b[2])
            status = pl_fail(error, PLANISH_ERROR_FORMAT,
                             "%s: node number %lld occurs twice, at different places",
                             model->input.path, (long long)sorted[i].number);
    }
    pl_free(sorted);
    if (status) {
        pl_free(first);
        return status;
    }
    io_unite_places(model, first);
    return PLANISH_OK;
}

/* ---- points given again --------------------------------------------------------------------- */

/** The hash of a point; -0 is 0. */
static uint64_t hash_of(pl_hash hash, const double xyz[3]) {
    for (int d = 0; d < 3; d++) {
        const double value = xyz[d] + 0.0;
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        pl_hash_add(&hash, bits);
    }
    return pl_hash_end(hash);
}

static int is_same_point(const double a[3], const double b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

int io_weld_nodes(io_model *model, planish_error *error) {
    const int64_t n = model->n_nodes;
    int64_t n_slots = 1, n_copies = 0;
    while (n_slots < 2 * n)
        n_slots *= 2;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot), *first = pl_alloc(n, sizeof *first);
    if (!slot || !first) {
        pl_free(slot);
        pl_free(first);
        return pl_fail_memory(error, "the points of the file");
    }
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    const pl_hash hash = pl_hash_draw(slot);
    for (int64_t i = 0; i < n; i++) {
        const double *xyz = model->xyz + 3 * i;
        int64_t at = (int64_t)(hash_of(hash, xyz) & (uint64_t)(n_slots - 1));
        while (slot[at] >= 0 && !is_same_point(model->xyz + 3 * (int64_t)slot[at], xyz))
            at = (at + 1) & (n_slots - 1);
        n_copies += slot[at] >= 0;
        first[i] = slot[at] = slot[at] < 0 ? (int32_t)i : slot[at];
    }
    pl_free(slot);
    if (n_copies > 0)
        io_unite_places(model, first);
    else
        pl_free(first);
    return PLANISH_OK;
}

/* ---- numbers of a model -------------------------------------------------------------------- */

static int are_consecutive(const int64_t *number, int64_t n) {
    if (n == 0 || number[0] > INT64_MAX - n)
        return 0;
    for (int64_t i = 1; i < n; i++)
        if (number[i] != number[0] + i)
            return 0;
    return 1;
}

int io_reduce_node_numbers(io_model *model, planish_error *error) {
    if (!are_consecutive(model->node_number, model->n_nodes)) {
        planish_error twice = {.text = ""};
        int status = io_numbers_create(model->input.path, "node", model->node_number,
                                       model->n_nodes, &model->numbers, &twice);
        if (status && status != PLANISH_ERROR_FORMAT && error)
            *error = twice;
        if (status != PLANISH_ERROR_FORMAT)
            return status;
        /* Only where a number occurs twice are copies looked for. */
        status = unite_copies(model, error);
        if (status)
            return status;
        if (!are_consecutive(model->node_number, model->n_nodes))
            return io_numbers_create(model->input.path, "node", model->node_number, model->n_nodes,
                                     &model->numbers, error);
    }
    model->first_number = model->node_number[0];
    pl_free(model->node_number);
    model->node_number = NULL;
    return PLANISH_OK;
}

void io_reduce_cell_numbers(io_cells *cells) {
    if (!cells->number || !are_consecutive(cells->number, cells->n))
        return;
    cells->first_number = cells->number[0];
    pl_free(cells->number);
    cells->number = NULL;
}
