/* array.h - arrays that grow.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_ARRAY_H
#define EPATCH_ARRAY_H

#include <stdbool.h>
#include <stddef.h>

/* Makes room for `more` items of `size` bytes behind the first `count` of *items, which are malloc'ed or NULL. False,
 * and all as it was, without memory. */
bool array_grow(void **items, size_t *capacity, size_t count, size_t more, size_t size);

#endif
