/* histogram: the elements by their ratios, as bars of characters. */
#include "terminal/histogram.h"

#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>
#include <math.h>

enum {
    LABEL_WIDTH = 12, /* "100 .. 1000" */
    COUNT_WIDTH = 10,
    PARTS = 8 /* of a block */
};

/** How bars are drawn. */
typedef struct bars {
    FILE *stream;
    int has_blocks;
    int width;    /* columns of the longest */
    int64_t most; /* what that stands for */
} bars;

/** Put a count and its bar, at least a mark if the count is not 0; blanks behind it up to the next
 *  cell if there is one. */
static void put_cell(const bars *b, int64_t count, int is_last) {
    static const char *const blocks[PARTS] = {"",       "\u258f", "\u258e", "\u258d",
                                              "\u258c", "\u258b", "\u258a", "\u2589"};
    const double columns = (double)count / (double)b->most * b->width;
    const int parts = (int)ceil(columns * PARTS), whole = (int)ceil(columns);
    const int filled = b->has_blocks ? parts / PARTS : whole;
    fprintf(b->stream, "%*" PRId64 "%s", COUNT_WIDTH, count, count > 0 ? " " : "");
    for (int i = 0; i < filled; i++)
        fputs(b->has_blocks ? "\u2588" : "#", b->stream);
    if (b->has_blocks)
        fputs(blocks[parts % PARTS], b->stream);
    if (is_last)
        fputc('\n', b->stream);
    else
        fprintf(b->stream, "%*s", 1 + b->width - whole - (count > 0), "");
}

void pl_histogram_print(FILE *stream, const char *ratio, const planish_quality *before,
                        const planish_quality *after) {
    const planish_quality *const states[] = {before, after};
    const int first = before ? 0 : 1;
    char label[LABEL_WIDTH + 20];
    int last = 0;
    int64_t inverted = 0;
    bars b = {.stream = stream,
              .has_blocks = pl_terminal_has_blocks(stream),
              .width =
                  (pl_terminal_text_width(stream) - LABEL_WIDTH) / (2 - first) - COUNT_WIDTH - 1,
              .most = 1};
    for (int s = first; s < 2; s++) {
        const int64_t *counts = states[s]->histogram_counts;
        inverted += states[s]->n_inverted;
        b.most = states[s]->n_inverted > b.most ? states[s]->n_inverted : b.most;
        for (int i = 0; i < PLANISH_HISTOGRAM_BINS; i++) {
            last = counts[i] > 0 && i > last ? i : last;
            b.most = counts[i] > b.most ? counts[i] : b.most;
        }
    }
    fprintf(stream, "%s%-*s", pl_style_begin(stream, PL_STYLE_HEADING), LABEL_WIDTH, ratio);
    if (before)
        fprintf(stream, "%*s%*s%*s", COUNT_WIDTH, "before", 1 + b.width, "", COUNT_WIDTH, "after");
    else
        fprintf(stream, "%*s", COUNT_WIDTH, "elements");
    fprintf(stream, "%s\n", pl_style_end(stream, PL_STYLE_HEADING));
    for (int i = 0; i <= last; i++) {
        const double from = after->histogram_edges[i], to = after->histogram_edges[i + 1];
        if (isfinite(to))
            snprintf(label, sizeof label, "%.5g .. %.5g", from, to);
        else
            snprintf(label, sizeof label, "%.5g ..", from);
        fprintf(stream, "%-*s", LABEL_WIDTH, label);
        for (int s = first; s < 2; s++)
            put_cell(&b, states[s]->histogram_counts[i], s == 1);
    }
    if (inverted > 0)
        fprintf(stream, "%-*s", LABEL_WIDTH, "inverted");
    for (int s = first; s < 2 && inverted > 0; s++)
        put_cell(&b, states[s]->n_inverted, s == 1);
}
