/* foam_patches: the patches of the boundary, and zones: sets of faces, cells and points with names.
 *
 * Nodes of patches whose shape means something to a solver, or which belong to those of another patch,
 * are held: of all types but the plain ones. Those of two patches that are cyclic are periodic, node
 * by node.
 */
#include "io/foam/foam_patches.h"
#include "io/foam/foam_list.h"

#include "io/core/number.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* Types of patches whose nodes may slide; those of others stay. */
static const char *const plain_types[] = {"patch", "wall", "symmetry", "symmetryPlane", NULL};

/* ---- sets ----------------------------------------------------------------------------------- */

/** Add a set behind the others, whose name is copied and whose members are taken over, on failure, too. */
static int add_set(foam_sets *sets, io_slice name, foam_set set, planish_error *error) {
    const int64_t length = io_slice_length(name);
    set.name = pl_alloc(length + 1, 1);
    if (!set.name || !pl_append(&sets->set, &sets->n, &sets->capacity, &set, sizeof set)) {
        pl_free(set.name);
        pl_free(set.member);
        return pl_fail_memory(error, "patches and zones");
    }
    memcpy(set.name, name.begin, (size_t)length);
    set.name[length] = '\0';
    return PLANISH_OK;
}

void foam_release_sets(foam_sets *sets) {
    for (int64_t i = 0; i < sets->n; i++) {
        pl_free(sets->set[i].name);
        pl_free(sets->set[i].member);
    }
    pl_free(sets->set);
}

/* ---- the file of patches -------------------------------------------------------------------- */

/** Take a whole number and ';'. */
static int take_number(foam_patches *p, int64_t *number, planish_error *error) {
    const io_slice word = foam_word(&p->file.cursor);
    if (io_slice_integer(word, number) || *number < 0)
        return io_fail_at(&p->file.of.view, word.begin, error,
                          "a number of faces expected, not '%.*s'", IO_QUOTED(word));
    return foam_expect(&p->file, ";", error);
}

/** Read an entry of a patch whose name is word. */
static int read_entry(foam_patches *p, foam_patch *to, io_slice word, planish_error *error) {
    io_cursor ahead = p->file.cursor;
    const io_slice value = foam_word(&ahead);
    const int status = foam_check_word(&p->file, word, error);
    if (status)
        return status;
    if (io_slice_is(word, "nFaces", 0))
        return take_number(p, &to->n, error);
    if (io_slice_is(word, "startFace", 0))
        return take_number(p, &to->first, error);
    if (io_slice_is(word, "type", 0))
        to->type = value;
    if (io_slice_is(word, "neighbourPatch", 0))
        to->neighbour = value;
    const char *begin = p->file.cursor.at;
    const int skipped = foam_skip_value(&p->file, error);
    if (io_slice_is(word, "inGroups", 0))
        to->groups = (io_slice){begin, p->file.cursor.at};
    return skipped;
}

/** Read a patch whose name is word. */
static int read_patch(const foam_mesh *mesh, foam_patches *p, io_slice word, planish_error *error) {
    foam_patch to = {.name = word, .first = -1, .n = -1, .at = word.begin};
    const io_model *view = &p->file.of.view;
    int status = foam_expect(&p->file, "{", error);
    while (!status) {
        word = foam_word(&p->file.cursor);
        if (io_slice_is(word, "}", 0))
            break;
        status = io_slice_length(word)
                     ? read_entry(p, &to, word, error)
                     : io_fail_at(view, word.begin, error, "'}' of a patch expected");
    }
    if (status)
        return status;
    if (to.n < 0 || to.first < 0 || io_slice_length(to.type) == 0)
        return io_fail_at(view, to.at, error, "patch '%.*s': type, nFaces and startFace expected",
                          IO_QUOTED(to.name));
    if (to.first > mesh->n_faces || to.n > mesh->n_faces - to.first)
        return io_fail_at(
            view, to.at, error, "patch '%.*s': there are %lld faces, not %lld from %lld on",
            IO_QUOTED(to.name), (long long)mesh->n_faces, (long long)to.n, (long long)to.first);
    if (to.n > 0 && to.first < p->n_behind)
        return io_fail_at(view, to.at, error,
                          "patch '%.*s' begins with face %lld, which the patches before have, too",
                          IO_QUOTED(to.name), (long long)to.first);
    p->n_behind = to.n > 0 ? to.first + to.n : p->n_behind;
    for (int64_t i = to.first; i < to.first + to.n; i++)
        if (foam_neighbour(mesh, i) >= 0)
            return io_fail_at(view, to.at, error, "patch '%.*s': face %lld is between two cells",
                              IO_QUOTED(to.name), (long long)i);
    return pl_append(&p->patch, &p->n, &p->capacity, &to, sizeof to)
               ? PLANISH_OK
               : pl_fail_memory(error, "patches");
}

