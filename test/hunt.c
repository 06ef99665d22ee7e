/* hunt.c - looks for wrong rays, longer than a test may take.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 *     hunt CLASS SEED RAYS [FILE]
 *
 * sends about RAYS rays at random patches of a class and appends what went wrong to FILE, in the form of capture.h.
 * Without arguments it lists the classes. */
#include "test/capture.h"

#include <stdlib.h>
#include <string.h>

#define ALL {STYLE_GENTLE, STYLE_WILD, STYLE_FLAT, STYLE_COLLAPSED}, 4
#define SMOOTH {STYLE_GENTLE, STYLE_WILD}, 2

static const struct {
    const char *name;
    hits_case c; /* without seed and patches; rays of each */
} classes[] = {
    {"triangles", {.rays = 480, .triangles = true, .limits = {9, 1}, .styles = ALL, .scale = 1}},
    {"tensors", {.rays = 480, .tensors = true, .limits = {7, 1}, .styles = ALL, .scale = 1}},
    {"weights", {.rays = 480, .triangles = true, .tensors = true, .limits = {5, 5}, .styles = ALL, .scale = 1}},
    {"weights50", {.rays = 480, .triangles = true, .tensors = true, .limits = {4, 50}, .styles = ALL, .scale = 1}},
    {"triangles50", {.rays = 480, .triangles = true, .limits = {9, 50}, .styles = SMOOTH, .scale = 1}},
    {"tensors50", {.rays = 480, .tensors = true, .limits = {7, 50}, .styles = SMOOTH, .scale = 1}},
    {"low", {.rays = 480, .triangles = true, .tensors = true, .limits = {1, 1}, .styles = ALL, .scale = 1}},
    {"flat",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {4, 1}, .styles = {STYLE_FLAT}, 1, .scale = 1}},
    {"folds",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {7, 1}, .styles = {STYLE_WILD}, 1, .scale = 1}},
    {"poles",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {5, 2}, .styles = {STYLE_COLLAPSED}, 1, .scale = 1}},
    {"degenerate",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {4, 2}, .styles = {STYLE_DEGENERATE}, 1, .scale = 1}},
    {"at3000",
     {.rays = 480,
      .triangles = true,
      .tensors = true,
      .limits = {7, 2},
      .styles = ALL,
      .scale = 1,
      .offset = {3000, -2500, 1700}}},
    {"tiny",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {7, 2}, .styles = ALL, .scale = 1e-4, .distance = 4}},
    {"huge", {.rays = 480, .triangles = true, .tensors = true, .limits = {7, 2}, .styles = ALL, .scale = 1e6}},
    {"afar",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {5, 1}, .styles = ALL, .scale = 1, .distance = 1000}},
    {"coarse",
     {.rays = 480, .triangles = true, .tensors = true, .limits = {7, 2}, .styles = ALL, .scale = 1, .depths = 5}},
};

int main(int argc, char **argv)
{
    if (argc < 4) {
        for (size_t i = 0; i < EP_ARRAY_LEN(classes); ++i) puts(classes[i].name);
        return 2;
    }
    FILE *captures = argc > 4 ? fopen(argv[4], "a") : NULL;
    for (size_t i = 0; i < EP_ARRAY_LEN(classes); ++i) {
        if (strcmp(classes[i].name, argv[1])) continue;
        hits_case c = classes[i].c;
        c.seed = strtoul(argv[2], NULL, 10);
        c.patches = atoi(argv[3]) / c.rays + 1;
        const hits_tally t = judge_hits(&c, 20, captures);
        if (captures) fclose(captures);
        return t.faults > 0;
    }
    fprintf(stderr, "hunt: there is no class '%s'\n", argv[1]);
    return 2;
}
