/* view_blocks: the cells of a mesh that is written, those of one type and entity together.
 *
 *   io_view_block, io_view_blocks_make, _release   the blocks
 *   io_view_lose_types                             elements that a format does not have
 *   io_view_lose_tags, _loses_tag, _loses_region   numbers that it does not have
 */
#ifndef PL_IO_VIEW_VIEW_BLOCKS_H
#define PL_IO_VIEW_VIEW_BLOCKS_H

#include "io/view/view.h"

/** Cells of one type, entity, and region where arrays tell these. Those of one entity and region are a
 *  set, of one block or several. */
typedef struct io_view_block {
    int dim, type;
    int32_t entity;
    int64_t region;
    int64_t set; /* number of its set among those of its dimension, from 1, */
    int32_t
        reference; /* number of the set for formats that have one: that of its first group, or of
                          its entity or region, if sets of a dimension differ by these; else set */
    int32_t
        property; /* the same, or a free number: 1 .. IO_VIEW_MOST_NUMBER, and that of no other set */
    int begins_set; /* it is the first block of its set */
    int64_t n;
    const int64_t *cell; /* [n] indices, ascending */
} io_view_block;

/** Blocks of a mesh. */
typedef struct io_view_blocks {
    io_view_block *block; /* [n] by dimension, those of solids first, entity, region and type */
    int64_t n;
    int64_t *cell; /* [n_cells] of all blocks */
} io_view_blocks;

/** Sort the cells into blocks. To be released in any case. Error: _MEMORY. */
int io_view_blocks_make(const io_view *view, io_view_blocks *blocks, planish_error *error);
/** Release blocks. */
void io_view_blocks_release(io_view_blocks *blocks);

/** Return whether a block that has a number is in a group of another one, which has no name; where the
 *  format has no names: whether its first group has another number. */
int io_view_loses_tag(const io_view *view, const io_view_block *block, int64_t number,
                      int has_names);

/** Return whether a block without groups that has a number is of a region of another one. */
int io_view_loses_region(const io_view *view, const io_view_block *block, int64_t number);

/** Note both for all blocks, which have their references or (has_properties) their properties. */
void io_view_lose_tags(const io_view *view, const io_view_blocks *blocks, int has_properties,
                       int has_names, io_losses *losses);

/** Note how many elements lose nodes, or are left out, because of the types in a format's table. */
void io_view_lose_types(const io_view_type *table, const io_view_blocks *blocks, io_losses *losses);

#endif
