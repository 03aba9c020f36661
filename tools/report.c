/* report: the command `planish report`: a page for people from the JSON of an earlier run.
 *
 * The figures are all in the JSON. The picture is drawn from the mesh files that it names, if they
 * are still there and have the coordinates that it says.
 */
#include "report.h"

#include "commands.h"
#include "message.h"
#include "output.h"
#include "report/page.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- the page ------------------------------------------------------------------------------- */

static int write_page(const char *path, const pl_figures *figures, const pl_picture *picture,
                      const char *no_picture, int failed) {
    planish_error error;
    pl_markup page = {0};
    int status = 0;
    pl_page_make(&page, figures, picture, no_picture);
    if (page.failed)
        status = pl_complain(failed, "out of memory for the page %s", path);
    else if (pl_output_write_text(path, PL_TEMPORARY_PAGE, page.text, page.length, &error))
        status = pl_complain(failed, "the page: %s", error.text);
    pl_markup_free(&page);
    return status;
}

static int write_page_of(const char *path, const char *json, const pl_picture *picture,
                         int failed) {
    pl_figures figures;
    cJSON *result = cJSON_Parse(json);
    int status;
    if (!result || pl_figures_find(result, &figures)) /* it is ours: only memory can be short */
        status = pl_complain(failed, "out of memory for the page %s", path);
    else
        status = write_page(path, &figures, picture, NULL, failed);
    cJSON_Delete(result);
    return status;
}

static int write_json(const char *path, const char *json, int failed) {
    planish_error error;
    if (pl_output_write_text(path, PL_TEMPORARY_REPORT, json, strlen(json), &error))
        return pl_complain(failed, "the report: %s", error.text);
    return 0;
}

int pl_reports_write(const pl_arguments *arguments, const char *json, const pl_picture *picture,
                     int failed) {
    int status = 0, page = 0;
    if (!json)
        return pl_complain(failed, "out of memory for the report");
    if (arguments->json)
        status = write_json(arguments->json, json, failed);
    if (arguments->report)
        page = write_page_of(arguments->report, json, picture, failed);
    return status ? status : page;
}

int pl_report_draw(const pl_job *job, const char *name, pl_picture **picture) {
    if (!job->arguments->report || !pl_page_can_draw())
        return 0;
    const int status = *picture ? 0 : pl_picture_begin(job, picture);
    return status ? status : pl_picture_take(*picture, job, name);
}

/* ---- the JSON ------------------------------------------------------------------------------- */

/** The text of the file at path, to be freed, or NULL after a message. */
static char *read_text(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    size_t capacity = 1 << 16, n = 0;
    char *text = file ? malloc(capacity) : NULL;
    errno = file && !text ? ENOMEM : errno;
    while (text && !ferror(file) && !feof(file)) {
        n += fread(text + n, 1, capacity - n, file);
        if (n < capacity)
            continue;
        char *longer = realloc(text, capacity *= 2);
        if (!longer)
            free(text);
        text = longer;
    }
    if (!text || ferror(file)) {
        pl_complain(PL_EXIT_FAILED, "%s: %s", path, strerror(errno));
        free(text);
        text = NULL;
    }
    if (file)
        fclose(file);
    *length = n;
    return text;
}

/** Line of text, from 1, that the byte at belongs to. */
static int64_t line_of(const char *text, const char *at) {
    int64_t line = 1;
    for (const char *c = text; c < at; c++)
        line += *c == '\n';
    return line;
}

/** Parse the file; NULL after a message. */
static cJSON *read_result(const char *path, pl_figures *figures) {
    size_t length;
    char *text = read_text(path, &length);
    const char *end = NULL;
    if (!text)
        return NULL;
    cJSON *result = cJSON_ParseWithLengthOpts(text, length, &end, 0);
    const char *flaw = result ? pl_figures_find(result, figures) : NULL;
    if (!result)
        pl_complain(PL_EXIT_FAILED,
                    "%s, line %" PRId64 ": is no JSON; give the file that 'planish smooth --json' "
                    "has written",
                    path, line_of(text, end ? end : text));
    else if (flaw)
        pl_complain(
            PL_EXIT_FAILED,
            "%s: is no result of 'planish smooth --json' or 'planish quality --json': it %s", path,
            flaw);
    free(text);
    if (flaw)
        cJSON_Delete(result);
    return flaw ? NULL : result;
}

/* ---- the picture ---------------------------------------------------------------------------- */

/** A picture under way, and why it lacks something. */
typedef struct drawing {
    const char *json_path;
    const pl_figures *figures;
    pl_picture *picture;
    char lacks[1024];
} drawing;

