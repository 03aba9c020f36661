/* netcdf_builder: netCDF files of every kind in memory. */
#include "support/netcdf_builder.h"
#include "support/hdf5_builder.h"

#include "io/core/binary.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { TEXT_LENGTH = 8 };

static netcdf_part *put(netcdf_builder *b, const char *name, int type, int rows, int columns) {
    assert_true(b->n < NETCDF_MOST_PARTS);
    netcdf_part *part = &b->part[b->n++];
    *part = (netcdf_part){.type = type, .rows = rows, .columns = columns};
    snprintf(part->name, sizeof part->name, "%s", name);
    part->value = calloc((size_t)rows * (size_t)(columns ? columns : 1) + 1, sizeof *part->value);
    assert_non_null(part->value);
    return part;
}

static int count(const netcdf_part *part) {
    return part->rows * (part->columns ? part->columns : 1);
}

void netcdf_put_dimension(netcdf_builder *b, const char *name, int length) {
    put(b, name, 0, length, 0);
}

netcdf_part *netcdf_put_integers(netcdf_builder *b, const char *name, int rows, int columns,
                                 const int *values) {
    netcdf_part *part = put(b, name, NETCDF_AS_INT, rows, columns);
    for (int i = 0; i < count(part); i++)
        part->value[i] = values[i];
    return part;
}

netcdf_part *netcdf_put_reals(netcdf_builder *b, const char *name, int type, int rows, int columns,
                              const double *values) {
    netcdf_part *part = put(b, name, type, rows, columns);
    memcpy(part->value, values, (size_t)count(part) * sizeof *values);
    return part;
}

void netcdf_put_texts(netcdf_builder *b, const char *name, int n, const char *const *texts) {
    netcdf_part *part = put(b, name, NETCDF_AS_TEXT, n, TEXT_LENGTH);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < TEXT_LENGTH && texts[i][j]; j++)
            part->value[TEXT_LENGTH * i + j] = texts[i][j];
}

netcdf_part *netcdf_find_part(netcdf_builder *b, const char *name) {
    for (int i = 0; i < b->n; i++)
        if (strcmp(b->part[i].name, name) == 0)
            return &b->part[i];
    fail_msg("no variable %s", name);
    return NULL;
}

/* ---- classic files --------------------------------------------------------------------------- */

static int size_of(int type) {
    static const int sizes[] = {[NETCDF_AS_TEXT] = 1,
                                [NETCDF_AS_INT] = 4,
                                [NETCDF_AS_FLOAT] = 4,
                                [NETCDF_AS_DOUBLE] = 8,
                                [NETCDF_AS_INT64] = 8};
    return sizes[type];
}

static void pad(file_builder *b) {
    while (b->size % 4)
        builder_integer(b, 0, 1);
}

static void put_name(file_builder *b, int wide, const char *name) {
    builder_integer(b, (int64_t)strlen(name), wide);
    builder_text(b, "%s", name);
    pad(b);
}

/** Put the tag of a list of n things; of none there is no tag. */
static void put_list(file_builder *b, int wide, int tag, int n) {
    builder_integer(b, n ? tag : 0, 4);
    builder_integer(b, n, wide);
}

static void put_values(file_builder *b, const netcdf_part *part, int begin, int end) {
    const int size = size_of(part->type);
    for (int i = begin; i < end; i++)
        if (part->type == NETCDF_AS_FLOAT || part->type == NETCDF_AS_DOUBLE)
            builder_real(b, part->value[i], size);
        else
            builder_integer(b, (int64_t)part->value[i], size);
    pad(b);
}

/** Put the dimensions: that of time steps, and those of each variable. */
static void put_dimensions(const netcdf_builder *n, file_builder *b, int wide) {
    char name[32];
    put_list(b, wide, 10, 2 * n->n + 1);
    put_name(b, wide, "time_step");
    builder_integer(b, 0, wide);
    for (int i = 0; i < n->n; i++) {
        const netcdf_part *part = &n->part[i];
        for (int d = 0; d < 2; d++) {
            snprintf(name, sizeof name, "%s_%d", part->name, d);
            put_name(b, wide, part->type || d ? name : part->name);
            builder_integer(b, d == 0 ? part->rows : part->columns + !part->columns, wide);
        }
    }
}

