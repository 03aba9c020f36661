/* levels: levels of nodes in columns that simplices join. */
#include "shape/levels.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>

/* A simplex tells the levels of columns if its other nodes are within this part of a height of one of
 * the ends of its upright. */
static const double LEVEL = 0.3;

/** Levels of columns that stand beside each other, being found. */
typedef struct levels {
    pl_columns *c;
    int32_t *place;  /* [n_nodes] in c->node, -1: in no column, -2: in several */
    int32_t *of;     /* [n_uprights + n_columns] the column of what is there */
    int8_t *way;     /* [n_columns] +1, -1: the level rises, falls with the place; 0: not known */
    int32_t *base;   /* [n_columns] level of the first node */
    int8_t *elected; /* [n_columns] way and base are being voted for: the one that leads, */
    int32_t *votes;  /* [n_columns] and by how much */
    uint8_t *is_listed; /* [n_columns] 1: votes have been heard */
    int64_t *first;     /* [n_columns + 1] in cell */
    int32_t *cell;      /* elements at each column */
} levels;

static int32_t level_at(const levels *l, int32_t place) {
    const int32_t column = l->of[place];
    const int64_t k = place - (l->c->begin[column] + column);
    return (int32_t)(l->base[column] + l->way[column] * k);
}

/** The upright of a column that is between a level and the next one; -1: it has none. */
static int32_t upright_between(const levels *l, int32_t column, int32_t level) {
    const pl_columns *c = l->c;
    const int64_t k = l->way[column] > 0 ? level - l->base[column] : l->base[column] - level - 1;
    return k >= 0 && k < c->begin[column + 1] - c->begin[column] ? c->upright[c->begin[column] + k]
                                                                 : -1;
}

/** Direction of a column, from its first node to the last. */
static void direction_of(const pl_columns *c, int32_t column, double way[3]) {
    pl_columns_edge(c, c->node[c->begin[column] + column], c->node[c->begin[column + 1] + column],
                    way);
}

/** Whether corner p of a simplex is as high as one of the ends of its upright, *is_upper which; 0: as
 *  none, or the upright is not along its column. */
static int find_level(const levels *l, const int32_t *node, const pl_layer_cell *cell, int p,
                      int *is_upper) {
    const pl_columns *c = l->c;
    double up[3], to[3], way[3];
    pl_columns_edge(c, node[cell->end[0]], node[cell->end[1]], up);
    pl_columns_edge(c, node[cell->end[0]], node[p], to);
    direction_of(c, c->column[cell->upright[0]], way);
    const double square = pl_dot(3, up, up), part = pl_dot(3, to, up) / square;
    const int rises = l->place[node[cell->end[1]]] > l->place[node[cell->end[0]]];
    const double along = rises ? pl_dot(3, up, way) : -pl_dot(3, up, way);
    *is_upper = part > 0.5;
    return square > 0 && fabs(part - *is_upper) <= LEVEL && along > 0 &&
           along * along >= 0.5 * square * pl_dot(3, way, way);
}

/** Vote for the base and way of the column of corner p of a simplex, or of its upright's, from those of
 *  the other one. Return the column; -1: both or none are known, or the simplex does not tell. */
static int32_t vote(levels *l, const pl_layer_cell *cell, int p) {
    const pl_columns *c = l->c;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[cell->cell];
    const int32_t own = c->column[cell->upright[0]], at = l->place[node[p]];
    int is_upper;
    if (l->place[node[cell->end[0]]] < 0 || l->place[node[cell->end[1]]] < 0 || at < 0 ||
        (l->way[own] == 0) == (l->way[l->of[at]] == 0) || !find_level(l, node, cell, p, &is_upper))
        return -1;
    /* Both places have one level. */
    const int32_t mine = l->place[node[cell->end[is_upper]]];
    const int32_t known = l->way[own] == 0 ? at : mine, new = l->way[own] == 0 ? mine : at;
    const int32_t column = l->of[new];
    double a[3], b[3];
    direction_of(c, l->of[known], a);
    direction_of(c, column, b);
    const int way = pl_dot(3, a, b) < 0 ? -l->way[l->of[known]] : l->way[l->of[known]];
    const int64_t k = new - (c->begin[column] + column);
    const int32_t base = (int32_t)(level_at(l, known) - way * k);
    const int is_same = l->elected[column] == way && l->base[column] == base;
    if (l->votes[column] == 0) {
        l->elected[column] = (int8_t)way;
        l->base[column] = base;
    }
    l->votes[column] += l->votes[column] == 0 || is_same ? 1 : -1;
    return column;
}

/** Spread levels from a column on: each one beside it gets those that most simplices between them tell
 *  (Boyer and Moore 1991). Squeezed rows tell wrong ones. queue [n_columns]. */
