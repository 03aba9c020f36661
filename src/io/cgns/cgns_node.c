/* cgns_node: nodes of CGNS by their names and labels, and their data. */
#ifdef PL_HDF5
#include "io/cgns/cgns_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { LABEL_SIZE = 64 };

io_hdf5_path cgns_child(cgns_reader *r, const io_hdf5_path *parent, const char *name) {
    return io_hdf5_path_of(r->file, "%s/%s", parent->text[1] ? parent->text : "", name);
}

/** Find whether the object is a node with that label. */
static int has_label(cgns_reader *r, const char *path, const char *label, int *has) {
    char found_label[LABEL_SIZE] = "", type[LABEL_SIZE] = "";
    int found;
    *has = 0;
    if (io_hdf5_kind_of(r->file, path) != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status =
        io_hdf5_text_attribute(r->file, path, "label", found_label, sizeof found_label, &found);
    if (!status && found)
        status = io_hdf5_text_attribute(r->file, path, "type", type, sizeof type, NULL);
    if (!status && strcmp(type, "LK") == 0)
        return io_hdf5_fail(r->file, path,
                            "is a link of CGNS, which is not followed; make one file without "
                            "links, with hdf2adf and adf2hdf for instance");
    *has = !status && strcmp(found_label, label) == 0;
    return status;
}

int cgns_children(cgns_reader *r, const io_hdf5_path *path, const char *label,
                  io_hdf5_names *names) {
    int status = io_hdf5_list(r->file, path->text, names);
    const int64_t n = names->n;
    names->n = 0;
    for (int64_t i = 0; i < n && !status; i++) {
        int has;
        status = has_label(r, cgns_child(r, path, names->name[i]).text, label, &has);
        if (has)
            names->name[names->n++] = names->name[i];
    }
    return status;
}

int cgns_integers(cgns_reader *r, const io_hdf5_path *path, io_hdf5_integers *integers) {
    return io_hdf5_integers_read(r->file, cgns_child(r, path, " data").text, integers);
}

int cgns_text(cgns_reader *r, const io_hdf5_path *path, const char *child, char *text,
              size_t size) {
    const io_hdf5_path data = io_hdf5_path_of(r->file, "%s/%s/ data", path->text, child);
    char *content = NULL;
    int64_t n = 0, length = 0;
    text[0] = '\0';
    if (io_hdf5_kind_of(r->file, data.text) == IO_HDF5_NONE)
        return PLANISH_OK;
    const int status = io_hdf5_strings_read(r->file, data.text, &content, &n, &length);
    if (status)
        return status;
    const int64_t used = n * length < (int64_t)size ? n * length : (int64_t)size - 1;
    memcpy(text, content, (size_t)used);
    text[used] = '\0';
    for (size_t end = strlen(text); end > 0 && text[end - 1] == ' '; end--)
        text[end - 1] = '\0';
    pl_free(content);
    return PLANISH_OK;
}

#endif
