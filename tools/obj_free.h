/* obj_free.h - free-form surfaces of Wavefront OBJ files, statement by statement.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * Attributes (cstype, deg, bmat, step) hold until they are given again. An element (curv, curv2, surf) is open until
 * its `end`; in between stands its body (parm, trim, hole), and only there. */
#ifndef EPATCH_OBJ_FREE_H
#define EPATCH_OBJ_FREE_H

#include "tools/obj_curve2.h"
#include "tools/obj_text.h"

typedef struct obj_numbers {
    double *at;
    size_t count, capacity;
} obj_numbers;

typedef enum obj_element { OBJ_NONE, OBJ_CURVE, OBJ_CURVE2, OBJ_SURFACE } obj_element;

typedef struct obj_free {
    obj_text *text;
    scene_geometry *g;
    obj_numbers vertices, vertices2; /* x, y, z, weight and u, v, weight; v is NaN where it is not given */
    uint32_t surfaces;               /* that are complete */
    obj_curves curves;

    bool has_form, rational;
    obj_form form;
    unsigned degree[2]; /* 0: not given */
    size_t step[2];     /* 0: not given */
    obj_numbers matrix[2];

    obj_element open;
    obj_word opened;    /* its name */
    double range[2][2]; /* of a surface */
    obj_numbers points; /* its control points, 4 numbers each */
    obj_numbers parameters[2];
    bool has_trim, has_outer;
    loops trim;
} obj_free;

typedef struct obj_free_statement obj_free_statement;

/* NULL: no free-form statement is called so. */
const obj_free_statement *obj_find_free(obj_word name);

/* Reads the text's statement, or v's numbers. False after a message. */
bool obj_read_free(obj_free *f, const obj_free_statement *s);
bool obj_free_vertex(obj_free *f, const double p[4]);

/* At the end of the text: is nothing open? False after a message. */
bool obj_free_is_complete(const obj_free *f);
void obj_free_release(obj_free *f);

/* For the parts of this reader. False after a message. */
bool obj_add_numbers(obj_free *f, obj_numbers *to, const double *x, size_t count);
bool obj_read_parameter(obj_free *f, double *to);
/* u or v, as 0 or 1. */
bool obj_read_axis(obj_free *f, int *axis);

#endif
