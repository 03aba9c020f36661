/* vtk_numbers: the numbers of VTK's arrays, whatever file they stand in. */
#include "io/vtk/vtk_numbers.h"

#include "io/core/arrays.h"
#include "io/core/binary.h"

#include <string.h>

/* vtkIdType is written as int. */
static const vtk_type legacy_types[] = {{"float", VTK_REAL, 4},
                                        {"double", VTK_REAL, 8},
                                        {"int", VTK_SIGNED, 4},
                                        {"vtktypeint64", VTK_SIGNED, 8},
                                        {"vtktypeint32", VTK_SIGNED, 4},
                                        {"vtkidtype", VTK_SIGNED, 4},
                                        {"char", VTK_SIGNED, 1},
                                        {"signed_char", VTK_SIGNED, 1},
                                        {"unsigned_char", VTK_UNSIGNED, 1},
                                        {"short", VTK_SIGNED, 2},
                                        {"unsigned_short", VTK_UNSIGNED, 2},
                                        {"unsigned_int", VTK_UNSIGNED, 4},
                                        {"long", VTK_SIGNED, 8},
                                        {"unsigned_long", VTK_UNSIGNED, 8},
                                        {"vtktypeuint64", VTK_UNSIGNED, 8},
                                        {"vtktypeuint32", VTK_UNSIGNED, 4},
                                        {"vtktypeint16", VTK_SIGNED, 2},
                                        {"vtktypeuint16", VTK_UNSIGNED, 2},
                                        {"vtktypeint8", VTK_SIGNED, 1},
                                        {"vtktypeuint8", VTK_UNSIGNED, 1},
                                        {"bit", VTK_BIT, 0},
                                        {"string", VTK_STRING, 0}};

static const vtk_type xml_types[] = {{"Float32", VTK_REAL, 4},    {"Float64", VTK_REAL, 8},
                                     {"Int64", VTK_SIGNED, 8},    {"Int32", VTK_SIGNED, 4},
                                     {"UInt8", VTK_UNSIGNED, 1},  {"Int8", VTK_SIGNED, 1},
                                     {"UInt64", VTK_UNSIGNED, 8}, {"UInt32", VTK_UNSIGNED, 4},
                                     {"UInt16", VTK_UNSIGNED, 2}, {"Int16", VTK_SIGNED, 2}};

const vtk_type *vtk_find_type(io_slice name) {
    for (size_t i = 0; i < sizeof legacy_types / sizeof *legacy_types; i++)
        if (io_slice_is(name, legacy_types[i].name, 1))
            return &legacy_types[i];
    return NULL;
}

const vtk_type *vtk_find_xml_type(io_slice name) {
    for (size_t i = 0; i < sizeof xml_types / sizeof *xml_types; i++)
        if (io_slice_is(name, xml_types[i].name, 0))
            return &xml_types[i];
    return NULL;
}

/** Return the number at at, of whole bytes, as an integer: it is no real, and unsigned ones of 64 bits
 *  are taken by their bits. */
static int64_t integer_of(const char *at, const vtk_type *type, int swapped) {
    const int is_signed = type->kind == VTK_SIGNED;
    switch (type->size) {
    case 1:
        return is_signed ? (int64_t)(signed char)*at : (int64_t)(unsigned char)*at;
    case 2:
        return is_signed ? (int64_t)(int16_t)io_load_u16(at, swapped)
                         : (int64_t)io_load_u16(at, swapped);
    case 4:
        return is_signed ? (int64_t)io_load_i32(at, swapped) : (int64_t)io_load_u32(at, swapped);
    default: /* unsigned ones beyond 2^63 become negative: out of range as well */
        return io_load_i64(at, swapped);
    }
}

double vtk_real(const char *at, const vtk_type *type, int swapped) {
    if (type->kind != VTK_REAL)
        return (double)integer_of(at, type, swapped);
    return type->size == 4 ? (double)io_load_f32(at, swapped) : io_load_f64(at, swapped);
}

int vtk_whole(const char *data, int64_t i, const vtk_type *type, int swapped, int64_t *value) {
    if (type->kind == VTK_BIT) {
        *value = ((unsigned char)data[i / 8] >> (7 - i % 8)) & 1;
        return 1;
    }
    const char *at = data + i * type->size;
    if (type->kind == VTK_REAL)
        return io_array_whole(vtk_real(at, type, swapped), value);
    *value = integer_of(at, type, swapped);
    return 1;
}

/** Read whole numbers of 8 bytes, as most programs write cells. Return 0, and leave the cursor where it
 *  is, if one of them is out of range. */
static int read_long(const vtk_list *list, io_cursor *cursor, int64_t begin, int64_t end) {
    const char *at = cursor->at;
    int in_range = 1;
    for (int64_t i = begin; i < end; i++) {
        const int64_t value = io_load_i64(at + 8 * (i - begin), list->swapped);
        if (list->wide)
            list->wide[i] = value;
        else
            list->narrow[i] = (int32_t)value;
        in_range &= list->wide || value == (int32_t)value;
    }
    cursor->at += in_range ? 8 * (end - begin) : 0;
    return in_range;
}

int vtk_read_list(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                  planish_error *error) {
    const vtk_list *list = context;
    if (list->narrow && list->type && list->type->kind == VTK_SIGNED && list->type->size == 4) {
        /* The usual cells, which are always in range: several at a time. */
        const char *at = cursor->at;
        for (int64_t i = begin; i < end; i++)
            list->narrow[i] = io_load_i32(at + 4 * (i - begin), list->swapped);
        cursor->at += 4 * (end - begin);
        return PLANISH_OK;
    }
    if ((list->narrow || list->wide) && list->type && list->type->kind == VTK_SIGNED &&
        list->type->size == 8 && read_long(list, cursor, begin, end))
        return PLANISH_OK;
    for (int64_t i = begin; i < end; i++) {
        const char *at = cursor->at;
        int64_t value = 0;
        if (list->type) {
            cursor->at += list->type->size;
            if (list->real)
                list->real[i] = vtk_real(at, list->type, list->swapped);
            else
                value = integer_of(at, list->type, list->swapped);
        } else {
            if (list->real ? io_real(cursor, &list->real[i]) : io_integer(cursor, &value))
                return io_fail_at(list->model, cursor->at, error,
                                  "%s: a %snumber expected (the file may be cut short)", list->name,
                                  list->real ? "" : "whole ");
            at = cursor->at;
        }
        if (list->wide)
            list->wide[i] = value;
        else if (list->narrow)
            list->narrow[i] = (int32_t)value;
        if (list->narrow && (value < INT32_MIN || value > INT32_MAX))
            return io_fail_at(list->model, at, error, "%s: a number is out of range", list->name);
    }
    return PLANISH_OK;
}

void vtk_order_tensors(double *values, int64_t n, int64_t width) {
    static const int from[6] = {0, 3, 1, 5, 4, 2};
    for (int64_t i = 0; i < n && width == 6; i++) {
        double *at = values + 6 * i, tensor[6];
        memcpy(tensor, at, sizeof tensor);
        for (int k = 0; k < 6; k++)
            at[k] = tensor[from[k]];
    }
}