static void lack(drawing *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void lack(drawing *d, const char *format, ...) {
    const size_t used = strlen(d->lacks);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(d->lacks + used, sizeof d->lacks - used, format, arguments);
    va_end(arguments);
}

/** Where the file called name is: paths are relative to where the run was, which may be here, or
 *  where its JSON is. 0 if it is in neither place. */
static int find_file(const drawing *d, const char *name, char *path, size_t size) {
    const char *slash = strrchr(d->json_path, '/');
    const int folder = slash ? (int)(slash - d->json_path) + 1 : 0;
    snprintf(path, size, "%s", name);
    if (access(path, R_OK) == 0)
        return 1;
    const int length = snprintf(path, size, "%.*s%s", folder, d->json_path, name);
    return name[0] != '/' && length > 0 && (size_t)length < size && access(path, R_OK) == 0;
}

/** Whether the mesh of job has the coordinates that the result says. */
static int is_same(const pl_job *job, const char *checksum) {
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, planish_checksum(&job->mesh));
    return strcmp(text, checksum) == 0;
}

static int draw_job(drawing *d, pl_job *job, const char *name) {
    int status = pl_job_plan(job);
    if (!status && !d->picture)
        status = pl_picture_begin(job, &d->picture);
    return status ? status : pl_picture_take(d->picture, job, name);
}

/** Draw the state called name from the file that the result has under file_key. Returns 0, also
 *  where that is not possible any more, or an exit status after a message. */
static int draw_state(drawing *d, const char *name, const char *file_key,
                      const char *checksum_key) {
    const cJSON *result = d->figures->result;
    const char *format = pl_figure_text(result, "format"), *file = pl_figure_text(result, file_key);
    char path[PATH_MAX];
    pl_arguments arguments = {.command = PL_COMMAND_REPORT, .verbosity = PL_QUIET};
    pl_job job;
    if (!file[0] || !find_file(d, file, path, sizeof path)) {
        lack(d, "The mesh %s is not drawn: its file '%s' is not there any more. ", name, file);
        return 0;
    }
    planish_options_init(&arguments.library);
    arguments.input = path;
    arguments.format = format[0] && strcmp(file_key, "input") == 0 ? format : NULL;
    int status = pl_job_read(&job, &arguments);
    if (!status && is_same(&job, pl_figure_text(result, checksum_key)))
        status = draw_job(d, &job, name);
    else if (!status)
        lack(d, "The mesh %s is not drawn: the file '%s' has other coordinates now. ", name, file);
    pl_job_close(&job);
    return status;
}

static int draw(drawing *d) {
    if (!pl_page_can_draw())
        return 0;
    if (d->figures->n_states == 1)
        return draw_state(d, "mesh", "input", "checksum");
    const int status = draw_state(d, "before", "input", "input_checksum");
    return status ? status : draw_state(d, "after", "output", "checksum");
}

/* ---- the command ---------------------------------------------------------------------------- */

/** Where the page goes: to output, or beside the JSON under its name. */
static int find_output(const pl_arguments *arguments, char *path, size_t size) {
    const char *json = arguments->input, *output = arguments->output;
    const char *slash = strrchr(json, '/'), *dot = strrchr(json, '.');
    const int has_extension = dot && dot != json && (!slash || dot > slash + 1);
    const int stem = (int)(has_extension ? (size_t)(dot - json) : strlen(json));
    const int length =
        output ? snprintf(path, size, "%s", output) : snprintf(path, size, "%.*s.html", stem, json);
    if (length < 0 || (size_t)length >= size)
        return pl_complain(PL_EXIT_FAILED, "%s: the name is too long", json);
    if (pl_output_same_file(path, json))
        return pl_complain_usage("report", "the page would overwrite '%s'", json);
    return pl_output_check(path);
}

/** The meshes are not to be lost by a slip. */
static int check_meshes(const drawing *d, const char *output) {
    static const char *const keys[] = {"input", "output"};
    for (int i = 0; i < 2; i++) {
        char path[PATH_MAX];
        const char *file = pl_figure_text(d->figures->result, keys[i]);
        if (file[0] && find_file(d, file, path, sizeof path) && pl_output_hits_mesh(output, path))
            return pl_complain_usage("report", "the page would overwrite the mesh '%s'", path);
    }
    return 0;
}

static int report(drawing *d, const char *output, int is_quiet) {
    int status = check_meshes(d, output);
    if (!status)
        status = draw(d);
    if (!status && d->lacks[0] && !is_quiet)
        pl_note(stderr, "%s", d->lacks);
    if (!status)
        status = write_page(output, d->figures, d->picture, d->lacks, PL_EXIT_FAILED);
    return status;
}

int pl_report_command(const pl_arguments *arguments) {
    char output[PATH_MAX];
    pl_figures figures;
    drawing d = {.json_path = arguments->input, .figures = &figures};
    int status = find_output(arguments, output, sizeof output);
    if (status)
        return status;
    cJSON *result = read_result(arguments->input, &figures);
    if (!result)
        return PL_EXIT_FAILED;
    status = report(&d, output, arguments->verbosity == PL_QUIET);
    pl_picture_free(d.picture);
    cJSON_Delete(result);
    return status;
}
