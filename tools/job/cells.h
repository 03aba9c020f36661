/* cells: the elements of every type that a mesh file has.
 *
 *     pl_cells_measure, _free         their quality, where some are no straight simplices
 *     pl_cells_validity_find, _free   which elements are valid, where not all are straight simplices
 *     pl_cells_measure_elements       radius ratios
 *     pl_cells_measure_values         other values of elements
 *     pl_cells_convert                a copy for viewing, with their measures
 *     pl_cells_rounding               how far off rounding takes nodes
 *     pl_cells_find_states            planish_cell_state of each
 *     pl_cells_find_faults            those that are not valid
 *
 * Functions that return an int return 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_CELLS_H
#define PL_TOOLS_CELLS_H

#include "job/cell_types.h"
#include "job/job_state.h"

/** Quality of the elements of every type. */
typedef struct pl_cells {
    int has_others;      /* 0: the mesh has straight simplices alone, and nothing else is set */
    planish_cells cells; /* the file's */
    planish_cell_quality quality; /* ratios over no element are NAN */
    planish_size_quality sizes;   /* where sizes are asked for */
    double *aspect_ratio;         /* [cells.n] 0: the element is not valid; owned */
} pl_cells;

/** Measure all elements of the file, if it has others than straight simplices. cells is to be freed
 *  also after an error. */
int pl_cells_measure(const pl_job *job, pl_cells *cells);

/** State of an element beside those of planish_cell_state: not valid, though its corners are
 *  positive. */
enum { PL_INVERTED_INSIDE = 4 };

/** Validity of the elements of a mesh that are not all straight simplices: decided for every point of
 *  an element, with its mid-side nodes. */
typedef struct pl_cells_validity {
    int is_known;                 /* 0: all are straight simplices, and nothing else is set */
    planish_cell_quality quality; /* ratios over no element are NAN */
    planish_size_quality sizes;   /* where sizes are asked for */
    uint8_t *state;               /* [mesh.n_elements] of planish_cell_state, or
                                     PL_INVERTED_INSIDE; owned */
    double *aspect_ratio;         /* [mesh.n_elements] 0: not valid; owned */
    int64_t n_inside;             /* of PL_INVERTED_INSIDE */
} pl_cells_validity;

/** Find out which elements of the mesh are valid as it is now. validity is to be freed also after an
 *  error. */
int pl_cells_validity_find(const pl_job *job, pl_cells_validity *validity);

void pl_cells_validity_free(pl_cells_validity *validity);

/** Find the state of each element of job->mesh, which has cells: *state [mesh.n_elements] of
 *  planish_cell_state, to be freed by the caller. */
int pl_cells_find_states(const pl_job *job, uint8_t **state);

/** Mark the elements of job->mesh that are inverted, or not known to be valid: *is_faulty [mesh.n_elements], to
 *  be freed by the caller also after an error. */
int pl_cells_find_faults(const pl_job *job, uint8_t **is_faulty);

/** Elements that are inverted, or not known to be valid: quality is of the same mesh. */
int64_t pl_cells_validity_faults(const pl_cells_validity *validity, const planish_quality *quality);

/** Find the radius ratios of the elements [mesh.n_elements] by their corners, or their aspect ratios
 *  where job->has_types; 0: the element is inverted, perhaps by its mid-side nodes. Returns a
 *  planish_status. */
int pl_cells_measure_elements(const pl_job *job, double *ratio, planish_error *error);

/** Fill values for the elements of job->mesh, which has cells. Returns a planish_status. */
int pl_cells_measure_values(const pl_job *job, const planish_cell_values *values,
                            planish_error *error);

/** Write a copy of the mesh as it is now for viewing, with the measures of all elements, and say what
 *  it lacks. Returns 0, or an exit status after a message. */
int pl_cells_convert(const pl_job *job, const char *path);

/** Distance that rounding in the file explains, in its units. */
double pl_cells_rounding(const pl_job *job);

/** Free what cells owns; the quality stays. The file may be closed afterwards. */
void pl_cells_free(pl_cells *cells);

#endif
