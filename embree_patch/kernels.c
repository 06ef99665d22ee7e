/* kernels.c - which instruction sets are in this build and run on this machine.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/kernels.h"

#include <string.h>

#if EP_HAVE_X86
extern const ep_kernels ep_kernels_avx2, ep_kernels_avx512;

static bool has_avx2(void)
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
static bool has_avx512(void)
{
    return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512dq");
}
#endif

/* Slowest first. */
static unsigned list(const ep_kernels *found[4])
{
    unsigned n = 0;
    found[n++] = &ep_kernels_plain;
#if EP_HAVE_X86
    if (has_avx2()) found[n++] = &ep_kernels_avx2;
    if (has_avx512()) found[n++] = &ep_kernels_avx512;
#endif
    return n;
}

const ep_kernels *ep_find_kernels(const char *isa)
{
    const ep_kernels *found[4];
    const unsigned n = list(found);
    if (!isa) return found[n - 1];
    for (unsigned i = 0; i < n; ++i)
        if (!strcmp(found[i]->isa, isa)) return found[i];
    return NULL;
}

const char *const *epGetInstructionSets(void)
{
    static const char *const names[3][4] = {{"plain"}, {"plain", "avx2"}, {"plain", "avx2", "avx512"}};
    const ep_kernels *found[4];
    return names[list(found) - 1];
}
