/* access: permissions of a file that replaces another one: no more people get access than before
 * (pl_file_take_access). Either access_posix.c or access_windows.c is built.
 */
#ifndef PL_BASE_ACCESS_H
#define PL_BASE_ACCESS_H

/** Let an open file, which nobody else may read yet, have owner, mode, access list and extended
 *  attributes (user.*) of the file at path, as far as that is allowed. Where it cannot have the
 *  owner's group, neither the new group nor all others get a right that both classes did not have;
 *  where it cannot have the access list, it stays its owner's alone. */
void pl_file_take_access(int fd, const char *path);

#endif
