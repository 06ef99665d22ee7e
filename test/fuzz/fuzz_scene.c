/* fuzz_scene.c - the reader of JSON scenes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/fuzz/fuzz.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_file f;
    fuzz_open(&f, data, size);
    scene *s = scene_read(f.path); /* without an extension: a scene */
    fuzz_close(&f, s);
    if (!s) return 0;
    if (s->has_camera && camera_problem(&s->camera)) abort();
    for (size_t i = 0; i < s->geometry_count; ++i) fuzz_check_geometry(&s->geometries[i]);
    for (size_t i = 0; i < s->object_count; ++i)
        if (s->objects[i].geometry >= s->geometry_count) abort();
    scene_free(s);
    return 0;
}
