/* format: the description of a format that its folder gives, and names of files.
 *
 *   io_format, io_format_...                    the formats
 *   io_target                                   what a mesh can be converted to
 *   planish_file, io_file_regions, _free_groups    a file that has been read
 *   io_format_has_extension, io_extension       extensions of paths
 *   io_companion_path, io_plain_companion_path  files beside the mesh
 *   io_is_hdf5                                  files of HDF5 by their content
 */
#ifndef PL_IO_CORE_FORMAT_H
#define PL_IO_CORE_FORMAT_H

#include "io/core/model.h"

#include "base/memory.h"

struct io_view; /* io/view/view.h */
struct io_losses;

/** Kind of file that a mesh of any format can be converted to. */
typedef struct io_target {
    const char *name; /* as in --to; NULL ends a list */
    /** Write the mesh to output, and note the data that the format cannot store. */
    int (*write)(const struct io_view *view, pl_output *output, struct io_losses *losses,
                 planish_error *error);
} io_target;

/** Meshes of a format that are folders. */
typedef struct io_folder {
    const char *const
        *files;        /* that such a folder has; the first has the coordinates. NULL ends it */
    int may_be_packed; /* each of them may be NAME.gz instead */
    /* Where in the folder that is given they may be, NULL-terminated: "", or paths in which the name
     * of one folder may be "*", any. */
    const char *const *places;
    const char *const *folders; /* whose files are copied along, NULL-terminated, or NULL */
    const char *of_places;      /* beginning of the names of folders that have coordinates, too, so
                                   that these must not stay beside new ones; or NULL */
    int (*is_copied)(const char *name); /* whether a file of that name is; NULL: all are */
} io_folder;

/** Description of a format. docs/formats.md, "A new format", has the order of a reader's calls.
 *
 *  recognise is asked before the name of the file. It gets any bytes, not only those of a mesh: the
 *  first 256 kB at most, unless the file is HDF5. The first format of the table in
 *  src/io/file/file.c that says 1 reads the file. So a format whose files may hold the marks of
 *  another stands before that one. A format without any mark says 0 and goes by its extensions.
 *
 *  field is called while the file is written, or the plane of the mesh is sought:
 *  - by several threads at once, so that it only reads the model;
 *  - with a cursor at text_offset (d = 0), or where it left the cursor (d > 0). text_offset of an
 *    absent coordinate is where it would begin, or the end of the line;
 *  - on bytes that may have changed since they were read. Where read succeeded and nothing changed,
 *    it must succeed. Otherwise it may fail, but never read outside of the input;
 *  - the rows of io_field say how it describes what is there, and what is missing.
 */
typedef struct io_format {
    const char *name;                                   /* as in --format and in messages */
    const char *const *extensions;                      /* with the dot, NULL-terminated */
    int (*recognise)(const char *data, int64_t size);   /* by content: 1 sure, 0 no */
    int (*read)(io_model *model, planish_error *error); /* model->input is there; NULL, and so is
                                                           recognise: the library is missing */
    /** Return the bytes of the HDF5 files that the input names, 0: none; they are opened in a child
     *  first. NULL: it names none. */
    int64_t (*hdf5_bytes)(const io_model *model);
    int has_no_end;                /* text that nothing tells the end of */
    const io_folder *folder;       /* its meshes are folders, and model->input is the file with the
                                coordinates; NULL: they are files */
    const char *const *companions; /* extensions of files that may lie beside, NULL-terminated; or
                                      NULL: there are none */
    /** Return whether the content of a file with such an extension is of a mesh as a companion is;
     *  NULL: always. */
    int (*is_companion)(const io_model *model, const io_bytes *file);
    /** Return whether what is written may have that name, whose extension is one of the format's;
     *  NULL: it may. */
    int (*may_be_called)(const io_model *model, const char *path);
    /** Find the field of coordinate d of a node in text, and leave the cursor behind it. 0 or -1.
     *  NULL: numbers are apart by white space and comments ('#'). */
    int (*field)(const io_model *model, io_cursor *cursor, int d, io_field *field);
    /** Add edits of the input for coordinates [n_nodes][written], as model->of_format says where
     *  these stand; NULL: spans say all. */
    int (*encode)(const io_model *model, const double *coordinates, int threads, io_edits *edits,
                  planish_error *error);
    /** Make the changes in the finished copy, output, that neither spans nor encode describe
     *  (compressed coordinates). If that goes to a pipe or device: before anything is written, fail
     *  if there is any such change. NULL: there is nothing of the kind. */
    int (*amend)(const io_model *model, const double *coordinates, pl_output *output,
                 planish_error *error);
    /** Read the values [n][data->width] of an array of model->data: of all nodes, or of the elements
     *  (io_data_pick). NULL: no data of this format are read. */
    int (*read_data)(io_model *model, const io_data *data, double *values, planish_error *error);
    void (*release)(io_model *model); /* of model->of_format; NULL: there is none */
    const io_target *targets; /* kinds of files of this format that are written anew, the first by
                                 default; NULL: none is */
    /** Fail if such a file can hold nothing of the mesh; NULL: it always can hold something. */
    int (*check_target)(const io_model *model, planish_error *error);
} io_format;

