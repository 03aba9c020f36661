/* netcdf_write: classic netCDF files that are written anew, by the NetCDF Classic Format Specification
 * (netcdf_header.c reads the same). Values are not kept: their owner puts them, variable by variable.
 */
#include "io/netcdf/netcdf_write.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <stdio.h>
#include <string.h>

/* ---- bytes ---------------------------------------------------------------------------------- */

/** Put bytes, or count them. */
static void put(netcdf_out *out, const void *bytes, size_t size) {
    out->n_bytes += (int64_t)size;
    if (!out->is_counted)
        io_put_bytes(&out->writer, bytes, size);
}

/** Put a number of 4 or 8 bytes, given by its bits. */
static void put_bits(netcdf_out *out, uint64_t bits, size_t size) {
    unsigned char bytes[8];
    for (size_t k = 0; k < size; k++)
        bytes[k] = (unsigned char)(bits >> 8 * (size - 1 - k));
    put(out, bytes, size);
}

/** Put zeros behind size bytes, up to 4. */
static void put_padding(netcdf_out *out, int64_t size) {
    static const char zeros[4] = {0};
    put(out, zeros, (size_t)((4 - size % 4) % 4));
}

void netcdf_put_integer(netcdf_out *out, int32_t value) {
    put_bits(out, (uint32_t)value, sizeof value);
}

void netcdf_put_float(netcdf_out *out, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_bits(out, bits, sizeof bits);
}

void netcdf_put_double(netcdf_out *out, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_bits(out, bits, sizeof bits);
}

void netcdf_put_text(netcdf_out *out, const char *text, int64_t length) {
    const int64_t all = (int64_t)strlen(text), n = all < length ? all : length;
    put(out, text, (size_t)n);
    for (int64_t i = n; i < length; i++)
        put(out, "", 1);
}

/* ---- the header ----------------------------------------------------------------------------- */

enum { NAME_SIZE = 64 }; /* two texts of 16 bytes and two numbers */

/** Put a count, or the size of something. */
static void put_count(netcdf_out *out, int64_t n) {
    put_bits(out, (uint64_t)n, out->is_wide ? 8 : 4);
}

static void put_list(netcdf_out *out, int tag, int64_t n) {
    netcdf_put_integer(out, n > 0 ? tag : NETCDF_NO_LIST);
    put_count(out, n);
}

static void put_padded(netcdf_out *out, const char *text) {
    const int64_t n = (int64_t)strlen(text);
    put_count(out, n);
    netcdf_put_text(out, text, n);
    put_padding(out, n);
}

static void put_name(netcdf_out *out, const netcdf_out_name *name) {
    char text[NAME_SIZE] = "";
    int used = 0;
    for (int k = 0; k < 2; k++) {
        if (name->text[k])
            used += snprintf(text + used, sizeof text - (size_t)used, "%.16s", name->text[k]);
        if (name->number[k])
            used += snprintf(text + used, sizeof text - (size_t)used, "%d", (int)name->number[k]);
    }
    put_padded(out, text);
}

static void put_attribute(netcdf_out *out, const netcdf_out_attribute *a) {
    put_padded(out, a->name);
    netcdf_put_integer(out, (int32_t)a->type);
    if (a->text) {
        put_padded(out, a->text);
        return;
    }
    put_count(out, 1);
    if (a->type == NETCDF_FLOAT)
        netcdf_put_float(out, (float)a->value);
    else
        netcdf_put_integer(out, (int32_t)a->value);
}

/** Return the bytes of all values of a variable, without what fills them up. */
static int64_t bytes_of(const netcdf_out *out, const netcdf_out_variable *v) {
    int64_t n = netcdf_type_size(v->type);
    for (int d = 0; d < v->n_dims; d++) {
        const int64_t length = out->dim[v->dim[d]].length;
        n *= length > 0 ? length : 1;
    }
    return n;
}

/** Return the same with what fills them up. */
static int64_t room_of(const netcdf_out *out, const netcdf_out_variable *v) {
    const int64_t bytes = bytes_of(out, v);
    return bytes + (4 - bytes % 4) % 4;
}

static int is_of_records(const netcdf_out *out, const netcdf_out_variable *v) {
    return v->n_dims > 0 && out->dim[v->dim[0]].length == 0;
}

