/* fuzz_rays.c - the reader of files of rays.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/fuzz/fuzz.h"
#include "tools/trace.h"

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_file f;
    size_t count = 0;
    fuzz_open(&f, data, size);
    trace_ray *rays = trace_read_rays(f.path, &count);
    fuzz_close(&f, rays);
    if (rays && (32 * count != size || !isfinite(trace_farthest_origin(rays, count)))) abort();
    free(rays);
    return 0;
}
