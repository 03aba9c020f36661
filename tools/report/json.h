/* json: a JSON document that is being made.
 *
 * Real numbers are written with the fewest digits that restore them, those that are not finite as null.
 *
 *     pl_json_add, _object, _array              any item; an empty object or array
 *     pl_json_integer, _real, _text, _known     values
 *     pl_json_finish                            the text
 */
#ifndef PL_REPORT_JSON_H
#define PL_REPORT_JSON_H

#include <cjson/cJSON.h>

#include <stdint.h>

/** A document that is being made. cJSON calls may fail for want of memory; failed remembers. */
typedef struct pl_json {
    int failed;
} pl_json;

/** Add item to parent, which may be NULL for want of memory; item, or NULL if it was released. */
cJSON *pl_json_add(pl_json *json, cJSON *parent, const char *name, cJSON *item);

/** Add an empty object or array; NULL without memory. name: NULL in arrays, here and below. */
cJSON *pl_json_object(pl_json *json, cJSON *parent, const char *name);
cJSON *pl_json_array(pl_json *json, cJSON *parent, const char *name);

/** Add an integer, with all its digits. */
void pl_json_integer(pl_json *json, cJSON *parent, const char *name, int64_t value);

/** Add an integer, or null if it is negative: not looked for. */
void pl_json_known(pl_json *json, cJSON *parent, const char *name, int64_t value);

/** Add a real number, or null if it is not finite. */
void pl_json_real(pl_json *json, cJSON *parent, const char *name, double value);

/** Add text to JSON, which is UTF-8: other bytes, in names of files, become U+FFFD. */
void pl_json_text(pl_json *json, cJSON *parent, const char *name, const char *text);

/** Add the checksum of coordinates as written or read: in full, whatever the format's digits. */
void pl_json_checksum(pl_json *json, cJSON *root, const char *name, uint64_t checksum);

/** The text of root with a line end, to be released by free, or NULL without memory; root is released. */
char *pl_json_finish(pl_json *json, cJSON *root);

#endif
