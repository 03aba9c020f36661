/* netcdf_header: the header of a classic netCDF file; for netcdf*.c only.
 *
 *   netcdf_header_read, _release                       the header
 *   netcdf_header_dimension, _find, _text_attribute    what it says
 */
#ifndef PL_IO_NETCDF_NETCDF_HEADER_H
#define PL_IO_NETCDF_NETCDF_HEADER_H

#include "io/core/text.h"
#include "io/netcdf/netcdf_format.h"

/** Dimension; of length 0 it is that of records. */
typedef struct netcdf_dim {
    io_slice name;
    int64_t length;
} netcdf_dim;

enum { NETCDF_MOST_DIMS = 3 };

/** Variable. All its values are in the file. */
typedef struct netcdf_variable {
    io_slice name;
    io_cursor attributes; /* the list of them */
    int type;
    int is_record;                  /* it has n values in each record, or time step */
    int rank;                       /* without the dimension of records */
    int64_t dims[NETCDF_MOST_DIMS]; /* the first ones */
    int64_t n;                      /* product of all */
    int64_t begin;                  /* byte of the first value */
} netcdf_variable;

typedef struct netcdf_header {
    const io_model *model;
    netcdf_dim *dim; /* [n_dims] in the order of their names */
    int64_t n_dims, dim_capacity;
    netcdf_variable *variable; /* [n_variables] in the order of their names */
    int64_t n_variables, variable_capacity;
    int64_t n_records;
    int is_wide; /* CDF-5: counts have 64 bits */
} netcdf_header;

/** Read the header of model->input, and check that all values are in the file. Release in any case. */
int netcdf_header_read(const io_model *model, netcdf_header *header, planish_error *error);
void netcdf_header_release(netcdf_header *header);

/** Find the length of a dimension; 0: there is none. */
int64_t netcdf_header_dimension(const netcdf_header *header, const char *name);

/** Find a variable, or NULL. */
const netcdf_variable *netcdf_header_find(const netcdf_header *header, const char *name);

/** Find the text of a variable's attribute; empty if there is none. */
io_slice netcdf_header_text_attribute(const netcdf_header *header, const netcdf_variable *variable,
                                      const char *name);

#endif
