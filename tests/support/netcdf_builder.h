/* netcdf_builder: netCDF files of every kind in memory, for tests of the formats in it. */
#ifndef TEST_SUPPORT_NETCDF_BUILDER_H
#define TEST_SUPPORT_NETCDF_BUILDER_H

#include "support/file_builder.h"

enum { NETCDF_MOST_PARTS = 48 };

/** Types of values, by netCDF's numbers. */
enum {
    NETCDF_AS_TEXT = 2,
    NETCDF_AS_INT = 4,
    NETCDF_AS_FLOAT,
    NETCDF_AS_DOUBLE,
    NETCDF_AS_INT64 = 10
};

/** A variable: rows of columns (0: it has one dimension), or a dimension (type 0) of rows. */
typedef struct netcdf_part {
    char name[32];
    char text[32]; /* its attribute elem_type, or "" */
    int type, rows, columns;
    int is_by_step; /* rows are time steps */
    double *value;  /* [rows][columns], owned */
} netcdf_part;

typedef struct netcdf_builder {
    int kind;                            /* 1, 2, 5: CDF-1, -2, -5; 4: netCDF-4, in HDF5 */
    int is_packed;                       /* 4: shuffled and deflated */
    netcdf_part part[NETCDF_MOST_PARTS]; /* [n] */
    int n;
} netcdf_builder;

/** Add a dimension without a variable. */
void netcdf_put_dimension(netcdf_builder *builder, const char *name, int length);

/** Add a variable: rows of columns, or (columns 0) rows values. Return it; its attribute and
 *  is_by_step may be set then. */
netcdf_part *netcdf_put_integers(netcdf_builder *builder, const char *name, int rows, int columns,
                                 const int *values);
netcdf_part *netcdf_put_reals(netcdf_builder *builder, const char *name, int type, int rows,
                              int columns, const double *values);

/** Add texts of 8 characters, zeros behind them. */
void netcdf_put_texts(netcdf_builder *builder, const char *name, int n, const char *const *texts);

/** Find a variable or dimension. */
netcdf_part *netcdf_find_part(netcdf_builder *builder, const char *name);

/** Make the file's bytes, to be released by builder_release, and release the builder's. Without HDF5
 *  those of kind 4 are of kind 5. */
file_builder netcdf_end_file(netcdf_builder *builder);

#endif
