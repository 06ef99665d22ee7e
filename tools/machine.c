/* machine.c - asks /proc and Embree.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#define _DEFAULT_SOURCE /* _SC_NPROCESSORS_ONLN */
#include "tools/machine.h"

#include "embree_patch/embree_patch.h"
#include "embree_patch/rtc/rtc_compat.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* The rest of the first line of a file that begins with `key`, after a colon; "" when there is none. */
static void look_up(const char *path, const char *key, char *to, size_t size)
{
    char line[512];
    FILE *f = fopen(path, "r");
    *to = 0;
    while (f && !*to && fgets(line, sizeof line, f)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) || !colon) continue;
        colon += 1 + strspn(colon + 1, " \t");
        snprintf(to, size, "%.*s", (int)strcspn(colon, "\n"), colon);
    }
    if (f) fclose(f);
}

machine machine_describe(void)
{
    machine m = {.cores = (unsigned)sysconf(_SC_NPROCESSORS_ONLN)};
    look_up("/proc/cpuinfo", "model name", m.cpu, sizeof m.cpu);
    if (!*m.cpu) strcpy(m.cpu, "unknown");
#ifdef __clang__
    snprintf(m.compiler, sizeof m.compiler, "clang %d.%d.%d", __clang_major__, __clang_minor__, __clang_patchlevel__);
#else
    snprintf(m.compiler, sizeof m.compiler, "gcc %s", __VERSION__);
#endif
    RTCDevice device = rtcNewDevice(NULL);
    if (device) {
        const long v = (long)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
        snprintf(m.embree, sizeof m.embree, "%ld.%ld.%ld", v / 10000, v / 100 % 100, v % 100);
        rtcReleaseDevice(device);
    }
    for (const char *const *set = epGetInstructionSets(); *set; ++set) m.isa = *set;
    return m;
}

size_t machine_free_memory(void)
{
    char text[64];
    struct rlimit limit;
    look_up("/proc/meminfo", "MemAvailable", text, sizeof text);
    size_t bytes = (size_t)strtoull(text, NULL, 10) * 1024; /* "123456 kB" */
    if (!bytes) bytes = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE) / 2;
    if (!getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur < bytes) bytes = (size_t)limit.rlim_cur;
    return bytes;
}
