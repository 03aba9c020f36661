/* page: the report as one HTML page that needs nothing else, and the files of a run's reports. Its parts
 * are in page_summary.c, page_tables.c, page_picture.c, page_charts.c, page_worst.c and page_run.c. */
#include "report/page.h"

#include "job/output.h"
#include "report/assets.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include <string.h>

/* ---- head ----------------------------------------------------------------------------------- */

/** Nothing from elsewhere is ever loaded: the policy forbids it. */
static void put_head(pl_markup *page, const pl_figures *figures) {
    pl_markup_put(page,
                  "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                  "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                  "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
                  "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
                  "<meta name=\"generator\" content=\"planish\">\n<title>planish: ");
    pl_markup_put_text(page, pl_figures_input(figures));
    pl_markup_put(page, "</title>\n<style>\n");
    pl_markup_put_bytes(page, (const char *)pl_asset_page_css.bytes, pl_asset_page_css.size);
    pl_markup_put(page, "</style>\n</head>\n<body>\n<main>\n");
}

/* ---- all of it ------------------------------------------------------------------------------ */

static void put_footer(pl_markup *page, const pl_figures *figures) {
    const char *version = pl_figure_text(figures->result, "planish");
    const char *output = pl_figure_text(figures->result, "output");
    pl_markup_put(page, "</main>\n<footer><p>Made by planish ");
    pl_markup_put_text(page, version[0] ? version : planish_version());
    pl_markup_put(page, " from <code>");
    pl_markup_put_text(page, pl_figure_text(figures->result, "input"));
    pl_markup_put(page, "</code>");
    if (output[0]) {
        pl_markup_put(page, "; the result is <code>");
        pl_markup_put_text(page, output);
        pl_markup_put(page, "</code>");
    }
    pl_markup_put(page,
                  ". The measures are defined in docs/measures.md of planish.</p></footer>\n");
}

void pl_page_make(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture) {
    put_head(page, figures);
    pl_page_put_summary(page, figures);
    pl_page_put_measures(page, figures);
    pl_page_put_picture(page, figures, picture, no_picture);
    pl_page_put_histograms(page, figures);
    pl_page_put_worst(page, figures);
    pl_page_put_convergence(page, figures);
    pl_page_put_layers(page, figures);
    pl_page_put_surface(page, figures);
    pl_page_put_run(page, figures);
    pl_page_put_certificate(page, figures);
    put_footer(page, figures);
    pl_page_put_viewer(page, picture);
    pl_markup_put(page, "</body>\n</html>\n");
}

/* ---- files ---------------------------------------------------------------------------------- */

static const char *shown(const char *path) {
    return strcmp(path, "-") == 0 ? "standard output" : path;
}

int pl_page_write(const char *path, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture, int failed) {
    planish_error error;
    pl_markup page = {0};
    int status = 0;
    pl_page_make(&page, figures, picture, no_picture);
    if (page.failed)
        status = pl_complain(failed, "the HTML report: %s: out of memory", shown(path));
    else if (pl_output_write_text(path, PL_TEMPORARY_PAGE, page.text, page.length, &error))
        status = pl_complain(failed, "the HTML report: %s", error.text);
    pl_markup_free(&page);
    return status;
}

int pl_reports_write(const pl_arguments *arguments, const char *json, const pl_picture *picture,
                     int failed) {
    planish_error error;
    int status = 0, page = 0;
    if (!json)
        return pl_complain(failed, "%s: out of memory for the report",
                           shown(arguments->json ? arguments->json : arguments->report));
    if (arguments->json &&
        pl_output_write_text(arguments->json, PL_TEMPORARY_REPORT, json, strlen(json), &error))
        status = pl_complain(failed, "the JSON report: %s", error.text);
    if (arguments->report) {
        pl_figures figures;
        cJSON *result = cJSON_Parse(json);
        if (!result || pl_figures_find(result, &figures)) /* it is ours: only memory can be short */
            page =
                pl_complain(failed, "the HTML report: %s: out of memory", shown(arguments->report));
        else
            page = pl_page_write(arguments->report, &figures, picture, NULL, failed);
        cJSON_Delete(result);
    }
    return status ? status : page;
}

int pl_report_draw(const pl_job *job, const char *name, pl_picture **picture) {
    pl_job whole = *job;
    if (!job->arguments->report || !pl_page_can_draw())
        return 0;
    if (job->simplices.type) /* the command quality has a plan of these alone */
        pl_job_take_all(&whole);
    if (whole.file && whole.mesh.n_elements == 0)
        return 0;
    const int status = *picture ? 0 : pl_picture_begin(&whole, picture);
    return status ? status : pl_picture_take(*picture, &whole, name);
}
