/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design 194d8956393bab30. */
/* Constant tables of headstock_mpc_lookup; included by headstock_mpc_lookup.c only. */
#ifndef HEADSTOCK_MPC_LOOKUP_TABLES_H
#define HEADSTOCK_MPC_LOOKUP_TABLES_H


/* moves where nothing is looked up; 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_safe, 8)")
static const sg_real headstock_mpc_lookup_safe[1] = {
    0.0f
};

/* coordinates of theta, transposed; 8 x 3 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_matrix, 8)")
static const sg_real headstock_mpc_lookup_matrix[24] = {
    -3.2126606f, -6.2527895f, -8.732036f, -11.237794f, -21.879576f, -30.565018f, -316.34982f,
    -596.29755f, -805.2175f, -1186.9304f, -2229.1013f, -2994.4194f, 0.001f, 0.001f,
    0.00093782746f, 0.00091609673f, 0.0004423943f, -3.2798045e-05f, -23.890078f, -45.1653f,
    -61.129017f, 24.672144f, 46.547558f, 62.858078f
};

/* of the hyperplanes, node by node; 7 x 3 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_normals, 8)")
static const sg_real headstock_mpc_lookup_normals[21] = {
    2.4143742e-16f, 0.060240243f, 0.9981839f, 4.0079088e-15f, 1.0f, 6.085958e-15f,
    3.8283903e-15f, 0.9552089f, -0.2959323f, 8.2977375e-31f, 2.6956743e-18f, 1.0f,
    4.0079088e-15f, 1.0f, 6.085958e-15f, 3.8283903e-15f, 0.9552089f, -0.2959323f,
    8.2977375e-31f, 2.6956743e-18f, 1.0f
};

/* their heights; 7 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_offsets, 8)")
static const sg_real headstock_mpc_lookup_offsets[7] = {
    0.99636453f, -1.0f, 0.6776755f, 1.0585271f, 1.0f, -1.2684613f, 0.93782747f
};

/* where to, not above: node, or -1 - law; 7 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_below, 8)")
static const int32_t headstock_mpc_lookup_below[7] = {
    1, 3, 5, -4, -1, -8, -2
};

/* where to, above it; 7 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_above, 8)")
static const int32_t headstock_mpc_lookup_above[7] = {
    2, 4, 6, -8, -2, -3, -6
};

/* of the laws, move by move; 9 x 3 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_gains, 8)")
static const sg_real headstock_mpc_lookup_gains[27] = {
    1000.0f, -8.655042e-12f, 7.289244e-12f, 1000.0f, -473.8733f, 4.405271e-12f, 1000.0f,
    1.9870304f, 32.925194f, 1000.0f, -473.8733f, 4.405271e-12f, 1000.0f, 1.9870304f, 32.925194f,
    1000.0f, -473.8733f, 180.351f, 1000.0f, -473.8733f, 180.351f, 1000.0f, -473.8733f, 180.351f,
    1000.0f, -473.8733f, 180.351f
};

/* of the laws; 9 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_constants, 8)")
static const sg_real headstock_mpc_lookup_constants[9] = {
    0.0f, 473.8733f, -32.86518f, -473.8733f, 32.86518f, 304.73517f, 664.7797f, -664.7797f,
    -304.73517f
};

/* lower bounds of the moves; 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_low, 8)")
static const sg_real headstock_mpc_lookup_low[1] = {
    -1000.0f
};

/* upper bounds; 1 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_high, 8)")
static const sg_real headstock_mpc_lookup_high[1] = {
    1000.0f
};

#endif
