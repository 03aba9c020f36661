/* heights: the heights of layers beside those that they are to have: those of the input, or of the mesh of
 * --like.
 *
 *     pl_heights_begin       find out what they are compared with
 *     pl_heights_measure     of the mesh as it is now
 *     pl_heights_choose      nodes of kept layers whose heights have changed by much
 *     pl_heights_find_worst  by how much a height has changed most
 *     pl_heights_release     nodes that are not held, as elements need them
 *     pl_heights_hold        hold nodes
 *     pl_heights_put, _note  a line for a table; a note where they are off by much
 *
 * Functions that return an int return 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_HEIGHTS_H
#define PL_TOOLS_HEIGHTS_H

#include "job/job.h"

#include <stdio.h>

/** Heights of layers. */
typedef struct pl_heights {
    int is_known; /* 0: there are no layers, or nothing is said of them */
    planish_layer_heights of;
} pl_heights;

/** Take what heights are compared with, before nodes move. Layers have been counted (pl_layers_count). */
int pl_heights_begin(pl_job *job);

/** Measure the mesh as it is now. */
int pl_heights_measure(const pl_job *job, pl_heights *heights);

/** Choose the nodes that are held at their heights: in_layer [n_nodes], those that are held now, and those of
 *  kept layers at heights that have changed by much, if there are any; not where a wall was moved, nor those
 *  that were released. of_all: all nodes of layers, if there are any. *n: how many nodes are new. *worst: as
 *  below. */
int pl_heights_choose(pl_job *job, int of_all, uint8_t *in_layer, int64_t *n, double *worst);

/** Find by how much of itself a height of kept layers has changed most, but where a wall was moved, or nodes
 *  were released. Nodes have been chosen before. */
int pl_heights_find_worst(const pl_job *job, double *worst);

/** Release the nodes of faulty elements and of some rings of elements around these, or around all that were
 *  released before: in_layer [n_nodes] has those that are held now without them, and they are not chosen again.
 *  Nodes have been chosen before. is_faulty [n_elements] is changed. Returns how many are no longer held. */
int64_t pl_heights_release(pl_job *job, uint8_t *is_faulty, uint8_t *in_layer);

/** Hold these nodes, and no others, at their heights, in job->constraint. Nodes have been chosen before. */
void pl_heights_hold(pl_job *job, const uint8_t *in_layer);

/** Put lines on heights, if they are known. */
void pl_heights_put(FILE *stream, const pl_job *job, const pl_heights *heights);

/** Say that heights have changed by much, and what keeps them. is_valid: all elements were, before. */
void pl_heights_note(FILE *stream, const pl_job *job, const pl_heights *heights, int is_valid);

#endif
