/* json: a JSON document that is being made. */
#include "report/json.h"

#include "terminal/text.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

cJSON *pl_json_add(pl_json *json, cJSON *parent, const char *name, cJSON *item) {
    const int done =
        name ? cJSON_AddItemToObject(parent, name, item) : cJSON_AddItemToArray(parent, item);
    if (done)
        return item;
    cJSON_Delete(item);
    json->failed = 1;
    return NULL;
}

cJSON *pl_json_object(pl_json *json, cJSON *parent, const char *name) {
    return pl_json_add(json, parent, name, cJSON_CreateObject());
}

cJSON *pl_json_array(pl_json *json, cJSON *parent, const char *name) {
    return pl_json_add(json, parent, name, cJSON_CreateArray());
}

void pl_json_integer(pl_json *json, cJSON *parent, const char *name, int64_t value) {
    char text[32]; /* as text: a double would lose digits above 2^53 */
    snprintf(text, sizeof text, "%" PRId64, value);
    pl_json_add(json, parent, name, cJSON_CreateRaw(text));
}

void pl_json_real(pl_json *json, cJSON *parent, const char *name, double value) {
    char text[32];
    if (!isfinite(value)) {
        pl_json_add(json, parent, name, cJSON_CreateNull());
        return;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    pl_json_add(json, parent, name, cJSON_CreateRaw(text));
}

void pl_json_text(pl_json *json, cJSON *parent, const char *name, const char *text) {
    char *clean = malloc(3 * strlen(text) + 1), *to = clean;
    if (!clean) {
        json->failed = 1;
        return;
    }
    for (const char *from = text; *from;) {
        const int length = pl_utf8_length(from);
        const int n = length ? length : 3;
        memcpy(to, length ? from : PL_UTF8_REPLACEMENT, (size_t)n);
        to += n;
        from += length ? length : 1;
    }
    *to = '\0';
    pl_json_add(json, parent, name, cJSON_CreateString(clean));
    free(clean);
}

void pl_json_known(pl_json *json, cJSON *parent, const char *name, int64_t value) {
    if (value >= 0)
        pl_json_integer(json, parent, name, value);
    else
        pl_json_add(json, parent, name, cJSON_CreateNull());
}

void pl_json_checksum(pl_json *json, cJSON *root, const char *name, uint64_t checksum) {
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, checksum);
    pl_json_text(json, root, name, text);
}

/** A copy of JSON text with a line end, in which characters that a terminal may not get are written
 *  by their numbers: cJSON does so with those below ' ' alone. NULL without memory. */
static char *escape_controls(const char *text) {
    enum { LENGTH = 6 }; /* of an escape */
    uint32_t code;
    size_t size = strlen(text) + 2;
    for (const char *from = text; *from; from++)
        size += pl_text_control(from, &code) ? LENGTH : 0;
    char *line = malloc(size), *to = line;
    for (const char *from = text; line && *from;) {
        const int length = (unsigned char)*from > '~' ? pl_text_control(from, &code) : 0;
        if (length > 0)
            to += snprintf(to, LENGTH + 1, "\\u%04x", (unsigned)code);
        else
            *to++ = *from;
        from += length > 0 ? length : 1;
    }
    if (line)
        memcpy(to, "\n", 2);
    return line;
}

char *pl_json_finish(pl_json *json, cJSON *root) {
    char *text = json->failed ? NULL : cJSON_Print(root);
    cJSON_Delete(root);
    if (!text)
        return NULL;
    char *line = escape_controls(text);
    cJSON_free(text);
    return line;
}
