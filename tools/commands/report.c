/* report: the command `planish report`: a page for people from the JSON of an earlier run.
 *
 * The figures are all in the JSON. The picture is drawn from the mesh files that it names, if they
 * are still there and have the coordinates that it says.
 */

#include "commands/commands.h"
#include "job/cells.h"
#include "job/curved.h"
#include "job/moved.h"
#include "terminal/message.h"
#include "job/output.h"
#include "report/page.h"
#include "terminal/signals.h"
#include "terminal/text.h"

#include "base/output.h"
#include "base/system.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the JSON ------------------------------------------------------------------------------- */

/* Limits of a result. Its lists of elements take some 10 bytes for each: these are of 25 million of them.
 * cJSON takes some 80 bytes for each value. */
enum { LARGEST = 256 << 20, MOST_VALUES = 1 << 25 };

/** Read the file at path, up to LARGEST bytes and one more: its text [length], to be freed, or NULL and
 *  errno. */
static char *read_bytes(const char *path, size_t *length) {
    const int fd = pl_file_open(path, PL_FILE_READ);
    FILE *file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    int wrong = file ? 0 : errno;
    size_t capacity = 1 << 16;
    char *text = malloc(capacity);
    *length = 0;
    while (!wrong && text && !feof(file) && *length <= LARGEST) {
        errno = 0;
        *length += fread(text + *length, 1, capacity - *length, file);
        if (ferror(file) && errno != EINTR)
            wrong = errno ? errno : EIO;
        else if (ferror(file))
            clearerr(file);
        if (*length < capacity)
            continue;
        capacity *= 2;
        char *longer = realloc(text, capacity);
        if (longer)
            text = longer;
        else
            wrong = ENOMEM;
    }
    if (file)
        fclose(file);
    if (!wrong && text)
        return text;
    free(text);
    errno = wrong ? wrong : ENOMEM;
    return NULL;
}

/** Read the file at path: its text [length], to be freed, or NULL after a message. */
static char *read_text(const char *path, size_t *length) {
    char *text = read_bytes(path, length);
    int64_t n_values = 1;
    if (!text) {
        pl_complain(PL_EXIT_FAILED, "%s: cannot be read: %s", path, strerror(errno));
        return NULL;
    }
    for (const char *c = text; *length <= LARGEST && c < text + *length; c++)
        n_values += *c == ',';
    if (*length <= LARGEST && n_values <= MOST_VALUES)
        return text;
    pl_complain(PL_EXIT_FAILED,
                "%s: has more than %d MB or %d million values; it is too large for a page", path,
                LARGEST >> 20, MOST_VALUES / 1000000);
    free(text);
    return NULL;
}

/** Parse the file; NULL after a message. */
static cJSON *read_result(const char *path, pl_figures *figures) {
    size_t length;
    char *text = read_text(path, &length);
    const char *end = NULL, *flaw = NULL;
    if (!text)
        return NULL;
    cJSON *result = cJSON_ParseWithLengthOpts(text, length, &end, 0);
    const char *at = result ? end : NULL;
    while (at && at < text + length && *at && strchr(" \t\r\n", *at))
        at++;
    if (at == text + length) {
        flaw = pl_figures_find(result, figures);
        if (flaw)
            pl_complain(PL_EXIT_FAILED,
                        "%s: is not a result of 'planish smooth --json' or 'planish quality "
                        "--json': it %s",
                        path, flaw);
    } else { /* cJSON lacks memory, or the file is none */
        int64_t line = 1;
        for (const char *c = text; c < end; c++)
            line += *c == '\n';
        flaw = "is not JSON";
        pl_complain(PL_EXIT_FAILED,
                    "%s, line %" PRId64 ": is not JSON (or too large for the memory); give a file "
                    "that 'planish smooth --json' wrote",
                    path, line);
    }
    free(text);
    if (!flaw)
        return result;
    cJSON_Delete(result);
    return NULL;
}

