/* abaqus_blocks: the lines of Abaqus input files: keywords with their parameters, and the items of
 * the data behind them. What cannot be read is refused here.
 */
#include "io/abaqus/abaqus.h"

#include "io/core/number.h"
#include "io/core/text.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- items -------------------------------------------------------------------------------- */

static int is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

abaqus_span abaqus_trim(abaqus_span s) {
    while (s.begin < s.end && is_blank(*s.begin))
        s.begin++;
    while (s.begin < s.end && is_blank(s.end[-1]))
        s.end--;
    return s;
}

static int is_comment(abaqus_span line) {
    return abaqus_length(line) > 1 && line.begin[0] == '*' && line.begin[1] == '*';
}

int abaqus_line(io_cursor *cursor, abaqus_span *line) {
    while (cursor->at < cursor->end) {
        line->begin = io_line(cursor, &line->end);
        *line = abaqus_trim(*line);
        if (abaqus_length(*line) > 0 && !is_comment(*line))
            return 1;
    }
    return 0;
}

/** The first comma that is not between quotes, or NULL. */
static const char *find_comma(abaqus_span line) {
    const char *at = line.begin;
    const char *comma = memchr(at, ',', (size_t)(line.end - at));
    while (comma) {
        const char *open = memchr(at, '"', (size_t)(comma - at));
        const char *close = open ? memchr(open + 1, '"', (size_t)(line.end - open - 1)) : NULL;
        if (!close)
            return comma;
        at = close + 1;
        if (comma < at)
            comma = memchr(at, ',', (size_t)(line.end - at));
    }
    return NULL;
}

int abaqus_item(abaqus_span *line, abaqus_span *item) {
    if (!line->begin)
        return 0;
    const char *comma = find_comma(*line);
    *item = abaqus_trim((abaqus_span){line->begin, comma ? comma : line->end});
    line->begin = comma ? comma + 1 : NULL;
    return 1;
}

int abaqus_integer(abaqus_span item, int64_t *value) {
    const char *at = item.begin;
    return io_parse_integer(&at, item.end, value) || at != item.end ? -1 : 0;
}

void abaqus_squeeze(abaqus_span item, char name[ABAQUS_NAME_SIZE]) {
    int n = 0;
    for (const char *c = item.begin; c < item.end; c++) {
        if (is_blank(*c))
            continue;
        if (n == ABAQUS_NAME_SIZE - 1) {
            n = 0;
            break;
        }
        name[n++] = io_upper(*c);
    }
    name[n] = '\0';
}

int abaqus_is_quoted(abaqus_span s) {
    return abaqus_length(s) > 1 && *s.begin == '"' && s.end[-1] == '"';
}

abaqus_span abaqus_unquoted(abaqus_span s) {
    return abaqus_is_quoted(s) ? (abaqus_span){s.begin + 1, s.end - 1} : s;
}

static int parameter_of_line(abaqus_span line, const char *name, abaqus_span *value) {
    abaqus_span item;
    char found[ABAQUS_NAME_SIZE];
    while (abaqus_item(&line, &item)) {
        const char *equals = memchr(item.begin, '=', (size_t)abaqus_length(item));
        abaqus_squeeze((abaqus_span){item.begin, equals ? equals : item.end}, found);
        if (strcmp(found, name) != 0)
            continue;
        *value = equals ? abaqus_trim((abaqus_span){equals + 1, item.end})
                        : (abaqus_span){item.end, item.end};
        return 1;
    }
    return 0;
}

int abaqus_parameter(const abaqus_block *block, const char *name, abaqus_span *value) {
    io_cursor cursor = {block->parameters.begin, block->parameters.end};
    abaqus_span line; /* comments may stand between those of a keyword */
    while (abaqus_line(&cursor, &line))
        if (parameter_of_line(line, name, value))
            return 1;
    return 0;
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
    {"PART", ABAQUS_PART},
    {"ENDPART", ABAQUS_END_PART},
    {"INSTANCE", ABAQUS_INSTANCE},
    {"ENDINSTANCE", ABAQUS_END_INSTANCE},
    {"ASSEMBLY", ABAQUS_ASSEMBLY},
    {"ENDASSEMBLY", ABAQUS_END_ASSEMBLY},
    {"INCLUDE", ABAQUS_REFUSED},
    {"SYSTEM", ABAQUS_REFUSED},
    {"NGEN", ABAQUS_REFUSED},
    {"NFILL", ABAQUS_REFUSED},
    {"NCOPY", ABAQUS_REFUSED},
    {"NMAP", ABAQUS_REFUSED},
    {"ELGEN", ABAQUS_REFUSED},
    {"ELCOPY", ABAQUS_REFUSED},
    {"IMPORT", ABAQUS_REFUSED},
};

