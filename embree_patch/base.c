/* base.c - see base.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "embree_patch/base.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static atomic_long fail_at = -1;

void ep_alloc_fail_at(long n)
{
    atomic_store(&fail_at, n);
}

void *ep_alloc(size_t count, size_t size)
{
    long n = atomic_load_explicit(&fail_at, memory_order_relaxed);
    if (n >= 0 && atomic_fetch_sub(&fail_at, 1) == 0) return NULL;
    if (size && count > (SIZE_MAX - 63) / size) return NULL;
    size_t bytes = (count * size + 63) / 64 * 64;
    return aligned_alloc(64, bytes ? bytes : 64);
}

void ep_free(void *p)
{
    free(p);
}

bool ep_reserve(void **items, size_t *capacity, size_t count, size_t more, size_t size)
{
    if (more <= *capacity - count) return true;
    if (more > SIZE_MAX / 2 - count) return false;
    const size_t room = 2 * *capacity > count + more ? 2 * *capacity : count + more;
    void *bigger = ep_alloc(room, size);
    if (!bigger) return false;
    if (count) memcpy(bigger, *items, count * size);
    ep_free(*items);
    *items = bigger;
    *capacity = room;
    return true;
}

bool ep_shrink(void **items, size_t *capacity, size_t count, size_t size)
{
    if (*capacity == count) return true;
    void *smaller = ep_alloc(count, size);
    if (!smaller) return false;
    if (count) memcpy(smaller, *items, count * size);
    ep_free(*items);
    *items = smaller;
    *capacity = count;
    return true;
}

EPStatus ep_fail(ep_message *m, EPStatus s, const char *format, ...)
{
    va_list ap;
    va_start(ap, format);
    vsnprintf(m->text, sizeof m->text, format, ap);
    va_end(ap);
    return s;
}