static void put_variable(netcdf_out *out, const netcdf_out_variable *v) {
    put_name(out, &v->name);
    put_count(out, v->n_dims);
    for (int d = 0; d < v->n_dims; d++)
        put_count(out, v->dim[d]);
    put_list(out, NETCDF_ATTRIBUTES, v->attribute != NULL);
    if (v->attribute)
        put_attribute(out, &(netcdf_out_attribute){v->attribute, v->text, NETCDF_CHAR, 0});
    netcdf_put_integer(out, (int32_t)v->type);
    put_count(out, room_of(out, v));
    put_bits(out, (uint64_t)v->begin, 8);
}

static void put_header(netcdf_out *out) {
    put(out, out->is_wide ? "CDF\5" : "CDF\2", 4);
    put_count(out, out->n_records);
    put_list(out, NETCDF_DIMENSIONS, out->n_dims);
    for (int64_t i = 0; i < out->n_dims; i++) {
        put_name(out, &out->dim[i].name);
        put_count(out, out->dim[i].length);
    }
    put_list(out, NETCDF_ATTRIBUTES, out->n_attributes);
    for (int64_t i = 0; i < out->n_attributes; i++)
        put_attribute(out, &out->attribute[i]);
    put_list(out, NETCDF_VARIABLES, out->n_variables);
    for (int64_t i = 0; i < out->n_variables; i++)
        put_variable(out, &out->variable[i]);
}

/** Find where the values of variables begin. */
static void find_places(netcdf_out *out) {
    for (int64_t i = 0; i < out->n_variables; i++)
        out->is_wide |= room_of(out, &out->variable[i]) > out->largest;
    out->is_counted = 1;
    put_header(out);
    out->is_counted = 0;
    int64_t begin = out->n_bytes;
    for (int64_t i = 0; i < out->n_variables; i++) {
        out->variable[i].begin = begin;
        begin += room_of(out, &out->variable[i]);
    }
}

/* ---- the file ------------------------------------------------------------------------------- */

void netcdf_out_begin(netcdf_out *out, pl_output *output, planish_error *error) {
    *out = (netcdf_out){.largest = NETCDF_OUT_LARGEST};
    io_writer_begin(&out->writer, output, error);
}

int netcdf_out_end(netcdf_out *out) {
    pl_free(out->dim);
    pl_free(out->attribute);
    pl_free(out->variable);
    return io_writer_end(&out->writer);
}

/** Note the result of pl_append. */
static void check_appended(netcdf_out *out, const void *appended) {
    if (!appended && !out->writer.status)
        out->writer.status = pl_fail_memory(out->writer.error, "the header of the file");
}

void netcdf_out_reserve(netcdf_out *out, int64_t n_dims, int64_t n_variables) {
    out->dim = pl_alloc(n_dims, sizeof *out->dim);
    out->variable = pl_alloc(n_variables, sizeof *out->variable);
    out->dim_capacity = out->dim ? n_dims : 0;
    out->variable_capacity = out->variable ? n_variables : 0;
    check_appended(out, out->variable ? out->dim : NULL);
}

int netcdf_out_dimension(netcdf_out *out, netcdf_out_name name, int64_t length) {
    const netcdf_out_dim dim = {name, length};
    check_appended(out, pl_append(&out->dim, &out->n_dims, &out->dim_capacity, &dim, sizeof dim));
    return (int)(out->n_dims - 1);
}

static void add_attribute(netcdf_out *out, netcdf_out_attribute attribute) {
    check_appended(out, pl_append(&out->attribute, &out->n_attributes, &out->attribute_capacity,
                                  &attribute, sizeof attribute));
}

void netcdf_out_text(netcdf_out *out, const char *name, const char *text) {
    add_attribute(out, (netcdf_out_attribute){name, text, NETCDF_CHAR, 0});
}

void netcdf_out_integer(netcdf_out *out, const char *name, int32_t value) {
    add_attribute(out, (netcdf_out_attribute){name, NULL, NETCDF_INT, value});
}

void netcdf_out_float(netcdf_out *out, const char *name, float value) {
    add_attribute(out, (netcdf_out_attribute){name, NULL, NETCDF_FLOAT, (double)value});
}

void netcdf_out_variable_add(netcdf_out *out, const netcdf_out_variable *variable) {
    check_appended(out, pl_append(&out->variable, &out->n_variables, &out->variable_capacity,
                                  variable, sizeof *variable));
}

void netcdf_out_write(netcdf_out *out, netcdf_out_values *values, void *context) {
    if (out->writer.status)
        return;
    find_places(out);
    put_header(out);
    for (int64_t i = 0; i < out->n_variables && !out->writer.status; i++) {
        const netcdf_out_variable *v = &out->variable[i];
        if (is_of_records(out, v) && out->n_records == 0)
            break;
        values(context, out, v);
        put_padding(out, bytes_of(out, v));
    }
}
