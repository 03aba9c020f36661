/* reading: mesh files from memory, for tests of readers. */
#ifndef TEST_SUPPORT_READING_H
#define TEST_SUPPORT_READING_H

#include "io/file/file.h"

/** Read text as a file of format; it must succeed. Close with planish_file_close. */
planish_file *reading_text(const io_format *format, const char *text);

/** Read text; it must fail with a message that holds word. */
void reading_fails(const io_format *format, const char *text, const char *word);

/** A text, and a word of the error that refuses it. */
typedef struct reading_refusal {
    const char *text, *word;
} reading_refusal;

/** Check n texts by reading_fails. */
void reading_refuses(const io_format *format, const reading_refusal *cases, size_t n);

/** Check whether the format recognises n texts, each in memory of its own. */
void reading_tells(const io_format *format, const char *const *texts, size_t n, int is_told);

/** Facts on a mesh. */
typedef struct reading_facts {
    int dim;
    int64_t n_nodes, n_elements;
    int64_t n_regions, n_other,
        n_lower; /* elements that are not smoothed, and of lower dimension */
    planish_precision precision;
} reading_facts;

/** Check that a file is of the format, and has a mesh of these facts. */
void reading_gave(const planish_file *file, const io_format *format, const reading_facts *facts);

/** Return the tag of an element's entity; entity: those of a list of the model. */
int reading_tag(const planish_file *file, const int32_t *entity, int64_t i);

/** Check group i of the model. */
void reading_group_is(const planish_file *file, int i, const char *name, int dim, int tag);

/** Where nodes are held besides: between regions; and whether surface nodes slide. */
enum { READING_REGIONS = 1, READING_SLIDE = 2 };

/** Check the nodes that a file holds, with a tag (or NULL): digits, constraints of the nodes. */
void reading_holds(const planish_file *file, const char *tag, unsigned how, const char *expected);

/** Check that of a text. */
void reading_text_holds(const io_format *format, const char *text, const char *tag, unsigned how,
                        const char *expected);

/** Read text, which is a surface in space: a mesh of dimension 3 whose cells are all flat. */
void reading_gives_surface(const io_format *format, const char *text);

/** Expect the corner of a cube in four tetrahedra around a node inside, the last one. */
void reading_gave_four(const planish_mesh *mesh);

/** Read every beginning of size bytes at data (each in memory of its own, so that a sanitizer sees
 *  any look behind the end): a mesh or an error with a text. */
void reading_every_beginning(const io_format *format, const char *data, int64_t size);

/** Return whether this build reads VTU files, for which it needs Expat. */
int reading_knows_vtu(void);

#endif