/* ---- the picture ---------------------------------------------------------------------------- */

/** A picture under way, and why it lacks something. */
typedef struct drawing {
    const char *json_path;
    const pl_figures *figures;
    pl_picture *picture;
    char lacks[2048];
} drawing;

/** A state that is to be drawn. */
typedef struct wanted {
    const char *name;     /* "before" */
    const char *file;     /* as the result names it */
    const char *format;   /* or NULL: to be found out */
    const char *checksum; /* of its coordinates */
} wanted;

/** The state is not drawn: why, of which file; once for a state. */
static void lack(drawing *d, const wanted *w, const char *why) {
    const size_t used = strlen(d->lacks);
    char name[256];
    pl_text_fit(w->file, 60, name, sizeof name);
    snprintf(d->lacks + used, sizeof d->lacks - used, "%sThe mesh%s%s is not drawn: %s%s%s%s.",
             used ? " " : "", d->figures->n_states == 2 ? " " : "",
             d->figures->n_states == 2 ? w->name : "", w->file[0] ? "its file '" : "", name,
             w->file[0] ? "' " : "", why);
}

enum { N_PLACES = 3 };

/** Place i at which file may be: as it is named, from here or from the folder of the JSON; in that
 *  folder. Whether there is a regular file, or a folder. */
static int find_place(const drawing *d, const char *file, int i, char *path, size_t size) {
    const int folder = i > 0 ? (int)(pl_path_name(d->json_path) - d->json_path) : 0;
    const char *name = i == 2 ? pl_path_name(file) : file;
    pl_file_status status;
    if (!file[0] || (i == 1 && pl_path_is_absolute(file)))
        return 0;
    const int length = snprintf(path, size, "%.*s%s", folder, d->json_path, name);
    return length > 0 && (size_t)length < size && pl_file_find(path, &status) == 0 &&
           (status.kind == PL_FILE_REGULAR || status.kind == PL_FILE_FOLDER);
}

enum { MOST_ARRAYS = 256 };

/** Find the features of the surface of job, if those of the result were found, with its options. */
static void find_features(const drawing *d, pl_job *job, pl_arguments *arguments) {
    const cJSON *result = d->figures->result;
    const cJSON *surface = cJSON_GetObjectItemCaseSensitive(result, "surface"), *name;
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(result, "mesh");
    const char *array[MOST_ARRAYS], *original = pl_figure_text(surface, "original");
    const double angle = pl_figure(surface, "crease_angle");
    planish_error ignored;
    int n = 0;
    if (!cJSON_IsObject(surface))
        return;
    cJSON_ArrayForEach(name, cJSON_GetObjectItemCaseSensitive(mesh, "region_arrays")) {
        if (cJSON_IsString(name) && n < MOST_ARRAYS)
            array[n++] = name->valuestring;
    }
    planish_file_choose_regions(job->file, array, n, &ignored);
    arguments->surface_of = original[0] ? original : NULL;
    arguments->crease_angle = angle >= 0 && angle <= 180 ? angle : 0;
    arguments->ignore_regions =
        cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(surface, "ignores_regions"));
    pl_curved_try(job);
}

/** Find the file of the targets, with the coordinates that the result says: path [PATH_MAX]. */
static int find_targets(const drawing *d, char *path) {
    const cJSON *result = d->figures->result;
    const planish_open_options how = {.isolated = 1};
    char checksum[17];
    int is_found = 0;
    for (int i = 0; i < N_PLACES && !is_found; i++) {
        planish_file *file = NULL;
        planish_error ignored;
        if (!find_place(d, d->figures->like, i, path, PATH_MAX) ||
            planish_file_open_with(path, &how, &file, &ignored))
            continue;
        const planish_mesh mesh = planish_file_mesh(file);
        snprintf(checksum, sizeof checksum, "%016" PRIx64, planish_checksum(&mesh));
        is_found = strcmp(checksum, pl_figure_text(result, "like_checksum")) == 0;
        planish_file_close(file);
    }
    return is_found;
}

