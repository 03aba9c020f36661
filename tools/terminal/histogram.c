/* histogram: the elements by their radius ratios, as bars of characters. */
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

/** A bar for count, at least a mark if that is not 0; returns the columns it takes. */
static int put_bar(const bars *b, int64_t count) {
    static const char *const blocks[PARTS] = {"",       "\u258f", "\u258e", "\u258d",
                                              "\u258c", "\u258b", "\u258a", "\u2589"};
    const double columns = (double)count / (double)b->most * b->width;
    const int parts = (int)ceil(columns * PARTS), whole = (int)ceil(columns);
    const int filled = b->has_blocks ? parts / PARTS : whole;
    for (int i = 0; i < filled; i++)
        fputs(b->has_blocks ? "\u2588" : "#", b->stream);
    if (b->has_blocks)
        fputs(blocks[parts % PARTS], b->stream);
    return whole;
}

static int last_bin(const planish_quality *quality) {
    int last = 0;
    for (int i = 0; quality && i < PLANISH_HISTOGRAM_BINS; i++)
        if (quality->histogram_counts[i] > 0)
            last = i;
    return last;
}

static int64_t inverted_of(const planish_quality *quality) {
    return quality ? quality->inverted : 0;
}

/** Elements in the longest bar. */
static int64_t most_of(const planish_quality *quality) {
    int64_t most = inverted_of(quality) > 1 ? inverted_of(quality) : 1;
    for (int i = 0; quality && i < PLANISH_HISTOGRAM_BINS; i++)
        if (quality->histogram_counts[i] > most)
            most = quality->histogram_counts[i];
    return most;
}

static void put_label(FILE *stream, const planish_quality *quality, int bin) {
    char label[LABEL_WIDTH + 20];
    const double from = quality->histogram_edges[bin], to = quality->histogram_edges[bin + 1];
    if (isfinite(to))
        snprintf(label, sizeof label, "%.5g .. %.5g", from, to);
    else
        snprintf(label, sizeof label, "%.5g ..", from);
    fprintf(stream, "%-*s", LABEL_WIDTH, label);
}

/** Count and bar; with blanks behind it up to the next cell if there is one. */
static void put_cell(const bars *b, int64_t count, int is_last) {
    int used = 0;
    fprintf(b->stream, "%*" PRId64, COUNT_WIDTH, count);
    if (count > 0) {
        fputc(' ', b->stream);
        used = 1 + put_bar(b, count);
    }
    if (!is_last)
        fprintf(b->stream, "%*s", 1 + b->width - used, "");
}

/** The cells of a row; before may be NULL. */
static void put_row(const bars *b, const int64_t *before, int64_t after) {
    if (before)
        put_cell(b, *before, 0);
    put_cell(b, after, 1);
    fputc('\n', b->stream);
}

static void put_head(const bars *b, int has_before) {
    fprintf(b->stream, "%s%-*s", pl_style_begin(b->stream, PL_STYLE_HEADING), LABEL_WIDTH,
            "radius ratio");
    if (has_before)
        fprintf(b->stream, "%*s%*s%*s", COUNT_WIDTH, "before", 1 + b->width, "", COUNT_WIDTH,
                "after");
    else
        fprintf(b->stream, "%*s", COUNT_WIDTH, "elements");
    fprintf(b->stream, "%s\n", pl_style_end(b->stream, PL_STYLE_HEADING));
}

void pl_histogram_print(FILE *stream, const planish_quality *before, const planish_quality *after) {
    const int64_t most_before = most_of(before), most_after = most_of(after);
    const int n_states = before ? 2 : 1;
    const int last = last_bin(before) > last_bin(after) ? last_bin(before) : last_bin(after);
    const bars b = {.stream = stream,
                    .has_blocks = pl_terminal_has_blocks(stream),
                    .width = (PL_TEXT_WIDTH - LABEL_WIDTH) / n_states - COUNT_WIDTH - 1,
                    .most = most_before > most_after ? most_before : most_after};
    put_head(&b, before != NULL);
    for (int i = 0; i <= last; i++) {
        put_label(stream, after, i);
        put_row(&b, before ? &before->histogram_counts[i] : NULL, after->histogram_counts[i]);
    }
    if (inverted_of(before) + inverted_of(after) > 0) {
        fprintf(stream, "%-*s", LABEL_WIDTH, "inverted");
        put_row(&b, before ? &before->inverted : NULL, after->inverted);
    }
}
