/* data_files: the mesh files of tests/data, in one list. A new format adds its file here. */
#ifndef TEST_SUPPORT_DATA_FILES_H
#define TEST_SUPPORT_DATA_FILES_H

/** A mesh file of tests/data. */
typedef struct test_data_file {
    const char *name;
    const char *format; /* as in planish_file_formats */
    int has_regions;    /* planish_file_element_region names one for each of its elements */
} test_data_file;

/** The files; the last row has the name NULL. Of a mesh of several files (TetGen) the first; a mesh may be
 *  a folder. */
extern const test_data_file test_data_files[];

/** Return whether it is a folder. */
int test_data_is_folder(const test_data_file *file);

/** Write the path of the file to text [TEST_PATH_SIZE] and return 1. Return 0 if this build lacks a
 *  library that the file needs. Fail the test if the file is not there or cannot be read. */
int test_data_path(char *text, const test_data_file *file);

#endif
