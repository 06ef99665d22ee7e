/* fuzz_obj.c - the reader of .obj files.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/fuzz/fuzz.h"
#include "tools/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What it says of tags that it ignores is no complaint. */
static void forget_notes(fuzz_file *f)
{
    fflush(stderr);
    for (const char *line = f->said; *line; line = strchr(line, '\n') + 1)
        if (strncmp(line, "epatch: ", 8) || !strstr(line, "ignored\n")) return;
    rewind(stderr); /* a stream in memory ends where it is written */
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    /* each scheme, one of them beside surfaces, too; not deep, which takes time and finds nothing new */
    for (int scheme = CAGE_CATMULL_CLARK; scheme <= CAGE_LOOP; ++scheme) {
        const model_polygons polygons = scheme == CAGE_LOOP ? POLYGONS_WANTED : POLYGONS_ALONE;
        const model_options o = {polygons, (cage_scheme)scheme, 3, NULL};
        fuzz_file f;
        scene_geometry g = {0};
        fuzz_open(&f, data, size);
        bool read = model_read_obj(f.path, &o, &g);
        if (read) forget_notes(&f);
        fuzz_close(&f, read);
        if (read) fuzz_check_geometry(&g);
        geometry_free(&g);
    }
    return 0;
}
