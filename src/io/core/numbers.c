/* numbers: from the file's node numbers to indices, whatever their order and gaps. */
#include "io/core/copies.h"
#include "io/core/model.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>

/* Up to this many places per number (and a few) a table by number beats a search. */
enum { PLACES_PER_NUMBER = 4, PLACES_AT_LEAST = 1024 };

typedef struct numbered {
    int64_t number;
    int32_t index;
} numbered;

struct io_numbers {
    const char *path, *what; /* of the file, and of what has numbers */
    int64_t n, first, last;  /* numbers first .. last occur */
    int32_t *place;          /* [last - first + 1] index or -1; NULL: see sorted */
    numbered *sorted;        /* [n] by number */
};

static int fail_twice(const io_numbers *table, int64_t number, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: %s number %lld occurs twice", table->path,
                   table->what, (long long)number);
}

static int fill_table(io_numbers *table, const int64_t *numbers, planish_error *error) {
    int64_t places = table->last - table->first + 1;
    table->place = pl_alloc(places, sizeof *table->place);
    if (!table->place)
        return pl_fail_memory(error, "node numbers");
    for (int64_t i = 0; i < places; i++)
        table->place[i] = -1;
    for (int64_t i = 0; i < table->n; i++) {
        int32_t *place = &table->place[numbers[i] - table->first];
        if (*place >= 0)
            return fail_twice(table, numbers[i], error);
        *place = (int32_t)i;
    }
    return PLANISH_OK;
}

static int compare(const void *a, const void *b) {
    int64_t p = ((const numbered *)a)->number, q = ((const numbered *)b)->number;
    return (p > q) - (p < q);
}

static int fill_sorted(io_numbers *table, const int64_t *numbers, planish_error *error) {
    table->sorted = pl_alloc(table->n, sizeof *table->sorted);
    if (!table->sorted)
        return pl_fail_memory(error, "node numbers");
    for (int64_t i = 0; i < table->n; i++)
        table->sorted[i] = (numbered){numbers[i], (int32_t)i};
    qsort(table->sorted, (size_t)table->n, sizeof *table->sorted, compare);
    for (int64_t i = 1; i < table->n; i++)
        if (table->sorted[i].number == table->sorted[i - 1].number)
            return fail_twice(table, table->sorted[i].number, error);
    return PLANISH_OK;
}

int io_numbers_create(const char *path, const char *what, const int64_t *numbers, int64_t n,
                      io_numbers **out, planish_error *error) {
    io_numbers *table = pl_alloc_zero(1, sizeof *table);
    if (!table)
        return pl_fail_memory(error, "node numbers");
    table->path = path;
    table->what = what;
    table->n = n;
    table->first = n ? INT64_MAX : 0;
    table->last = n ? INT64_MIN : -1;
    for (int64_t i = 0; i < n; i++) {
        table->first = numbers[i] < table->first ? numbers[i] : table->first;
        table->last = numbers[i] > table->last ? numbers[i] : table->last;
    }
    uint64_t range = (uint64_t)table->last - (uint64_t)table->first;
    int dense = range < (uint64_t)n * PLACES_PER_NUMBER + PLACES_AT_LEAST;
    int status = dense ? fill_table(table, numbers, error) : fill_sorted(table, numbers, error);
    if (status)
        io_numbers_destroy(table);
    else
        *out = table;
    return status;
}

static int are_consecutive(const int64_t *number, int64_t n) {
    if (n == 0 || number[0] > INT64_MAX - n)
        return 0;
    for (int64_t i = 1; i < n; i++)
        if (number[i] != number[0] + i)
            return 0;
    return 1;
}

static int create_node_numbers(const io_model *model, io_numbers **table, planish_error *error) {
    return io_numbers_create(model->input.path, "node", model->node_number, model->n_nodes, table,
                             error);
}

/** The first number if that tells all, or a table of them. */
static int keep_first_number(io_model *model, io_numbers **table, planish_error *error) {
    if (!are_consecutive(model->node_number, model->n_nodes))
        return create_node_numbers(model, table, error);
    model->first_number = model->node_number[0];
    pl_free(model->node_number);
    model->node_number = NULL;
    return PLANISH_OK;
}

/** Numbers are looked at for copies only where one occurs twice. */
int io_settle_node_numbers(io_model *model, io_numbers **table, planish_error *error) {
    if (!are_consecutive(model->node_number, model->n_nodes)) {
        planish_error twice = {.text = ""};
        const int status = create_node_numbers(model, table, &twice);
        if (status != PLANISH_ERROR_FORMAT) {
            if (status && error)
                *error = twice;
            return status;
        }
        const int united = io_unite_copies(model, error);
        if (united)
            return united;
    }
    return keep_first_number(model, table, error);
}

void io_settle_cell_numbers(io_cells *cells) {
    if (!cells->number || !are_consecutive(cells->number, cells->n))
        return;
    cells->first_number = cells->number[0];
    pl_free(cells->number);
    cells->number = NULL;
}

int64_t io_numbers_find(const io_numbers *table, int64_t number) {
    if (number < table->first || number > table->last)
        return -1;
    if (table->place)
        return table->place[number - table->first];
    numbered key = {number, 0};
    const numbered *found = bsearch(&key, table->sorted, (size_t)table->n, sizeof key, compare);
    return found ? found->index : -1;
}

void io_numbers_destroy(io_numbers *table) {
    if (!table)
        return;
    pl_free(table->place);
    pl_free(table->sorted);
    pl_free(table);
}
