/* obj_net.h - control nets of free-form curves and surfaces: from any basis to B-splines, and parts of these.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Every basis but the B-spline's makes segments one by one: segment k takes degree+1 points from k times `step` on,
 * over parameters k to k+1, which its own t in [0,1] is proportional to. It becomes a Bézier curve; as a B-spline,
 * whose knots repeat degree+1 times. Functions that return a string return NULL, or what is wrong in words that live
 * until the next call. */
#ifndef EPATCH_OBJ_NET_H
#define EPATCH_OBJ_NET_H

#include <stdbool.h>
#include <stddef.h>

typedef enum obj_form { OBJ_BSPLINE, OBJ_BEZIER, OBJ_CARDINAL, OBJ_TAYLOR, OBJ_MATRIX } obj_form;

/* Of one parameter. */
typedef struct obj_basis {
    obj_form form;
    unsigned degree;
    size_t step;          /* of a matrix */
    const double *matrix; /* row i: the coefficients of point i's function, from t^0 to t^degree */
} obj_basis;

typedef struct obj_net {
    bool rational; /* else weights are 1 and stay so */
    unsigned degree[2];
    size_t count[2];     /* of points; 1 in v: a curve */
    double *knots[2];    /* count + degree + 1 */
    double (*points)[4]; /* Euclidean, with weights; u running fastest */
} obj_net;

void obj_net_free(obj_net *n);

/* How many points go with so many parameters; 0: with so few, none do. */
size_t obj_points_of(const obj_basis *b, size_t parameters);

/* The points, obj_points_of() along that axis, become a B-spline's. */
const char *obj_net_convert(obj_net *n, int axis, const obj_basis *b, const double *parameters, size_t count);

/* What lies between two parameters, from < to. */
const char *obj_net_cut(obj_net *n, int axis, double from, double to);

#endif