/** Take the layers of the input, in the file at path, as targets of job's mesh, if it is the input: *is_taken.
 *  Returns 0, or an exit status after a message. */
static int take_layers_of(const drawing *d, const char *path, pl_job *job, int *is_taken) {
    pl_arguments arguments = {
        .command = PL_COMMAND_REPORT, .typed = PL_COMMAND_REPORT, .input = path};
    pl_job input = {.arguments = &arguments, .engine = job->engine, .options = job->options};
    planish_error error;
    char checksum[17];
    uint8_t *is_layer;
    int64_t n;
    const planish_open_options how = {
        .threads = job->options.threads, .isolated = 1, .plane_tolerance = 1e-3};
    *is_taken = 0;
    if (planish_file_open_with(path, &how, &input.file, &error))
        return 0;
    input.mesh = planish_file_mesh(input.file);
    input.has_types = job->has_types;
    snprintf(checksum, sizeof checksum, "%016" PRIx64, pl_job_checksum(&input));
    int status = 0;
    if (input.mesh.n_nodes == job->mesh.n_nodes && input.mesh.n_elements == job->mesh.n_elements &&
        strcmp(checksum,
               pl_figure_text(d->figures->result,
                              d->figures->n_states == 1 ? "checksum" : "input_checksum")) == 0) {
        status = pl_job_find_layers(&input, &is_layer, &n);
        if (!status)
            status = pl_like_layers(&arguments, input.file, is_layer, &input.mesh, &job->like);
        *is_taken = !status && planish_file_cells(job->file, &job->like.cells, &error) == 0;
    }
    pl_job_close(&input);
    return status;
}

/** Take the targets of job's mesh, if they are still there: *is_taken. Returns 0, or an exit status after a
 *  message. */
static int take_targets(const drawing *d, pl_job *job, pl_arguments *arguments, char *path,
                        int *is_taken) {
    const pl_figures *figures = d->figures;
    int status = 0;
    *is_taken = 0;
    if (figures->like[0] && find_targets(d, path)) {
        arguments->like = path;
        status = pl_like_read(arguments, job->file, job->options.threads, &job->mesh, &job->like);
        *is_taken = !status;
    }
    for (int i = 0; figures->of_layers && i < N_PLACES && !status && !*is_taken; i++)
        if (find_place(d, pl_figure_text(figures->result, "input"), i, path, PATH_MAX))
            status = take_layers_of(d, path, job, is_taken);
    if (*is_taken)
        pl_job_take_all(job);
    return status;
}

/** Measure elements of job as those of a run with sizes: straight simplices, too, by aspect ratios. Returns 0, or
 *  an exit status after a message. */