static void spread(levels *l, int32_t column, int32_t *queue) {
    int64_t n = 1;
    l->way[column] = 1;
    queue[0] = column;
    for (int64_t k = 0; k < n; k++) {
        int64_t n_new = n;
        for (int64_t i = l->first[queue[k]]; i < l->first[queue[k] + 1]; i++) {
            const pl_layer_cell *cell = &l->c->cell[l->cell[i]];
            for (int p = 0; p <= l->c->mesh->dim; p++) {
                const int32_t found =
                    p == cell->end[0] || p == cell->end[1] ? -1 : vote(l, cell, p);
                if (found >= 0 && !l->is_listed[found])
                    queue[n_new++] = found;
                if (found >= 0)
                    l->is_listed[found] = 1;
            }
        }
        for (int64_t i = n; i < n_new; i++) {
            l->is_listed[queue[i]] = l->votes[queue[i]] > 0;
            if (l->votes[queue[i]] > 0) {
                l->way[queue[i]] = l->elected[queue[i]];
                queue[n++] = queue[i];
            }
        }
    }
}

static int is_simplex(const pl_columns *c, const pl_layer_cell *cell) {
    return pl_cell_type_of(c->mesh->cells->type[cell->cell])->shape->n_simplices == 1;
}

/** List the simplices at each column: count them, or put them there. */
static void list_at_columns(levels *l, int is_count) {
    const pl_columns *c = l->c;
    for (int64_t i = 0; i < c->n_cells; i++) {
        const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[c->cell[i].cell];
        for (int p = 0; is_simplex(c, &c->cell[i]) && p <= c->mesh->dim; p++) {
            const int32_t at = l->place[node[p]];
            if (at < 0)
                continue;
            if (is_count)
                l->first[l->of[at] + 1]++;
            else
                l->cell[l->first[l->of[at]]++] = (int32_t)i;
        }
    }
}

/** Note the levels of a simplex, and the uprights beside its own. */
static void note_levels(const levels *l, pl_layer_cell *cell) {
    const pl_columns *c = l->c;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[cell->cell];
    const int32_t low = l->place[node[cell->end[0]]], high = l->place[node[cell->end[1]]];
    if (low < 0 || high < 0)
        return;
    const int32_t from = level_at(l, low), to = level_at(l, high), least = from < to ? from : to;
    int is_level = 1;
    for (int p = 0; p <= c->mesh->dim; p++) {
        const int32_t at = l->place[node[p]];
        const int32_t level = at >= 0 ? level_at(l, at) : least - 1;
        is_level &= level == from || level == to;
        cell->level = (uint8_t)(cell->level | (level == to) << p);
        const int32_t beside =
            level == from || level == to ? upright_between(l, l->of[at], least) : -1;
        int is_new = beside >= 0;
        for (int k = 0; k < cell->n_uprights; k++)
            is_new &= cell->upright[k] != beside;
        if (is_new)
            cell->upright[cell->n_uprights++] = beside;
    }
    cell->is_level = (uint8_t)is_level;
}

/** Find the places of nodes in columns. */
static void find_places(levels *l) {
    const pl_columns *c = l->c;
    for (int64_t i = 0; i < c->mesh->n_nodes; i++)
        l->place[i] = -1;
    for (int32_t k = 0; k < c->n_columns; k++)
        for (int64_t i = c->begin[k] + k; i <= c->begin[k + 1] + k; i++) {
            l->of[i] = k;
            l->place[c->node[i]] = l->place[c->node[i]] == -1 ? (int32_t)i : -2;
        }
}

int pl_columns_find_levels(pl_columns *c, planish_error *error) {
    const int64_t n_places = c->n_uprights + c->n_columns;
    levels l = {.c = c};
    l.place = pl_alloc(c->mesh->n_nodes, sizeof *l.place);
    l.of = pl_alloc(n_places, sizeof *l.of);
    l.way = pl_alloc_zero(c->n_columns, sizeof *l.way);
    l.base = pl_alloc_zero(c->n_columns, sizeof *l.base);
    l.elected = pl_alloc_zero(c->n_columns, sizeof *l.elected);
    l.votes = pl_alloc_zero(c->n_columns, sizeof *l.votes);
    l.is_listed = pl_alloc_zero(c->n_columns, sizeof *l.is_listed);
    l.first = pl_alloc_zero(c->n_columns + 2, sizeof *l.first);
    l.cell = pl_alloc(c->n_cells * (c->mesh->dim + 1), sizeof *l.cell);
    int32_t *queue = pl_alloc(c->n_columns, sizeof *queue);
    const int is_there = l.place && l.of && l.way && l.base && l.elected && l.votes &&
                         l.is_listed && l.first && l.cell && queue;
    if (is_there) {
        find_places(&l);
        l.first++; /* counts end up at the beginning of the next column */
        list_at_columns(&l, 1);
        for (int64_t k = 0; k < c->n_columns; k++)
            l.first[k + 1] += l.first[k];
        list_at_columns(&l, 0);
        l.first--;
        for (int32_t k = 0; k < c->n_columns; k++)
            if (l.way[k] == 0)
                spread(&l, k, queue);
        for (int64_t i = 0; i < c->n_cells; i++)
            if (is_simplex(c, &c->cell[i]))
                note_levels(&l, &c->cell[i]);
    }
    pl_free(l.place);
    pl_free(l.of);
    pl_free(l.way);
    pl_free(l.base);
    pl_free(l.elected);
    pl_free(l.votes);
    pl_free(l.is_listed);
    pl_free(l.first);
    pl_free(l.cell);
    pl_free(queue);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "the columns of layers");
}
