/* fuzz_bpt.c - the reader of .bpt files.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/fuzz/fuzz.h"
#include "tools/model.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_file f;
    scene_geometry g = {0};
    fuzz_open(&f, data, size);
    bool read = model_read_bpt(f.path, NULL, &g);
    fuzz_close(&f, read);
    if (read) fuzz_check_geometry(&g);
    free(g.points);
    free(g.patches);
    return 0;
}
