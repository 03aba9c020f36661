/* reports: the files that a run writes about itself: JSON and HTML page. */
#include "report/reports.h"

#include "job/output.h"
#include "report/page.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include <string.h>

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
        status = pl_complain(failed, "the page: %s: out of memory", shown(path));
    else if (pl_output_write_text(path, PL_TEMPORARY_PAGE, page.text, page.length, &error))
        status = pl_complain(failed, "the page: %s", error.text);
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
        status = pl_complain(failed, "the report: %s", error.text);
    if (arguments->report) {
        pl_figures figures;
        cJSON *result = cJSON_Parse(json);
        if (!result || pl_figures_find(result, &figures)) /* it is ours: only memory can be short */
            page = pl_complain(failed, "the page: %s: out of memory", shown(arguments->report));
        else
            page = pl_page_write(arguments->report, &figures, picture, NULL, failed);
        cJSON_Delete(result);
    }
    return status ? status : page;
}

int pl_report_draw(const pl_job *job, const char *name, pl_picture **picture) {
    if (!job->arguments->report || !pl_page_can_draw())
        return 0;
    const int status = *picture ? 0 : pl_picture_begin(job, picture);
    return status ? status : pl_picture_take(*picture, job, name);
}
