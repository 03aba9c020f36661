/* output: the places that the program writes to. */
#include "job/output.h"

#include "terminal/message.h"

#include "base/memory.h"
#include "base/system.h"
#include "io/file/file.h"
#include "base/output.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/** Whether what is written to path ends up where standard output goes. */
static int leads_to_stdout(const char *path) {
    pl_file_status named, standard;
    if (strcmp(path, "/dev/stdout") == 0)
        return 1;
    return pl_file_find(path, &named) == 0 && pl_file_find_open(STDOUT_FILENO, &standard) == 0 &&
           named.kind != PL_FILE_CHARACTERS && pl_file_is_same(&named, &standard);
}

/** The folder that path is in, as folder [PATH_MAX], which is cut as no name of a file can be. */
static void folder_of(const char *path, char *folder) {
    const size_t length = (size_t)(pl_path_name(path) - path);
    snprintf(folder, PATH_MAX, "%.*s", length ? (int)length : 1, length ? path : ".");
}

/** Whether two names of files that need not exist are of one file in one folder. */
static int same_place(const char *a, const char *b) {
    pl_file_status folder_a, folder_b;
    char in_a[PATH_MAX], in_b[PATH_MAX];
    folder_of(a, in_a);
    folder_of(b, in_b);
    return strcmp(pl_path_name(a), pl_path_name(b)) == 0 && pl_file_find(in_a, &folder_a) == 0 &&
           pl_file_find(in_b, &folder_b) == 0 && pl_file_is_same(&folder_a, &folder_b);
}

int pl_output_same_file(const char *a, const char *b) {
    pl_file_status status_a, status_b;
    if (strcmp(a, b) == 0 || same_place(a, b))
        return 1;
    /* Links lead to files that need not be there yet either. */
    char *target_a = pl_output_target(a), *target_b = pl_output_target(b);
    const int same = target_a && target_b && same_place(target_a, target_b);
    pl_free(target_a);
    pl_free(target_b);
    if (same)
        return 1;
    return pl_file_find(a, &status_a) == 0 && pl_file_find(b, &status_b) == 0 &&
           status_a.kind == PL_FILE_REGULAR && pl_file_is_same(&status_a, &status_b);
}

/** Whether path is one of the first n files of the mesh at mesh_path. */
static int hits(const char *path, const char *mesh_path, const char *format, int n) {
    int hit = pl_output_same_file(path, mesh_path);
    char *other;
    for (int i = 0; !hit && i < n && (other = io_mesh_file(mesh_path, format, i)); i++) {
        hit = pl_output_same_file(path, other);
        pl_free(other);
    }
    return hit;
}

int pl_output_hits_mesh(const char *path, const char *mesh_path, const char *format) {
    return hits(path, mesh_path, format, INT_MAX);
}

int pl_output_is_same_mesh(const char *a, const char *b, const char *format) {
    enum { NEEDED = 4 }; /* TetGen's .node and .ele, as capitals, too */
    return hits(a, b, format, NEEDED);
}

int pl_output_check(const char *path) {
    pl_file_status status;
    char link[2]; /* only whether it is one is asked */
    char folder[PATH_MAX];
    if (strcmp(path, "-") == 0)
        return 0;
    const int exists = pl_file_find(path, &status) == 0;
    const int reason = exists ? 0 : errno;
    const int is_link = pl_path_read_link(path, link, sizeof link) == 0;
    if (reason == ENAMETOOLONG)
        return pl_complain(PL_EXIT_FAILED, "%s: %s", path, strerror(reason));
    if (reason && reason != ENOENT && is_link)
        return pl_complain(PL_EXIT_FAILED, "%s: cannot follow this link: %s", path,
                           strerror(reason));
    if (exists && status.kind == PL_FILE_FOLDER)
        return pl_complain(PL_EXIT_FAILED, "%s: is a folder; name a file in it", path);
    if (pl_output_is_stream(path) || (!exists && is_link))
        return 0; /* nothing is made beside it, or it is made where the link leads */
    if (path[0] && !*pl_path_name(path))
        return pl_complain(PL_EXIT_FAILED, "%s: is not the name of a file", path);
    char *target = exists ? pl_path_resolve(path) : NULL;
    if (exists && !target)
        return pl_complain(PL_EXIT_FAILED, "%s: %s", path, strerror(errno));
    folder_of(exists ? target : path, folder);
    free(target);
    if (pl_folder_check_writable(folder))
        return pl_complain(PL_EXIT_FAILED, "%s: cannot write to its folder: %s", path,
                           strerror(errno));
    return 0;
}

/** Whether OUT, of a mesh that is a folder, can be made: as a folder, or as a file for viewing. One that
 *  is there already is for planish_file_check_output, which knows the input. */
static int check_beside_folder(const char *path) {
    pl_file_status status;
    char name[PATH_MAX];
    const int length = snprintf(name, sizeof name, "%s", path);
    for (int i = length - 1; i > 0 && i < PATH_MAX - 1 && pl_path_is_separator(name[i]); i--)
        name[i] = '\0';
    const int is_folder = pl_file_find(name, &status) == 0 && status.kind == PL_FILE_FOLDER;
    return is_folder ? 0 : pl_output_check(name);
}

/** Whether path, which may be NULL, is standard output. */
static int is_stdout(const char *path) {
    return path && (strcmp(path, "-") == 0 || leads_to_stdout(path));
}

/** The mesh file that is written, or NULL: that of compare is read. */
static const char *written_mesh(const pl_arguments *arguments) {
    return arguments->command == PL_COMMAND_COMPARE ? NULL : arguments->output;
}

