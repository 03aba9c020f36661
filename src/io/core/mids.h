/* mids: lines and facets that a file lists by their corners alone get the mids of the elements.
 *
 *   io_complete_mids
 */
#ifndef PL_IO_CORE_MIDS_H
#define PL_IO_CORE_MIDS_H

#include "io/core/model.h"

/** Give lines and facets the mids that they lack, and the middles of their faces, of the elements that have
 *  their edges and faces. Elements of first order give none. Error: _MEMORY. */
int io_complete_mids(io_model *model, planish_error *error);

#endif
