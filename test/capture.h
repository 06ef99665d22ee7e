/* capture.h - rays that were answered wrongly once, and the patches that they were sent at, as text.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * A file is a list of patches, each with its rays. `#` starts a comment; numbers are exact.
 *
 *     triangle 2 from 4 depth 3   degree 2; optional: rays start up to 4 away (EPBuildSettings.rayDistance), maxDepth
 *     0 0 0 1                     x y z w of each point, in the order of embree_patch.h
 *     ...
 *     ray 0 0 5 0 0 -1            origin, direction
 *
 * and `tensor 3 2` for a patch of degree 3 in u and 2 in v. */
#ifndef TEST_CAPTURE_H
#define TEST_CAPTURE_H

#include "test/hits.h"

#include <stdio.h>

typedef struct capture {
    test_patch patch;
    EPBuildSettings settings;
    test_ray *rays;
    size_t ray_count;
} capture;

/* The captures in a file; `count` is their number. Fails the test when it is not of this form. */
capture *read_captures(const char *path, size_t *count);
void free_captures(capture *captures, size_t count);

void write_captured_patch(FILE *file, const test_patch *p, const EPBuildSettings *settings);
void write_captured_ray(FILE *file, const test_ray *ray);

#endif