int pl_output_takes_stdout(const pl_arguments *arguments) {
    return is_stdout(written_mesh(arguments)) || is_stdout(arguments->json) ||
           is_stdout(arguments->report);
}

/* ---- nothing is replaced that nobody named for that -------------------------------------------- */

pl_read_file pl_output_read_file(const pl_arguments *arguments, int i) {
    const pl_read_file files[] = {{"the file of --like", arguments->like},
                                  {"the file of --surface-of", arguments->surface_of},
                                  {"the file of --onto", arguments->onto},
                                  {"the file of --size-from", arguments->size_from}};
    for (size_t k = 0; k < sizeof files / sizeof *files; k++)
        if (files[k].path && i-- == 0)
            return files[k];
    return (pl_read_file){NULL, NULL};
}

/** Say which file that is read writing to path would change; NULL: none. */
static const char *find_read(const pl_arguments *arguments, const char *path) {
    pl_read_file file;
    for (int i = 0; i < arguments->n_inputs; i++)
        if (pl_output_hits_mesh(path, arguments->inputs[i], arguments->format))
            return "the mesh";
    for (int i = 0; (file = pl_output_read_file(arguments, i)).path; i++)
        if (pl_output_hits_mesh(path, file.path, NULL))
            return file.what;
    return NULL;
}

/** A report at path (NULL, "-": fine) may not be a file that is read, or one of the mesh. */
static int check_report(const pl_arguments *arguments, const char *path) {
    const char *output = arguments->output;
    if (!path || strcmp(path, "-") == 0)
        return 0;
    const char *what = find_read(arguments, path);
    if (!what && output && pl_output_hits_mesh(path, output, arguments->format))
        what = "the mesh";
    return what ? pl_complain_usage(pl_command_name(arguments->typed),
                                    "the report would overwrite %s '%s'", what, path)
                : pl_output_check(path);
}

/** Whether OUT stands behind IN, and a file, a folder or a link, perhaps to nowhere, is there. */
static int is_taken(const pl_arguments *arguments) {
    const char *output = written_mesh(arguments);
    char link[2];
    if (!output || !arguments->output_is_operand || pl_output_is_stream(output))
        return 0;
    return pl_file_exists(output) || pl_path_read_link(output, link, sizeof link) == 0;
}

/** A pattern of the shell that means two meshes must not have the second one replaced. */
static int complain_of_taken(const pl_arguments *arguments) {
    const char *command = pl_command_name(arguments->typed), *output = arguments->output;
    pl_file_status found;
    if (pl_file_find(output, &found) == 0 && found.kind == PL_FILE_FOLDER)
        return pl_complain_usage(command, "the folder '%s' already exists: name a new OUT", output);
    if (arguments->command == PL_COMMAND_SMOOTH)
        return pl_complain_usage(command,
                                 "'%s' already exists: -o %s replaces it; to smooth several "
                                 "meshes, give --output-dir DIR or --in-place",
                                 output, output);
    return pl_complain_usage(command, "'%s' already exists: -o %s replaces it", output, output);
}

int pl_output_check_still_new(const pl_arguments *arguments) {
    return is_taken(arguments)
               ? pl_complain(
                     PL_EXIT_FAILED,
                     "%s: another program created this file meanwhile; planish wrote nothing",
                     arguments->output)
               : 0;
}

int pl_output_check_all(const pl_arguments *arguments) {
    const char *command = pl_command_name(arguments->typed);
    const char *output = written_mesh(arguments), *json = arguments->json;
    const char *report = arguments->report;
    int status;
    if (is_stdout(output) + is_stdout(json) + is_stdout(report) > 1)
        return pl_complain_usage(command, "only one of the mesh and the reports can go to standard "
                                          "output: name files for the others");
    const int is_copy =
        arguments->command == PL_COMMAND_QUALITY || arguments->command == PL_COMMAND_CONVERT;
    const char *what = is_copy && output ? find_read(arguments, output) : NULL;
    if (what)
        return pl_complain_usage(command, "the converted copy would overwrite %s '%s'", what,
                                 output);
    if (is_taken(arguments))
        return complain_of_taken(arguments);
    if (json && report && pl_output_same_file(json, report))
        return pl_complain_usage(command, "--json and --report name the same file '%s'", report);
    if ((status = check_report(arguments, json)))
        return status;
    if ((status = check_report(arguments, report)))
        return status;
    pl_file_status input;
    if (output && arguments->command == PL_COMMAND_SMOOTH &&
        pl_file_find(arguments->input, &input) == 0 && input.kind == PL_FILE_FOLDER)
        return check_beside_folder(output);
    return output ? pl_output_check(output) : 0;
}

int pl_output_write_text(const char *path, pl_temporary which, const char *text, size_t length,
                         planish_error *error) {
    if (strcmp(path, "-") == 0) {
        if (fwrite(text, 1, length, stdout) == length && fflush(stdout) == 0)
            return 0;
        snprintf(error->text, sizeof error->text, "standard output: %s", strerror(errno));
        clearerr(stdout); /* told once is enough */
        return PLANISH_ERROR_FILE;
    }
    const pl_temporaries temporaries = {pl_signals_temporary(which), PL_TEMPORARY_SIZE};
    pl_output output;
    int status = pl_output_open(path, temporaries, &output, error);
    if (!status)
        status = pl_output_write(&output, text, (int64_t)length, error);
    if (!status)
        status = pl_output_finish(&output, error);
    if (!status)
        status = pl_output_commit(&output, temporaries, error);
    pl_output_release(&output, temporaries);
    return status;
}