static int measure_as_cells(pl_job *job) {
    planish_error error;
    if (planish_file_cells(job->file, &job->like.cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    job->mesh.elements = NULL;
    job->mesh.cells = &job->like.cells;
    job->has_types = 1;
    return 0;
}

/** Whether the mesh before smoothing was fitted to another surface (--onto). */
static int is_fitted(const cJSON *result) {
    const cJSON *surface = cJSON_GetObjectItemCaseSensitive(result, "surface");
    return pl_figure_text(surface, "onto")[0] != '\0';
}

/** Draw the state of job, which has the mesh. Returns 0, or an exit status after a message. */
static int draw_job(drawing *d, const wanted *w, pl_job *job, pl_arguments *arguments) {
    char path[PATH_MAX];
    planish_error error;
    int status = 0, is_taken = 1;
    if (d->figures->of_metric) {
        lack(d, w, "is not drawn: its elements are measured by a metric");
        return 0;
    }
    if (d->figures->like[0] || d->figures->of_layers)
        status = take_targets(d, job, arguments, path, &is_taken);
    else if (d->figures->of_sizes)
        status = measure_as_cells(job);
    if (!status && !is_taken)
        lack(d, w, "is drawn only beside its targets, which have changed or are gone");
    if (status || !is_taken)
        return status;
    const int code =
        job->has_types || job->is_surface ? PLANISH_OK : job->engine->plan_create(job, &error);
    if (code == PLANISH_ERROR_MEMORY)
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (code) {
        lack(d, w, error.text);
        return 0;
    }
    if ((!d->picture && !is_fitted(d->figures->result)) ||
        job->is_surface) /* which is measured by its shape */
        find_features(d, job, arguments);
    if (job->is_surface && !job->curved.shape) {
        lack(d, w, "is drawn only beside the surface it comes from, which has changed or is gone");
        return 0;
    }
    if (!d->picture)
        status = pl_picture_begin(job, &d->picture);
    if (!status && !pl_picture_fits(d->picture, job))
        lack(d, w, "has different elements");
    else if (!status)
        status = pl_picture_take(d->picture, job, w->name);
    return status;
}

/** Bound the places where nodes of job are in the second mesh of a comparison, if its file still has them.
 *  Returns 0, or an exit status after a message. */
static int bound_compared(const drawing *d, pl_job *job) {
    const cJSON *result = d->figures->result;
    const planish_open_options how = {
        .threads = job->options.threads, .isolated = 1, .plane_tolerance = 1e-3};
    char path[PATH_MAX], checksum[17];
    int status = 0;
    for (int i = 0; i < N_PLACES && !status && !job->goal.is_known; i++) {
        planish_file *file = NULL;
        planish_error ignored;
        if (!find_place(d, pl_figure_text(result, "output"), i, path, sizeof path) ||
            planish_file_open_with(path, &how, &file, &ignored))
            continue;
        snprintf(checksum, sizeof checksum, "%016" PRIx64, pl_moved_checksum(file));
        if (planish_file_mesh(file).dim == job->mesh.dim &&
            strcmp(checksum, pl_figure_text(result, "checksum")) == 0)
            status = pl_moved_bound(job, file);
        planish_file_close(file);
    }
    return status;
}

/** Draw the state from the file at path if it has the mesh; *why is set to why not, or to NULL.
 *  Returns 0, or an exit status after a message. */
static int try_place(drawing *d, const wanted *w, const char *path, const char **why) {
    pl_arguments arguments = {
        .command = PL_COMMAND_REPORT, .typed = PL_COMMAND_REPORT, .input = path};
    pl_job job = {.arguments = &arguments, .engine = &pl_engine_here};
    planish_error error;
    char checksum[17];
    int status = 0;
    *why = "can no longer be read";
    planish_options_init(&job.options);
    pl_signals_set_input(path);
    const planish_open_options how = {.format = w->format,
                                      .threads = job.options.threads,
                                      .isolated = 1,
                                      .plane_tolerance = 1e-3}; /* whatever it was taken with */
    const int code = planish_file_open_with(path, &how, &job.file, &error);
    if (code)
        return code == PLANISH_ERROR_MEMORY ? pl_job_complain(&job, PL_EXIT_FAILED, &error) : 0;
    job.mesh = planish_file_mesh(job.file);
    job.has_types = job.mesh.cells && pl_cells_have_types(job.mesh.cells, job.mesh.dim);
    job.is_surface = pl_curved_is_surface(&job.mesh);
    if (job.is_surface)
        job.engine = &pl_engine_of_surface;
    snprintf(checksum, sizeof checksum, "%016" PRIx64, pl_job_checksum(&job));
    *why = strcmp(checksum, w->checksum) == 0 ? NULL : "has different coordinates now";
    if (!*why && d->figures->is_compared && !d->picture)
        status = bound_compared(d, &job);
    if (!status && !*why && job.mesh.n_elements > 0)
        status = draw_job(d, w, &job, &arguments);
    pl_job_close(&job);
    pl_signals_set_input(NULL);
    return status;
}

/** Draw a state from the first place that has its mesh. Returns 0, also where none has it any more,
 *  or an exit status after a message. */
static int draw_state(drawing *d, const wanted *w) {
    const char *why = w->file[0] ? "no longer exists" : "no file is named";
    int status = 0;
    for (int i = 0; i < N_PLACES && !status && why; i++) {
        char path[PATH_MAX];
        if (find_place(d, w->file, i, path, sizeof path))
            status = try_place(d, w, path, &why);
    }
    if (why)
        lack(d, w, why);
    return status;
}

/** Draw what the result has: one mesh, or two states of it. */
static int draw(drawing *d) {
    const cJSON *result = d->figures->result;
    const int is_one = d->figures->n_states == 1;
    const char *format = pl_figure_text(result, "format");
    const wanted input = {is_one ? "mesh" : "before", pl_figure_text(result, "input"),
                          format[0] ? format : NULL,
                          pl_figure_text(result, is_one ? "checksum" : "input_checksum")};
    const wanted fitted = {"before", "", NULL, ""};
    const wanted output = {"after", pl_figure_text(result, "output"), NULL,
                           pl_figure_text(result, "checksum")};
    if (!pl_page_can_draw())
        return 0;
    int status = 0;
    if (is_fitted(result))
        lack(d, &fitted, "it was fitted to the other surface, and is in no file");
    else
        status = draw_state(d, &input);
    return status || is_one ? status : draw_state(d, &output);
}

/* ---- the command ---------------------------------------------------------------------------- */

/** Find the path of the page: output, or beside the JSON under its name. */
static int find_output(const pl_arguments *arguments, char *path, size_t size) {
    const char *json = arguments->input, *output = arguments->output;
    const char *name = pl_path_name(json), *dot = strrchr(name, '.');
    const int has_extension = dot && dot != name;
    const int stem = (int)(has_extension ? (size_t)(dot - json) : strlen(json));
    const int length =
        output ? snprintf(path, size, "%s", output) : snprintf(path, size, "%.*s.html", stem, json);
    if (length < 0 || (size_t)length >= size)
        return pl_complain(PL_EXIT_FAILED, "%s: the name is too long", json);
    if (!output && pl_output_is_stream(json))
        return pl_complain_usage(
            "report", "'%s' is not a regular file; name the HTML report by -o FILE", json);
    if (pl_output_same_file(path, json))
        return pl_complain_usage("report", "the HTML report would overwrite '%s'", json);
    return pl_output_check(path);
}

/** The meshes are not to be lost by a slip. */
static int check_meshes(const drawing *d, const char *output) {
    static const char *const keys[] = {"input", "output"};
    for (int i = 0; i < 2; i++) {
        char path[PATH_MAX];
        const char *file = pl_figure_text(d->figures->result, keys[i]);
        for (int place = 0; place < N_PLACES; place++)
            if (find_place(d, file, place, path, sizeof path) &&
                pl_output_hits_mesh(output, path, NULL))
                return pl_complain_usage("report", "the HTML report would overwrite the mesh '%s'",
                                         path);
    }
    return 0;
}

int pl_report_command(const pl_arguments *arguments) {
    char output[PATH_MAX];
    pl_figures figures;
    drawing d = {.json_path = arguments->input, .figures = &figures};
    cJSON *result = read_result(arguments->input, &figures); /* first: what is no JSON is that */
    if (!result)
        return PL_EXIT_FAILED;
    int status = find_output(arguments, output, sizeof output);
    if (!status)
        status = check_meshes(&d, output);
    if (!status)
        status = draw(&d);
    if (!status && d.lacks[0] && arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s", d.lacks);
    if (!status)
        status =
            pl_page_write(output, &figures, d.picture, d.lacks[0] ? d.lacks : NULL, PL_EXIT_FAILED);
    pl_picture_free(d.picture);
    cJSON_Delete(result);
    return status;
}
