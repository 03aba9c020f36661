/* abaqus_blocks: the lines of Abaqus input files: keywords with their parameters, and the items of
 * the data behind them. Keywords that planish cannot read are refused here.
 */
#include "io/abaqus/abaqus_reader.h"

#include "io/core/include.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- items -------------------------------------------------------------------------------- */

static int is_comment(io_slice line) {
    return io_slice_length(line) > 1 && line.begin[0] == '*' && line.begin[1] == '*';
}

int abaqus_line(io_cursor *cursor, io_slice *line) {
    while (cursor->at < cursor->end) {
        *line = io_slice_trim(io_next_line(cursor));
        if (io_slice_length(*line) > 0 && !is_comment(*line))
            return 1;
    }
    return 0;
}

int abaqus_item(io_slice *line, io_slice *item) {
    const char *at = line->begin;
    if (!at)
        return 0;
    const char *comma = memchr(at, ',', (size_t)(line->end - at));
    while (comma) { /* to the first one that is not between quotes */
        const char *open = memchr(at, '"', (size_t)(comma - at));
        const char *close = open ? memchr(open + 1, '"', (size_t)(line->end - open - 1)) : NULL;
        if (!close)
            break;
        at = close + 1;
        if (comma < at)
            comma = memchr(at, ',', (size_t)(line->end - at));
    }
    *item = io_slice_trim((io_slice){line->begin, comma ? comma : line->end});
    line->begin = comma ? comma + 1 : NULL;
    return 1;
}

void abaqus_squeeze(io_slice item, char name[ABAQUS_NAME_SIZE]) {
    int n = 0;
    for (const char *c = item.begin; c < item.end; c++) {
        if (io_is_blank(*c))
            continue;
        if (n == ABAQUS_NAME_SIZE - 1) {
            n = 0;
            break;
        }
        name[n++] = io_upper(*c);
    }
    name[n] = '\0';
}

int abaqus_is_quoted(io_slice s) {
    return io_slice_length(s) > 1 && *s.begin == '"' && s.end[-1] == '"';
}

io_slice abaqus_unquoted(io_slice s) {
    return abaqus_is_quoted(s) ? (io_slice){s.begin + 1, s.end - 1} : s;
}

int abaqus_parameter(const abaqus_block *block, const char *name, io_slice *value) {
    io_cursor cursor = {block->parameters.begin, block->parameters.end};
    io_slice line, item; /* comments may stand between the lines of a keyword */
    while (abaqus_line(&cursor, &line))
        while (abaqus_item(&line, &item)) {
            char found[ABAQUS_NAME_SIZE];
            const char *equals = memchr(item.begin, '=', (size_t)io_slice_length(item));
            abaqus_squeeze((io_slice){item.begin, equals ? equals : item.end}, found);
            if (strcmp(found, name) != 0)
                continue;
            *value = io_slice_trim((io_slice){equals ? equals + 1 : item.end, item.end});
            return 1;
        }
    return 0;
}

int abaqus_local(const abaqus_reader *r, const abaqus_block *b, io_slice *item) {
    if (b->scope == r->scope)
        return 1;
    /* The last point between INSTANCE and NAME: none that is in quotes or behind nothing but
     * digits, as in a real number. */
    const char *point = NULL;
    int is_quoted = 0, is_number = 0;
    for (const char *c = item->begin; c < item->end; c++) {
        is_quoted ^= *c == '"';
        if (*c == '.' && !is_quoted && !is_number)
            point = c;
        const int begins = c == item->begin || c[-1] == '.';
        is_number = *c >= '0' && *c <= '9' && (is_number || begins);
    }
    if (point)
        item->begin = point + 1;
    return point != NULL || b->has_instance;
}

/* ---- errors ------------------------------------------------------------------------------- */

int abaqus_fail(const abaqus_reader *r, const abaqus_block *b, const char *text) {
    return io_fail_at(r->model, b->parameters.begin, r->error, "%s", text);
}

int abaqus_fail_item(const abaqus_reader *r, io_slice item, const char *text) {
    return io_fail_at(r->model, item.begin, r->error, "'%.*s' %s", IO_QUOTED(item), text);
}

/* ---- blocks ------------------------------------------------------------------------------- */

typedef struct known_keyword {
    const char *name; /* without blanks */
    abaqus_keyword keyword;
} known_keyword;