static abaqus_keyword find_keyword(const char *name) {
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++)
        if (strcmp(name, keywords[i].name) == 0)
            return keywords[i].keyword;
    return ABAQUS_OTHER;
}

int abaqus_fail(const abaqus_reader *r, const abaqus_block *b, const char *text) {
    return io_fail_at(r->model, b->parameters.begin, r->error, "%s", text);
}

static int refuse(const abaqus_reader *r, const char *at, const char *name) {
    if (strcmp(name, "INCLUDE") == 0)
        return io_fail_at(r->model, at, r->error,
                          "*INCLUDE: what it brings in may be part of the mesh; put that file's "
                          "lines in its place, or smooth the file that has the mesh");
    if (strcmp(name, "SYSTEM") == 0)
        return io_fail_at(r->model, at, r->error,
                          "*SYSTEM: the nodes behind it are in other coordinates; write all of "
                          "them in the global system");
    return io_fail_at(r->model, at, r->error,
                      "*%s: nodes and elements that are made by rules are not read; write all of "
                      "them as *NODE and *ELEMENT, as preprocessors do",
                      name);
}

static int add_block(abaqus_reader *r, abaqus_block block) {
    abaqus_block *grown =
        pl_grow(r->block, r->n_blocks, r->n_blocks + 1, &r->block_capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the keywords of the file");
    r->block = grown;
    abaqus_span instance;
    block.has_instance = abaqus_parameter(&block, "INSTANCE", &instance);
    r->block[r->n_blocks++] = block;
    return PLANISH_OK;
}

/** The keyword line at line, with the lines that it goes on in behind a comma at its end. */
static abaqus_span whole_keyword_line(io_cursor *cursor, abaqus_span line) {
    io_cursor ahead = *cursor;
    abaqus_span next;
    while (line.end[-1] == ',' && abaqus_line(&ahead, &next) && *next.begin != '*') {
        line.end = next.end;
        *cursor = ahead;
    }
    return line;
}

/** Parts have numbers of their own, and so have instances that have a mesh of theirs, and the
 *  assembly. */
static int32_t scope_behind(abaqus_keyword keyword, int32_t scope, int32_t *n_parts) {
    switch (keyword) {
    case ABAQUS_PART:
    case ABAQUS_INSTANCE:
        return ++*n_parts;
    case ABAQUS_ASSEMBLY:
    case ABAQUS_END_INSTANCE:
        return ABAQUS_IN_ASSEMBLY;
    case ABAQUS_END_PART:
    case ABAQUS_END_ASSEMBLY:
        return 0;
    default:
        return scope;
    }
}

static int is_of_mesh(abaqus_keyword keyword) {
    return keyword <= ABAQUS_MPC;
}

int abaqus_find_blocks(abaqus_reader *r) {
    const char *data = r->model->input.data, *end = data + r->model->input.size;
    io_cursor cursor = io_begin_text(data, r->model->input.size);
    int status = PLANISH_OK;
    int32_t scope = 0, n_parts = 0;
    abaqus_block *open = NULL;
    while (!status && cursor.at < cursor.end) {
        const char *begin = cursor.at;
        abaqus_span line, name_item;
        line.begin = io_line(&cursor, &line.end);
        line = abaqus_trim(line);
        if (abaqus_length(line) == 0 || *line.begin != '*' || is_comment(line))
            continue;
        if (open)
            open->data.end = begin;
        open = NULL;
        abaqus_span rest = whole_keyword_line(&cursor, line);
        rest.begin++;
        char name[ABAQUS_NAME_SIZE];
        abaqus_item(&rest, &name_item);
        abaqus_squeeze(name_item, name);
        const abaqus_keyword keyword = find_keyword(name);
        r->has_cavities |= strcmp(name, "FLUIDPROPERTY") == 0;
        scope = scope_behind(keyword, scope, &n_parts);
        if (keyword == ABAQUS_REFUSED)
            return refuse(r, line.begin, name);
        if (!is_of_mesh(keyword))
            continue;
        if (!rest.begin)
            rest.begin = rest.end;
        status = add_block(r, (abaqus_block){keyword, rest, {cursor.at, end}, scope, 0});
        open = status ? NULL : &r->block[r->n_blocks - 1];
    }
    return status;
}

int abaqus_check_input(const abaqus_reader *r, const abaqus_block *b) {
    abaqus_span value;
    if (!abaqus_parameter(b, "INPUT", &value))
        return PLANISH_OK;
    return abaqus_fail(
        r, b,
        "INPUT=: the data are in another file; put that file's lines in place of the "
        "parameter");
}