/** Put the variables, the values of which begin at begin [n]. */
static void put_variables(const netcdf_builder *n, file_builder *b, int wide, const int *begin) {
    int n_variables = 0;
    for (int i = 0; i < n->n; i++)
        n_variables += n->part[i].type != 0;
    put_list(b, wide, 11, n_variables);
    for (int i = 0; i < n->n; i++) {
        const netcdf_part *part = &n->part[i];
        const int rank = part->columns ? 2 : 1, has_text = part->text[0] != '\0';
        if (!part->type)
            continue;
        put_name(b, wide, part->name);
        builder_integer(b, rank, wide);
        builder_integer(b, part->is_by_step ? 0 : 2 * i + 1, wide);
        if (rank == 2)
            builder_integer(b, 2 * i + 2, wide);
        put_list(b, wide, 12, has_text);
        if (has_text) {
            put_name(b, wide, "elem_type");
            builder_integer(b, NETCDF_AS_TEXT, 4);
            put_name(b, wide, part->text);
        }
        builder_integer(b, part->type, 4);
        builder_integer(b, 0, wide);
        builder_integer(b, begin[i], n->kind == 1 ? 4 : 8);
    }
}

static void put_header(const netcdf_builder *n, file_builder *b, const int *begin, int n_steps) {
    const int wide = n->kind == 5 ? 8 : 4;
    b->size = 0;
    builder_text(b, "CDF");
    builder_integer(b, n->kind, 1);
    builder_integer(b, n_steps, wide);
    put_dimensions(n, b, wide);
    put_list(b, wide, 12, 1);
    put_name(b, wide, "title");
    builder_integer(b, NETCDF_AS_TEXT, 4);
    put_name(b, wide, "a test");
    put_variables(n, b, wide, begin);
}

/** Put the values of all variables: those by time steps come last, a step of all after another. */
static void put_all_values(const netcdf_builder *n, file_builder *b, int *begin, int n_steps) {
    for (int step = -1; step < n_steps; step++)
        for (int i = 0; i < n->n; i++) {
            const netcdf_part *part = &n->part[i];
            if (!part->type || part->is_by_step != (step >= 0))
                continue;
            if (step <= 0)
                begin[i] = (int)b->size;
            const int first = step < 0 ? 0 : step * part->columns;
            put_values(b, part, first, step < 0 ? count(part) : first + part->columns);
        }
}

static file_builder make_classic(netcdf_builder *n) {
    file_builder b = {.binary = 1, .swapped = io_machine_is_little()};
    int begin[NETCDF_MOST_PARTS] = {0}, n_steps = 0;
    for (int i = 0; i < n->n; i++)
        n_steps = n->part[i].is_by_step ? n->part[i].rows : n_steps;
    for (int pass = 0; pass < 2; pass++) { /* the first finds the length of the header */
        put_header(n, &b, begin, n_steps);
        put_all_values(n, &b, begin, n_steps);
    }
    return b;
}

/* ---- files in HDF5 --------------------------------------------------------------------------- */

#ifdef PL_HDF5
static file_builder make_hdf5(netcdf_builder *n) {
    hdf5_builder b;
    hdf5_begin(&b, 0);
    hid_t text = H5Tcopy(H5T_C_S1);
    for (int i = 0; i < n->n; i++) {
        const netcdf_part *part = &n->part[i];
        char path[64], characters[1024] = "";
        snprintf(path, sizeof path, "/%s", part->name);
        const int is_text = part->type == NETCDF_AS_TEXT;
        const hid_t types[] = {[0] = H5T_IEEE_F32BE,
                               [NETCDF_AS_TEXT] = text,
                               [NETCDF_AS_INT] = H5T_STD_I32LE,
                               [NETCDF_AS_FLOAT] = H5T_IEEE_F32LE,
                               [NETCDF_AS_DOUBLE] = H5T_IEEE_F64LE,
                               [NETCDF_AS_INT64] = H5T_STD_I64LE};
        for (int k = 0; is_text && k < count(part); k++)
            characters[k] = (char)part->value[k];
        b.is_packed = n->is_packed;
        b.chunk[0] = n->is_packed && part->type >= NETCDF_AS_FLOAT ? 4 : 0;
        b.chunk[1] = part->columns > 1 ? 2 : 1;
        if (b.chunk[0] > (hsize_t)part->rows)
            b.chunk[0] = (hsize_t)part->rows;
        hdf5_array(&b, path, types[part->type], is_text ? text : H5T_NATIVE_DOUBLE,
                   (hsize_t)part->rows, (hsize_t)part->columns,
                   is_text ? (const void *)characters : part->value);
        if (part->text[0])
            hdf5_text_attribute(&b, path, "elem_type", part->text);
    }
    H5Tclose(text);
    return hdf5_end(&b);
}
#endif

file_builder netcdf_end_file(netcdf_builder *n) {
    file_builder result;
#ifdef PL_HDF5
    result = n->kind == 4 ? make_hdf5(n) : make_classic(n);
#else
    n->kind = n->kind == 4 ? 5 : n->kind;
    result = make_classic(n);
#endif
    for (int i = 0; i < n->n; i++)
        free(n->part[i].value);
    n->n = 0;
    return result;
}
