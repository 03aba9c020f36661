/* netcdf_format: numbers of the classic netCDF format. */
#ifndef PL_IO_NETCDF_NETCDF_FORMAT_H
#define PL_IO_NETCDF_NETCDF_FORMAT_H

/** Types of values. */
typedef enum netcdf_type {
    NETCDF_BYTE = 1,
    NETCDF_CHAR,
    NETCDF_SHORT,
    NETCDF_INT,
    NETCDF_FLOAT,
    NETCDF_DOUBLE,
    NETCDF_UBYTE, /* this and the next ones: in CDF-5 alone */
    NETCDF_USHORT,
    NETCDF_UINT,
    NETCDF_INT64,
    NETCDF_UINT64
} netcdf_type;

/** Tags before lists. */
enum { NETCDF_NO_LIST = 0, NETCDF_DIMENSIONS = 10, NETCDF_VARIABLES = 11, NETCDF_ATTRIBUTES = 12 };

/** Return the bytes of a value of a type; 0: there is no such type. */
static inline int netcdf_type_size(long long type) {
    static const unsigned char sizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    return type > 0 && type < (int)sizeof sizes ? sizes[type] : 0;
}

#endif
