/* hdf5_builder: files of HDF5, for tests of the formats in it. */
#ifndef TEST_SUPPORT_HDF5_BUILDER_H
#define TEST_SUPPORT_HDF5_BUILDER_H

#ifdef PL_HDF5
#include "support/file_builder.h"

#include <hdf5.h>

typedef struct hdf5_builder {
    hid_t file;
    char path[32]; /* of it, until it is closed */
    /* How the next arrays are stored: */
    int is_compact;
    hsize_t chunk[2]; /* 0: not in chunks */
    int is_packed;    /* with chunks: shuffled and deflated */
    int is_one_chunk; /* without: all of it in one */
} hdf5_builder;

/** Version of the superblock of files that are begun: 0, 2 or 3. A test that sets it sets it back to 0. */
extern int hdf5_superblock;

/** Whether files that are begun keep their free space, in pages. A test that sets it sets it back to 0. */
extern int hdf5_has_pages;

/** All of them. */
enum { HDF5_SUPERBLOCKS = 3 };
extern const int hdf5_superblocks[HDF5_SUPERBLOCKS];

/** user_block: bytes before HDF5's own, 0 or 512. */
void hdf5_begin(hdf5_builder *builder, hsize_t user_block);

/** The group at path, and those above it. */
void hdf5_group(const hdf5_builder *builder, const char *path);

/** An array of one dimension, or of two (rows and columns), at path in a group that is there:
 *  file_type is how values stand in the file, data are of memory_type. */
void hdf5_array(const hdf5_builder *builder, const char *path, hid_t file_type, hid_t memory_type,
                hsize_t rows, hsize_t columns, const void *data);
void hdf5_integers(const hdf5_builder *builder, const char *path, hsize_t n, const int *data);
void hdf5_reals(const hdf5_builder *builder, const char *path, hsize_t n, const double *data);

void hdf5_attribute(const hdf5_builder *builder, const char *path, const char *name, int value);
void hdf5_text_attribute(const hdf5_builder *builder, const char *path, const char *name,
                         const char *text);

/** A node of CGNS at path: its label, and that it has no data, integers [n], or a text. */
void cgns_put_node(const hdf5_builder *builder, const char *path, const char *label);
void cgns_put_integers(const hdf5_builder *builder, const char *path, const char *label, int n,
                       const int *data);
void cgns_put_text(const hdf5_builder *builder, const char *path, const char *label,
                   const char *text);

/** A section of CGNS at path: elements first to last of a type, by n numbers of nodes (and of types). */
void cgns_put_section(const hdf5_builder *builder, const char *path, int type, int first, int last,
                      int n, const int *nodes);

/** Close it; the file's bytes, to be released by builder_release. */
file_builder hdf5_end(hdf5_builder *builder);

#endif
#endif
