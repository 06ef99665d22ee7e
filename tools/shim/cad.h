/* cad.h - the faces of a STEP, IGES or BREP file as trimmed NURBS surfaces, by OpenCASCADE, which is loaded at the
 * first call.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_CAD_H
#define EPATCH_CAD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum cad_format { CAD_STEP, CAD_IGES, CAD_BREP } cad_format;

/* A NURBS curve in a face's parameters. */
typedef struct cad_curve {
    unsigned degree;
    size_t count, knot_count;
    const double *knots;
    const double (*points)[3]; /* x, y, weight */
} cad_curve;

typedef struct cad_loop {
    size_t count;
    const cad_curve *curves; /* one after the other; small gaps remain where the file has them */
} cad_loop;

typedef struct cad_face {
    unsigned degree[2]; /* in u and in v */
    size_t count[2];    /* of control points */
    size_t knot_count[2];
    const double *knots[2];
    const double (*points)[4]; /* u running fastest; Euclidean, with a weight */
    size_t loop_count;         /* 0: all of the surface; else what is inside an odd number of them */
    const cad_loop *loops;
} cad_face;

/* Is called for each of the `total` faces in their order, with the face, or with NULL and why it is none that can be
 * traced. Returns false to end early, which is no failure. */
typedef bool (*cad_taker)(void *user, uint32_t index, uint32_t total, const cad_face *face, const char *problem);

/* Lengths are millimetres. NULL, or what is wrong with the file, in a buffer that the next call writes to. */
const char *cad_read(const char *path, cad_format format, cad_taker take, void *user);

#ifdef __cplusplus
}
#endif
#endif