int foam_read_patches(const foam_mesh *mesh, foam_patches *p, planish_error *error) {
    static const char what[] = "patches";
    int64_t n = 0;
    io_slice name;
    int status = foam_open(mesh->model, "boundary", 1, &p->file, error), more = 0;
    if (status)
        return status;
    p->file.of.view.is_binary = 0; /* it is text in any case */
    status = foam_begin_entries(&p->file, what, &n, error);
    for (int64_t i = 0;
         !status && (more = foam_next_entry(&p->file, what, n, i, &name, error)) == 1; i++)
        status = read_patch(mesh, p, name, error);
    return more < 0 ? more : status;
}

void foam_release_patches(foam_patches *p) {
    pl_free(p->patch);
    foam_close(&p->file);
}

/* ---- nodes that are held -------------------------------------------------------------------- */

/** Return whether the nodes of patches of a type may slide. */
static int is_plain(io_slice type) {
    for (const char *const *plain = plain_types; *plain; plain++)
        if (io_slice_is(type, *plain, 0))
            return 1;
    return 0;
}

/** Return whether a face is on a side of a layer: it has more than two nodes. */
static int is_on_side(const foam_mesh *mesh, int64_t face) {
    const int32_t *point = mesh->node + mesh->start[face];
    const int32_t first = foam_node(mesh, point[0]);
    int32_t second = first;
    for (int64_t k = 1; k < mesh->start[face + 1] - mesh->start[face]; k++) {
        const int32_t node = foam_node(mesh, point[k]);
        if (node != first && node != second && second != first)
            return 1;
        second = node != first ? node : second;
    }
    return 0;
}

/** Hold the nodes of a patch, but for those faces of an empty one that are the elements of a layer. */
static void hold_patch(const foam_mesh *mesh, const foam_patch *p) {
    const int is_empty = io_slice_is(p->type, "empty", 0);
    for (int64_t i = p->first; i < p->first + p->n; i++)
        for (int64_t k = mesh->start[i]; k < mesh->start[i + 1]; k++)
            if (mesh->dim == 3 || !is_empty || !is_on_side(mesh, i))
                io_hold_node(mesh->model, foam_node(mesh, mesh->node[k]), IO_HELD_REQUIRED);
}

/** Return whether the faces of two patches have as many nodes, one by one. */
static int are_alike(const foam_mesh *mesh, const foam_patch *a, const foam_patch *b) {
    if (a->n != b->n)
        return 0;
    for (int64_t i = 0; i < a->n; i++)
        if (mesh->start[a->first + i + 1] - mesh->start[a->first + i] !=
            mesh->start[b->first + i + 1] - mesh->start[b->first + i])
            return 0;
    return 1;
}

/** Note the pairs of nodes of two cyclic patches: the first nodes of two faces belong together, the
 *  others in opposite order. last [n_nodes] has the number of the patch whose pair a node was last in. */
static int pair_patches(const foam_mesh *mesh, const foam_patch *a, const foam_patch *b,
                        int32_t number, int32_t *last, planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < a->n && !status; i++) {
        const int64_t from = mesh->start[a->first + i], to = mesh->start[b->first + i];
        const int64_t n = mesh->start[a->first + i + 1] - from;
        for (int64_t k = 0; k < n && !status; k++) {
            const int32_t pair[2] = {foam_node(mesh, mesh->node[from + k]),
                                     foam_node(mesh, mesh->node[to + (n - k) % n])};
            if (last[pair[0]] == number)
                continue;
            last[pair[0]] = number;
            for (int j = 0; j < 2; j++)
                io_hold_node(mesh->model, pair[j], IO_HELD_PERIODIC);
            if (pair[0] != pair[1])
                status = io_model_pair(mesh->model, pair, error);
        }
    }
    return status;
}

/** Hold the nodes of patches that are not plain. */
static int hold_patches(const foam_mesh *mesh, const foam_patches *p, planish_error *error) {
    enum { MOST_COMPARED = 10000 }; /* of a damaged file with more, all are held */
    const int64_t n_compared = p->n <= MOST_COMPARED ? p->n : 0;
    int32_t *last = NULL;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < p->n && !status; i++) {
        const foam_patch *a = &p->patch[i], *b = NULL;
        for (int64_t k = 0; k < n_compared && io_slice_is(a->type, "cyclic", 0); k++) {
            const io_slice name = p->patch[k].name;
            if (io_slice_length(name) == io_slice_length(a->neighbour) && k != i &&
                memcmp(name.begin, a->neighbour.begin, (size_t)io_slice_length(name)) == 0)
                b = &p->patch[k];
        }
        if (b && are_alike(mesh, a, b)) {
            if (b < a) /* both say so */
                continue;
            if (!last && !(last = pl_alloc_zero(mesh->model->n_nodes, sizeof *last)))
                status = pl_fail_memory(error, "the periodic nodes");
            if (!status)
                status = pair_patches(mesh, a, b, (int32_t)i + 1, last, error);
        } else if (!is_plain(a->type)) {
            hold_patch(mesh, a);
        }
    }
    pl_free(last);
    return status;
}