extern const io_format io_format_gmsh, io_format_medit, io_format_vtk, io_format_vtu,
    io_format_vtkhdf, io_format_tetgen, io_format_netgen, io_format_abaqus, io_format_nastran,
    io_format_cgns, io_format_med, io_format_plex, io_format_off, io_format_stl, io_format_obj,
    io_format_ply, io_format_mfem, io_format_exodus, io_format_ucd, io_format_su2, io_format_unv,
    io_format_elmer, io_format_foam, io_format_xdmf;

/** A group whose name is the tag of a region. */
typedef struct io_named {
    int64_t key;   /* its dimension and number */
    int64_t group; /* of the model */
} io_named;

/** Sorted lists that tags of regions are looked up in (tags.c). */
typedef struct io_tags {
    io_named *named;   /* [n_named] sorted; owned */
    int64_t *physical; /* [n_physical] keys of numbers of physical groups, sorted; owned */
    int64_t n_named, n_physical;
} io_tags;

/** A file that has been read. */
struct planish_file {
    io_model model;
    const io_format *format;
    int64_t n_regions;   /* distinct ones among the elements */
    planish_cells cells; /* the elements: simplices, then others; without arrays while these are
                            linear simplices alone and nobody has asked for them */
    /* Where there are others besides simplices, one after the other, else NULL: */
    int32_t *region;       /* of all elements, */
    int32_t *facet;        /* corners of facets that say something, */
    int64_t *facet_offset; /* [n + 1] where they begin */
    int32_t *facet_tag;    /* and their regions, or NULL */
    io_tags tags;
    /* planish_file_groups, once it was asked: */
    planish_group *group; /* [n_groups] owned; its tags are those of the model, or in */
    char *group_text;     /* owned */
    int64_t n_groups;
};

/** Free the list of groups. */
static inline void io_file_free_groups(planish_file *file) {
    pl_free(file->group);
    pl_free(file->group_text);
    file->group = NULL;
    file->group_text = NULL;
}

/** Return the regions of all elements, or NULL: there is one. */
static inline const int32_t *io_file_regions(const planish_file *file) {
    return file->region ? file->region : io_cells_regions(io_model_elements(&file->model));
}

/** Return whether path ends in one of the format's extensions, letter case ignored. */
int io_format_has_extension(const io_format *format, const char *path);

/** Find the extension of path: its dot, or the end. */
const char *io_extension(const char *path);

/** Make the path of the file with that extension, in any case, beside the mesh at path: it takes
 * the place of an extension of the format, and has capitals if that has no small letter; behind any
 * other name it is added. Owned; NULL without memory. */
char *io_companion_path(const io_format *format, const char *path, const char *extension);

/** Make the same path with the extension in small letters. */
char *io_plain_companion_path(const io_format *format, const char *path, const char *extension);

/** Return whether the bytes are an HDF5 file: its mark is at the start, or behind a user block. */
int io_is_hdf5(const char *data, int64_t size);

#endif
