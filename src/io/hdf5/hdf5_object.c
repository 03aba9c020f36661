/* hdf5_object: errors of the HDF5 library, and its objects. */
#ifdef PL_HDF5
#include "io/hdf5/hdf5_object.h"

#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

/* ---- errors ------------------------------------------------------------------------------- */

hdf5_voice hdf5_silence(void) {
    hdf5_voice voice = {.is_new = 1};
    H5Eauto_is_v2(H5E_DEFAULT, &voice.is_new);
    if (voice.is_new) {
        H5Eget_auto2(H5E_DEFAULT, &voice.function, &voice.data);
        H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    } else {
        H5Eget_auto1(&voice.old_function, &voice.data);
        H5Eset_auto1(NULL, NULL);
    }
    return voice;
}

void hdf5_restore(hdf5_voice voice) {
    H5Eclear2(H5E_DEFAULT);
    if (voice.is_new)
        H5Eset_auto2(H5E_DEFAULT, voice.function, voice.data);
    else
        H5Eset_auto1(voice.old_function, voice.data);
}

/** Replace control characters: names come from the file and may hold anything. */
static void make_printable(char *text) {
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 127)
            *text = '?';
}

int io_hdf5_fail(io_hdf5 *file, const char *path, const char *format, ...) {
    char text[384], shown[256];
    va_list arguments;
    if (file->is_too_long) {
        path = file->unknown;
        format = "this name is too long";
    }
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(shown, sizeof shown, "%.255s", path);
    make_printable(shown);
    make_printable(text);
    return pl_fail(file->error, PLANISH_ERROR_FORMAT, "%s: %s: %s", file->model->input.path, shown,
                   text);
}

/** Take the first error that the library met. */
static herr_t take_reason(unsigned n, const H5E_error2_t *entry, void *data) {
    char *text = data;
    if (n == 0 && entry->desc)
        snprintf(text, 128, "%s", entry->desc);
    return 0;
}

int hdf5_fail_library(io_hdf5 *file, const char *path, const char *text) {
    char reason[128] = "no reason given";
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_reason, reason);
    return io_hdf5_fail(file, path, "%s (HDF5: %s); the file may be damaged", text, reason);
}

/* ---- objects ------------------------------------------------------------------------------ */

void hdf5_release(hid_t id) {
    if (id < 0)
        return;
    /* What is said of an error is still asked for: a call would clear it. */
    const hid_t errors = H5Eget_num(H5E_DEFAULT) > 0 ? H5Eget_current_stack() : -1;
    H5Idec_ref(id);
    if (errors >= 0)
        H5Eset_current_stack(errors);
}

/** Refuse a link to another file. */
static herr_t refuse_link(const char *parent_file, const char *parent_group, const char *child_file,
                          const char *child_object, unsigned *flags, hid_t access, void *data) {
    (void)parent_file, (void)parent_group, (void)child_file, (void)child_object, (void)flags,
        (void)access, (void)data;
    return -1;
}

hid_t hdf5_link_access(void) {
    const hid_t access = H5Pcreate(H5P_LINK_ACCESS);
    if (access < 0 || H5Pset_elink_cb(access, refuse_link, NULL) >= 0)
        return access;
    hdf5_release(access);
    return -1;
}

#endif