/** Add the sets of a patch: itself and its groups, (a b), 2(a b), List<word> 2(a b), or a. */
static int add_sets(const foam_patch *p, foam_sets *sets, planish_error *error) {
    enum { MOST_GROUPS = 64 };
    const foam_set set = {.things = FOAM_FACES, .first = p->first, .n = p->n};
    io_cursor cursor = {p->groups.begin, p->groups.end};
    int status = add_set(sets, p->name, set, error);
    for (int n = 0; n < MOST_GROUPS && !status && cursor.at < cursor.end;) {
        int64_t number;
        const io_slice word = foam_word(&cursor);
        if (io_slice_length(word) > 0 && !strchr(";()", *word.begin) &&
            !io_slice_is(word, "List<word>", 0) && io_slice_integer(word, &number)) {
            status = add_set(sets, word, set, error);
            n++;
        }
    }
    return status;
}

int foam_use_patches(const foam_mesh *mesh, const foam_patches *p, foam_sets *sets,
                     planish_error *error) {
    int status = hold_patches(mesh, p, error);
    for (int64_t i = 0; i < p->n && !status; i++)
        status = add_sets(&p->patch[i], sets, error);
    return status;
}

/* ---- zones ---------------------------------------------------------------------------------- */

/** Files of zones, and the entry that has what is in a zone. */
static const struct {
    const char *file, *labels;
    foam_things things;
} zones[] = {{"cellZones", "cellLabels", FOAM_CELLS},
             {"faceZones", "faceLabels", FOAM_FACES},
             {"pointZones", "pointLabels", FOAM_POINTS}};
enum { N_ZONES = sizeof zones / sizeof *zones };

/** Skip a list of truth values, which binary files have a byte each of. */
static int skip_flags(foam_file *f, planish_error *error) {
    io_cursor ahead = f->cursor;
    int64_t n;
    if (!f->of.view.is_binary || !io_slice_is(foam_word(&ahead), "List<bool>", 0))
        return foam_skip_value(f, error);
    foam_skip(&ahead);
    if (io_parse_integer(&ahead.at, ahead.end, &n) || n < 0 || n > io_left(&ahead))
        return io_fail_at(&f->of.view, ahead.at, error, "the number of flags expected");
    io_cursor mark = ahead;
    if (n > 0 && io_slice_is(foam_word(&mark), "(", 0)) {
        if (n > io_left(&mark))
            return io_fail_at(&f->of.view, ahead.at, error, "the list of flags is cut short");
        f->cursor = mark;
        f->cursor.at += n;
        const int status = foam_end_list(f, "flags", error);
        return status ? status : foam_expect(f, ";", error);
    }
    f->cursor = ahead;
    return foam_skip_value(f, error);
}

/** Read a zone called name. */
static int read_zone(foam_file *f, io_slice name, int kind, int64_t most, foam_sets *sets,
                     planish_error *error) {
    foam_set set = {.things = zones[kind].things};
    int status = foam_expect(f, "{", error);
    while (!status) {
        const io_slice word = foam_word(&f->cursor);
        if (io_slice_is(word, "}", 0))
            return add_set(sets, name, set, error);
        status = io_slice_length(word)
                     ? foam_check_word(f, word, error)
                     : io_fail_at(&f->of.view, word.begin, error, "'}' of a zone expected");
        io_cursor ahead = f->cursor;
        io_slice value = foam_word(&ahead);
        const int is_empty = io_slice_is(value, "(", 0) && io_slice_is(foam_word(&ahead), ")", 0);
        if (!status && io_slice_is(word, zones[kind].labels, 0) && !set.member && !is_empty) {
            status = foam_label_set(f, zones[kind].labels, 0, most - 1, &set.member, &set.n, error);
            if (!status)
                status = foam_expect(f, ";", error);
        } else if (!status) {
            status =
                io_slice_is(word, "flipMap", 0) ? skip_flags(f, error) : foam_skip_value(f, error);
        }
    }
    pl_free(set.member);
    return status;
}

static int read_zones(const foam_mesh *mesh, int kind, foam_sets *sets, planish_error *error) {
    static const char what[] = "zones";
    const io_model *model = mesh->model;
    const int64_t most[FOAM_N_THINGS] = {model->place_node ? model->n_places : model->n_nodes,
                                         mesh->n_faces, mesh->n_cells};
    foam_file f;
    io_slice name;
    int64_t n = 0;
    int status = foam_open(mesh->model, zones[kind].file, 0, &f, error), more = 0;
    if (!status && f.of.view.input.data) {
        status = foam_begin_entries(&f, what, &n, error);
        for (int64_t i = 0; !status && (more = foam_next_entry(&f, what, n, i, &name, error)) == 1;
             i++)
            status = read_zone(&f, name, kind, most[zones[kind].things], sets, error);
    }
    foam_close(&f);
    return more < 0 ? more : status;
}

int foam_read_zones(const foam_mesh *mesh, foam_sets *sets, planish_error *error) {
    int status = PLANISH_OK;
    for (int kind = 0; kind < N_ZONES && !status; kind++)
        status = read_zones(mesh, kind, sets, error);
    return status;
}
