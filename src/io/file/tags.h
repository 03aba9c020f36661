/* tags: what a text means as a tag of planish_hold, and the tag of an element's region.
 *
 *   io_tag, io_tag_parse      a tag that is given
 *   io_element_entity         the entity of an element
 *   io_tags_make, _free       what planish_file_element_region looks tags up in
 */
#ifndef PL_IO_FILE_TAGS_H
#define PL_IO_FILE_TAGS_H

#include "io/core/format.h"

/** A tag: a name, or a number with or without a dimension. */
typedef struct io_tag {
    const char *name;
    int has_number, dim; /* dim -1: any */
    int64_t number;
} io_tag;

/** Understand text; dim: of the group if the text does not say. */
io_tag io_tag_parse(const char *text, int dim);

/** Return the entity of element i, or -1. */
int32_t io_element_entity(const io_model *model, int64_t i);

/** Make file->tags of a file that has been read. To be freed in any case. Error: _MEMORY. */
int io_tags_make(planish_file *file, planish_error *error);
void io_tags_free(planish_file *file);

#endif