static const known_keyword keywords[] = {
    {"NODE", ABAQUS_NODE},
    {"ELEMENT", ABAQUS_ELEMENT},
    {"NSET", ABAQUS_NSET},
    {"ELSET", ABAQUS_ELSET},
    {"SOLIDSECTION", ABAQUS_SECTION},
    {"SHELLSECTION", ABAQUS_SECTION},
    {"SHELLGENERALSECTION", ABAQUS_SECTION},
    {"MEMBRANESECTION", ABAQUS_SECTION},
    {"SURFACESECTION", ABAQUS_SECTION},
    {"EULERIANSECTION", ABAQUS_SECTION},
    {"EQUATION", ABAQUS_EQUATION},
    {"MPC", ABAQUS_MPC},
    {"BOUNDARY", ABAQUS_BOUNDARY},
    {"SURFACE", ABAQUS_SURFACE},
    {"PART", ABAQUS_IN_PART},
    {"ENDPART", ABAQUS_IN_NO_PART},
    {"INSTANCE", ABAQUS_IN_PART},
    {"ENDINSTANCE", ABAQUS_IN_OTHERS},
    {"ASSEMBLY", ABAQUS_IN_OTHERS},
    {"ENDASSEMBLY", ABAQUS_IN_NO_PART},
    {"INCLUDE", ABAQUS_INCLUDE},
    {"SYSTEM", ABAQUS_SYSTEM},
    {"NGEN", ABAQUS_RULE},
    {"NFILL", ABAQUS_RULE},
    {"NCOPY", ABAQUS_RULE},
    {"NMAP", ABAQUS_RULE},
    {"ELGEN", ABAQUS_RULE},
    {"ELCOPY", ABAQUS_RULE},
    {"IMPORT", ABAQUS_RULE},
};

/** Why planish cannot read a file with a keyword; NULL: it can. */
static const char *const refusals[ABAQUS_OTHER + 1] = {
    [ABAQUS_SYSTEM] = "the nodes behind it are in other coordinates; write the global ones",
    [ABAQUS_RULE] = "nodes and elements by rules are not read; write them as *NODE and *ELEMENT",
};

/** Walk over the lines of a file; the state goes on in those that it includes. */
typedef struct block_walk {
    abaqus_reader *reader;
    int32_t scope, n_parts;
    int64_t open; /* 1 + the block whose data may go on; 0: none */
    int depth;
} block_walk;

enum { MOST_DEPTH = 8 }; /* of files that include others */

static int find_blocks(block_walk *w, io_cursor content);

/** Parts have numbers of their own, and so have instances that have a mesh of theirs, and the
 *  assembly. */
static void enter_scope(block_walk *w, abaqus_keyword keyword) {
    if (keyword == ABAQUS_IN_PART)
        w->scope = ++w->n_parts;
    else if (keyword == ABAQUS_IN_OTHERS)
        w->scope = ABAQUS_IN_ASSEMBLY;
    else if (keyword == ABAQUS_IN_NO_PART)
        w->scope = 0;
}

/** Add a block whose data run to the end of the file, or until that is known better. */
static int add_block(block_walk *w, abaqus_block block) {
    abaqus_reader *r = w->reader;
    if (!pl_append(&r->block, &r->n_blocks, &r->block_capacity, &block, sizeof block))
        return pl_fail_memory(r->error, "the keywords of the file");
    w->open = r->n_blocks;
    return PLANISH_OK;
}

/** Read the file of *INCLUDE, INPUT=. Lines before its first keyword go on with the block before. */
static int include(block_walk *w, const abaqus_block *block) {
    abaqus_reader *r = w->reader;
    io_slice name = {NULL, NULL};
    io_cursor content;
    if (!abaqus_parameter(block, "INPUT", &name))
        return abaqus_fail(r, block, "*INCLUDE without INPUT=");
    if (w->depth == MOST_DEPTH)
        return abaqus_fail(r, block, "files include one another too deeply");
    int status = io_include_open(r->model, block->parameters.begin, abaqus_unquoted(name), &content,
                                 r->error);
    if (!status && w->open) {
        abaqus_block more = r->block[w->open - 1];
        more.data = content;
        status = add_block(w, more);
    }
    w->depth++;
    if (!status)
        status = find_blocks(w, content);
    w->depth--;
    return status;
}

