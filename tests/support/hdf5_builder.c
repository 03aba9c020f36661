/* hdf5_builder: files of HDF5, for tests of the formats in it. */
#ifdef PL_HDF5
#include "support/files.h"
#include "support/hdf5_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static hid_t must(hid_t result) {
    if (result < 0)
        fail_msg("the HDF5 library failed");
    return result;
}

int hdf5_superblock = 0, hdf5_has_pages = 0;
const int hdf5_superblocks[HDF5_SUPERBLOCKS] = {0, 2, 3};

void hdf5_begin(hdf5_builder *builder, hsize_t user_block) {
    const H5F_libver_t version = hdf5_superblock == 0   ? H5F_LIBVER_EARLIEST
                                 : hdf5_superblock == 2 ? H5F_LIBVER_V18
                                                        : H5F_LIBVER_V110;
    *builder = (hdf5_builder){.path = "/tmp/planish-hdf5-XXXXXX"};
    const int empty = mkstemp(builder->path);
    assert_true(empty >= 0);
    close(empty);
    hid_t access = must(H5Pcreate(H5P_FILE_ACCESS)), create = must(H5Pcreate(H5P_FILE_CREATE));
    must(H5Pset_libver_bounds(access, version,
                              hdf5_superblock == 2 ? H5F_LIBVER_V18 : H5F_LIBVER_LATEST));
    must(H5Pset_userblock(create, user_block));
    if (hdf5_has_pages)
        must(H5Pset_file_space_strategy(create, H5F_FSPACE_STRATEGY_PAGE, 1, 1));
    builder->file = must(H5Fcreate(builder->path, H5F_ACC_TRUNC, create, access));
    H5Pclose(create);
    H5Pclose(access);
}

void hdf5_group(const hdf5_builder *builder, const char *path) {
    hid_t links = must(H5Pcreate(H5P_LINK_CREATE));
    must(H5Pset_create_intermediate_group(links, 1));
    H5Gclose(must(H5Gcreate2(builder->file, path, links, H5P_DEFAULT, H5P_DEFAULT)));
    H5Pclose(links);
}

static hid_t storage(const hdf5_builder *builder, int rank, const hsize_t *dims) {
    hid_t list = must(H5Pcreate(H5P_DATASET_CREATE));
    if (builder->is_compact)
        must(H5Pset_layout(list, H5D_COMPACT));
    if (builder->chunk[0])
        must(H5Pset_chunk(list, rank, builder->chunk));
    else if (builder->is_one_chunk)
        must(H5Pset_chunk(list, rank, dims));
    if (builder->chunk[0] && builder->is_packed) {
        must(H5Pset_shuffle(list));
        must(H5Pset_deflate(list, 6));
    }
    return list;
}

void hdf5_array(const hdf5_builder *builder, const char *path, hid_t file_type, hid_t memory_type,
                hsize_t rows, hsize_t columns, const void *data) {
    const hsize_t dims[2] = {rows, columns};
    const int rank = columns ? 2 : 1;
    hid_t space = must(H5Screate_simple(rank, dims, NULL)), list = storage(builder, rank, dims);
    hid_t set =
        must(H5Dcreate2(builder->file, path, file_type, space, H5P_DEFAULT, list, H5P_DEFAULT));
    must(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    H5Dclose(set);
    H5Pclose(list);
    H5Sclose(space);
}

void hdf5_integers(const hdf5_builder *builder, const char *path, hsize_t n, const int *data) {
    hdf5_array(builder, path, H5T_STD_I32LE, H5T_NATIVE_INT, n, 0, data);
}

void hdf5_reals(const hdf5_builder *builder, const char *path, hsize_t n, const double *data) {
    hdf5_array(builder, path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, n, 0, data);
}

static void write_attribute(const hdf5_builder *builder, const char *path, const char *name,
                            hid_t file_type, hid_t memory_type, const void *value) {
    hid_t space = must(H5Screate(H5S_SCALAR));
    hid_t attribute = must(H5Acreate_by_name(builder->file, path, name, file_type, space,
                                             H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    must(H5Awrite(attribute, memory_type, value));
    H5Aclose(attribute);
    H5Sclose(space);
}

void hdf5_attribute(const hdf5_builder *builder, const char *path, const char *name, int value) {
    write_attribute(builder, path, name, H5T_STD_I32LE, H5T_NATIVE_INT, &value);
}

void hdf5_text_attribute(const hdf5_builder *builder, const char *path, const char *name,
                         const char *text) {
    hid_t type = must(H5Tcopy(H5T_C_S1));
    must(H5Tset_size(type, strlen(text) + 1));
    write_attribute(builder, path, name, type, type, text);
    H5Tclose(type);
}

void cgns_put_node(const hdf5_builder *b, const char *path, const char *label) {
    hdf5_group(b, path);
    hdf5_text_attribute(b, path, "label", label);
    hdf5_text_attribute(b, path, "type", "MT");
}

void cgns_put_integers(const hdf5_builder *b, const char *path, const char *label, int n,
                       const int *data) {
    char place[300];
    cgns_put_node(b, path, label);
    snprintf(place, sizeof place, "%s/ data", path);
    hdf5_integers(b, place, (hsize_t)n, data);
}

void cgns_put_section(const hdf5_builder *b, const char *path, int type, int first, int last, int n,
                      const int *nodes) {
    char place[256];
    cgns_put_integers(b, path, "Elements_t", 2, (const int[]){type, 0});
    snprintf(place, sizeof place, "%s/ElementRange", path);
    cgns_put_integers(b, place, "IndexRange_t", 2, (const int[]){first, last});
    snprintf(place, sizeof place, "%s/ElementConnectivity", path);
    cgns_put_integers(b, place, "DataArray_t", n, nodes);
}

void cgns_put_text(const hdf5_builder *b, const char *path, const char *label, const char *text) {
    char place[300];
    cgns_put_node(b, path, label);
    snprintf(place, sizeof place, "%s/ data", path);
    hdf5_array(b, place, H5T_STD_I8LE, H5T_NATIVE_CHAR, strlen(text), 0, text);
}

file_builder hdf5_end(hdf5_builder *builder) {
    size_t size;
    must(H5Fclose(builder->file));
    file_builder result = {.data = test_read(builder->path, &size)};
    result.size = result.capacity = (int64_t)size;
    remove(builder->path);
    return result;
}

#else
typedef int planish_without_hdf5;
#endif
