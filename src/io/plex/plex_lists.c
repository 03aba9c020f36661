/* plex_lists: lists of numbers and of names in a group. */
#ifdef PL_HDF5
#include "io/plex/plex_reader.h"

#include "base/status.h"

int plex_read_integers(plex_reader *r, const char *group, const char *name,
                       io_hdf5_integers *list) {
    const io_hdf5_path path = io_hdf5_path_of(r->file, "%s/%s", group, name);
    return io_hdf5_integers_read(r->file, path.text, list);
}

int plex_list_group(plex_reader *r, const char *parent, const char *name, io_hdf5_path *path,
                    io_hdf5_names *names) {
    *names = (io_hdf5_names){0};
    *path = io_hdf5_path_of(r->file, "%s/%s", parent, name);
    return io_hdf5_kind_of(r->file, path->text) == IO_HDF5_GROUP
               ? io_hdf5_list(r->file, path->text, names)
               : PLANISH_OK;
}

#endif