/** Let the data of the open block be those of the file that its INPUT= names. */
static int open_input(block_walk *w) {
    abaqus_reader *r = w->reader;
    abaqus_block *block = &r->block[w->open - 1];
    io_slice name;
    if (!abaqus_parameter(block, "INPUT", &name))
        return PLANISH_OK;
    w->open = 0;
    return io_include_open(r->model, block->parameters.begin, abaqus_unquoted(name), &block->data,
                           r->error);
}

/** Take a keyword line, which may be several; the cursor goes behind it. */
static io_slice take_keyword(io_cursor *cursor, io_slice line) {
    io_slice next;
    io_cursor ahead = *cursor;
    while (line.end[-1] == ',' && abaqus_line(&ahead, &next) && *next.begin != '*') {
        line.end = next.end;
        *cursor = ahead;
    }
    return line;
}

/** Note a keyword that no conversion carries over: it says something, and not of nodes, elements, sets. */
static int note_not_carried(const block_walk *w, abaqus_keyword keyword, const char *name,
                            io_slice item) {
    enum { SIZE = 64 };
    char text[SIZE] = "*";
    const int is_carried = keyword == ABAQUS_NODE || keyword == ABAQUS_ELEMENT ||
                           keyword == ABAQUS_NSET || keyword == ABAQUS_ELSET ||
                           (keyword >= ABAQUS_IN_PART && keyword <= ABAQUS_INCLUDE) ||
                           strcmp(name, "HEADING") == 0 || strcmp(name, "PREPRINT") == 0 ||
                           strncmp(name, "END", 3) == 0;
    int n = 1;
    for (const char *c = item.begin; c < item.end && n < SIZE; c++)
        text[n++] = io_upper(*c);
    if (is_carried || io_names_add(&w->reader->model->not_carried, text, n))
        return PLANISH_OK;
    return pl_fail_memory(w->reader->error, "the keywords of the file");
}

/** Begin what a keyword line says. */
static int begin_block(block_walk *w, io_slice line, io_cursor data) {
    abaqus_reader *r = w->reader;
    io_slice item, rest = {line.begin + 1, line.end};
    char name[ABAQUS_NAME_SIZE];
    abaqus_item(&rest, &item);
    abaqus_squeeze(item, name);
    abaqus_keyword keyword = ABAQUS_OTHER;
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++)
        keyword = strcmp(name, keywords[i].name) == 0 ? keywords[i].keyword : keyword;
    if (refusals[keyword])
        return io_fail_at(r->model, line.begin, r->error, "*%s: %s", name, refusals[keyword]);
    if (note_not_carried(w, keyword, name, item))
        return PLANISH_ERROR_MEMORY;
    r->has_cavities |= strcmp(name, "FLUIDPROPERTY") == 0;
    enter_scope(w, keyword);
    abaqus_block block = {
        keyword, {rest.begin ? rest.begin : rest.end, rest.end}, data, w->scope, 0};
    if (keyword == ABAQUS_INCLUDE)
        return include(w, &block);
    w->open = 0;
    block.has_instance = abaqus_parameter(&block, "INSTANCE", &item);
    if (keyword > ABAQUS_LAST_KEPT)
        return PLANISH_OK;
    const int status = add_block(w, block);
    return status || keyword == ABAQUS_NODE ? status : open_input(w);
}

static int find_blocks(block_walk *w, io_cursor content) {
    io_cursor cursor = content;
    int status = PLANISH_OK;
    while (cursor.at < cursor.end && !status) {
        const char *begin = cursor.at;
        const io_slice line = io_slice_trim(io_next_line(&cursor));
        if (io_slice_length(line) == 0 || *line.begin != '*' || is_comment(line))
            continue;
        if (w->open)
            w->reader->block[w->open - 1].data.end = begin;
        const io_slice keyword = take_keyword(&cursor, line);
        const int64_t n_included = w->reader->model->n_included;
        status = begin_block(w, keyword, cursor);
        /* Lines behind an included file go on with what is open there. */
        if (!status && w->open && w->reader->model->n_included > n_included) {
            abaqus_block more = w->reader->block[w->open - 1];
            more.data = cursor;
            status = add_block(w, more);
        }
    }
    return status;
}

int abaqus_find_blocks(abaqus_reader *r) {
    block_walk w = {.reader = r};
    return find_blocks(&w, io_begin_text(r->model->input.data, r->model->input.size));
}
