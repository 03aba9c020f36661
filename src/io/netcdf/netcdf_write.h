/* netcdf_write: classic netCDF files that are written anew.
 *
 *   netcdf_out, netcdf_out_begin, _end       a file
 *   netcdf_out_name, netcdf_out_dimension    its dimensions,
 *   netcdf_out_text, _integer, _float        attributes of the file,
 *   netcdf_out_variable_add                  and variables
 *   netcdf_out_write                         write the header and the values of all variables
 *   netcdf_put_integer, _float, _double, _text    put a value: called by the owner of a variable
 *
 * A file is CDF-2 (64-bit offsets), or CDF-5 (64-bit data) where a variable is too large for that.
 * After an error nothing more is written; netcdf_out_end returns the error.
 */
#ifndef PL_IO_NETCDF_NETCDF_WRITE_H
#define PL_IO_NETCDF_NETCDF_WRITE_H

#include "io/netcdf/netcdf_format.h"
#include "io/view/writer.h"

enum { NETCDF_OUT_DIMS = 2 };

/** Largest variable of CDF-2, in bytes. */
#define NETCDF_OUT_LARGEST ((int64_t)UINT32_MAX - 3)

/** Name of a dimension or variable: a text, a number, and both again; what is NULL or 0 is left out.
 *  There may be very many names. */
typedef struct netcdf_out_name {
    const char *text[2]; /* borrowed until they are written */
    int32_t number[2];
} netcdf_out_name;

/** A variable. */
typedef struct netcdf_out_variable {
    netcdf_out_name name;
    netcdf_type type;
    int n_dims;
    int dim[NETCDF_OUT_DIMS]; /* indices of dimensions */
    const char *attribute; /* name of its only attribute, or NULL; borrowed until it is written, */
    const char *text;      /* as its value is */
    int kind;              /* the owner's, */
    int32_t of[2];         /* and so are these */
    int64_t begin;         /* byte of the first value */
} netcdf_out_variable;

/** A dimension. */
typedef struct netcdf_out_dim {
    netcdf_out_name name;
    int64_t length; /* 0: that of records */
} netcdf_out_dim;

/** An attribute of the file. */
typedef struct netcdf_out_attribute {
    const char *name, *text; /* borrowed; text NULL: a number */
    netcdf_type type;
    double value;
} netcdf_out_attribute;

typedef struct netcdf_out {
    io_writer writer;
    netcdf_out_dim *dim;             /* [n_dims] owned */
    netcdf_out_attribute *attribute; /* [n_attributes] owned */
    netcdf_out_variable *variable;   /* [n_variables] owned; those of records last */
    int64_t n_dims, n_attributes, n_variables;
    int64_t dim_capacity, attribute_capacity, variable_capacity;
    int64_t n_records; /* 0 or 1 */
    int64_t largest;   /* bytes of a variable, from which on the file is CDF-5 */
    int is_wide;       /* it is */
    int is_counted;    /* bytes are not written, but counted: */
    int64_t n_bytes;
} netcdf_out;

/** Begin a file. To be ended in any case. */
void netcdf_out_begin(netcdf_out *out, pl_output *output, planish_error *error);
/** Write waiting bytes, and release. Return the status of all that was written. */
int netcdf_out_end(netcdf_out *out);

/** Make room for so many dimensions and variables in a file that has none yet: room that grows takes more
 *  memory. */
void netcdf_out_reserve(netcdf_out *out, int64_t n_dims, int64_t n_variables);

/** Add a dimension; length 0: the one of records. Return its index. */
int netcdf_out_dimension(netcdf_out *out, netcdf_out_name name, int64_t length);

/** Add an attribute of the file. Texts are borrowed until they are written. */
void netcdf_out_text(netcdf_out *out, const char *name, const char *text);
void netcdf_out_integer(netcdf_out *out, const char *name, int32_t value);
void netcdf_out_float(netcdf_out *out, const char *name, float value);

/** Add a variable, which is copied. Variables of records stand behind the others. */
void netcdf_out_variable_add(netcdf_out *out, const netcdf_out_variable *variable);

/** Put all values of a variable, by netcdf_put_... */
typedef void netcdf_out_values(void *context, netcdf_out *out, const netcdf_out_variable *variable);

/** Write the file: its header, and the values of all variables, which values puts. */
void netcdf_out_write(netcdf_out *out, netcdf_out_values *values, void *context);

/** Put a value. */
void netcdf_put_integer(netcdf_out *out, int32_t value);
void netcdf_put_float(netcdf_out *out, float value);
void netcdf_put_double(netcdf_out *out, double value);
/** Put a text, cut off or filled up by zeros to length. */
void netcdf_put_text(netcdf_out *out, const char *text, int64_t length);

#endif
