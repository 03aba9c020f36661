/* hdf5_image: bytes in memory as a file of the HDF5 library, and such a file as bytes.
 *
 * The core driver of the library works on bytes in memory: its functions for memory are replaced by
 * ones that hand it the bytes that are there, or make the one copy that a changed file needs. So
 * the library never writes to a disk: where that is full, it would crash.
 */
#ifdef PL_HDF5
#include "io/hdf5/hdf5_image.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/** Return the caller's bytes: property lists hold these, and a file that is not to be changed. */
static void *image_malloc(size_t size, H5FD_file_image_op_t op, void *image) {
    (void)size, (void)op;
    return image;
}

static void *copy_malloc(size_t size, H5FD_file_image_op_t op, void *data) {
    hdf5_copy *copy = data;
    if (op != H5FD_FILE_IMAGE_OP_FILE_OPEN)
        return copy->of;
    copy->size = (int64_t)size;
    return malloc(size);
}

static void *image_copy(void *to, const void *from, size_t size, H5FD_file_image_op_t op,
                        void *image) {
    (void)op, (void)image;
    return to == from ? to : memcpy(to, from, size);
}

/** Refuse to grow: only a file that is written does. */
static void *image_realloc(void *at, size_t size, H5FD_file_image_op_t op, void *image) {
    (void)at, (void)size, (void)op, (void)image;
    return NULL;
}

static void *copy_realloc(void *at, size_t size, H5FD_file_image_op_t op, void *data) {
    hdf5_copy *copy = data;
    void *made = realloc(at, size);
    (void)op;
    copy->size = made ? (int64_t)size : copy->size;
    return made;
}

/** Free nothing: the bytes are the caller's. */
static herr_t image_free(void *at, H5FD_file_image_op_t op, void *image) {
    (void)at, (void)op, (void)image;
    return 0;
}

/** Keep what the library has written when it closes the file. */
static herr_t copy_free(void *at, H5FD_file_image_op_t op, void *data) {
    hdf5_copy *copy = data;
    if (op == H5FD_FILE_IMAGE_OP_FILE_CLOSE)
        copy->written = at;
    else if (at != copy->of)
        free(at);
    return 0;
}

static void *udata_copy(void *image) {
    return image;
}

static herr_t udata_free(void *image) {
    (void)image;
    return 0;
}

/** Open the bytes at image by functions for memory. */
static hid_t open_by(H5FD_file_image_callbacks_t *callbacks, void *image, int64_t size,
                     unsigned flags) {
    enum { INCREMENT = 1 << 20 };
    hid_t access = H5Pcreate(H5P_FILE_ACCESS), file = -1;
    if (access >= 0 && H5Pset_fapl_core(access, INCREMENT, 0) >= 0 &&
        H5Pset_file_image_callbacks(access, callbacks) >= 0 &&
        H5Pset_file_image(access, image, (size_t)size) >= 0)
        /* The driver wants a name that no file has. */
        file = H5Fopen("/dev/null/mesh", flags, access);
    hdf5_release(access);
    return file;
}

hid_t hdf5_open_bytes(const char *data, int64_t size) {
    void *image = (void *)(uintptr_t)data;
    H5FD_file_image_callbacks_t callbacks = {image_malloc, image_copy, image_realloc, image_free,
                                             udata_copy,   udata_free, image};
    return open_by(&callbacks, image, size, H5F_ACC_RDONLY);
}

hid_t hdf5_open_copy(const char *data, int64_t size, hdf5_copy *copy) {
    *copy = (hdf5_copy){.of = (void *)(uintptr_t)data};
    H5FD_file_image_callbacks_t callbacks = {copy_malloc, image_copy, copy_realloc, copy_free,
                                             udata_copy,  udata_free, copy};
    return open_by(&callbacks, copy->of, size, H5F_ACC_RDWR);
}

int64_t hdf5_user_block(hid_t file) {
    hsize_t size = 0;
    const hid_t list = H5Fget_create_plist(file);
    const int failed = list < 0 || H5Pget_userblock(list, &size) < 0;
    hdf5_release(list);
    return failed ? -1 : (int64_t)size;
}

/** Find where a closed file ends in the memory that it was written to; -1 on failure. */
static int64_t find_end(const hdf5_copy *copy) {
    const hid_t file = hdf5_open_bytes(copy->written, copy->size);
    const int64_t user_block = file < 0 ? -1 : hdf5_user_block(file);
    const ssize_t length = user_block < 0 ? -1 : H5Fget_file_image(file, NULL, 0);
    hdf5_release(file);
    return length < 0 || user_block + length > copy->size ? -1 : user_block + length;
}

int hdf5_take_bytes(io_hdf5 *file, const hdf5_copy *copy, char **bytes, int64_t *size) {
    /* The library still writes as it closes the file: free space, checksums, and that it is closed. */
    const int is_closed = H5Fclose(file->id) >= 0;
    file->id = -1;
    *size = is_closed && copy->written ? find_end(copy) : -1;
    if (*size < 0)
        return hdf5_fail_library(file, "/", "its coordinates cannot be changed");
    *bytes = pl_alloc(*size, 1);
    if (!*bytes)
        return pl_fail_memory(file->error, file->model->input.path);
    memcpy(*bytes, copy->written, (size_t)*size);
    return PLANISH_OK;
}

#endif
