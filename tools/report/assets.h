/* assets: files that are part of every page; the build makes them part of the program
 * (embed.cmake). */
#ifndef PL_REPORT_ASSETS_H
#define PL_REPORT_ASSETS_H

#include <stddef.h>

typedef struct pl_asset {
    const unsigned char *bytes; /* [size] */
    size_t size;                /* 0: the build did not find the file */
} pl_asset;

extern const pl_asset pl_asset_page_css;
extern const pl_asset pl_asset_viewer_js;   /* viewer/: all files */
extern const pl_asset pl_asset_three_js;    /* three.min.js */
extern const pl_asset pl_asset_controls_js; /* OrbitControls.js of three.js */
extern const pl_asset pl_asset_three_licence;

#endif
