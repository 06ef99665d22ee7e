/* svg.c - see svg.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "trim/svg.h"

/* A pixel is a thousandth of the longer side. */
void ep_svg_begin(FILE *f, const ep_point2 lo, const ep_point2 hi)
{
    const double w = hi[0] - lo[0], h = hi[1] - lo[1], size = fmax(w, h), border = 0.02 * size;
    const double pixel = size / 1000;
    fprintf(
        f,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"%.9g %.9g %.9g %.9g\">\n",
        (w + 2 * border) / pixel, (h + 2 * border) / pixel, lo[0] - border, -hi[1] - border, w + 2 * border,
        h + 2 * border);
    fprintf(f,
            "<style>*{stroke:#555;stroke-width:%.9g;stroke-linejoin:round}"
            ".i{fill:#cfe8cf}.o{fill:#eee}.x{fill:#f2a33a}.c{fill:none;stroke:#b00020;stroke-width:%.9g}</style>\n"
            "<rect style=\"fill:#fff;stroke:none\" x=\"%.9g\" y=\"%.9g\" width=\"100%%\" height=\"100%%\"/>\n"
            "<g transform=\"scale(1,-1)\">\n",
            0.5 * pixel, 1.2 * pixel, lo[0] - border, -hi[1] - border);
}

void ep_svg_leaf(FILE *f, ep_trim_state state, unsigned count, const ep_point2 *corners)
{
    static const char class[] = {[EP_TRIM_OUTSIDE] = 'o', [EP_TRIM_INSIDE] = 'i', [EP_TRIM_CROSSED] = 'x'};
    fprintf(f, "<polygon class=\"%c\" points=\"", class[state]);
    for (unsigned i = 0; i < count; ++i) fprintf(f, "%s%.9g,%.9g", i ? " " : "", corners[i][0], corners[i][1]);
    fprintf(f, "\"/>\n");
}

void ep_svg_curves(FILE *f, const ep_trim *trim)
{
    for (size_t i = 0; i < trim->piece_count; ++i) {
        const ep_piece *p = &trim->pieces[i];
        const int chords = p->degree == 1 ? 1 : 32; /* of a monotone piece: under a pixel from it */
        fprintf(f, "<path class=\"c\" d=\"M%.9g %.9g", p->low[0], p->low[1]);
        for (int k = 1; k < chords; ++k) {
            ep_point2 q;
            ep_curve_eval(trim->points + p->first, p->degree, (double)k / chords, q);
            fprintf(f, "L%.9g %.9g", q[0], q[1]);
        }
        fprintf(f, "L%.9g %.9g\"/>\n", p->high[0], p->high[1]);
    }
}

bool ep_svg_end(FILE *f)
{
    fprintf(f, "</g>\n</svg>\n");
    return !ferror(f);
}
