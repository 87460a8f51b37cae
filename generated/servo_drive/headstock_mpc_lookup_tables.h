/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from tables.h.jinja; not to be edited. Design efe801d2719c8dc7. */
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
    -3.2126606f, -6.2527895f, -9.126024f, -11.237794f, -21.879576f, -31.94367f, -316.34982f,
    -596.29755f, -842.74005f, -1186.9304f, -2229.1013f, -3134.659f, 0.001f, 0.001f, 0.001f,
    0.00091609673f, 0.0004423943f, -6.110758e-06f, -23.890078f, -45.1653f, -63.971336f,
    24.672144f, 46.547558f, 65.787125f
};

/* of the hyperplanes, node by node; 13 x 3 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_normals, 8)")
static const sg_real headstock_mpc_lookup_normals[39] = {
    4.930221e-15f, 0.95688134f, -0.29047903f, 4.0079088e-15f, 1.0f, 6.074865e-15f,
    4.0079088e-15f, 1.0f, 6.074865e-15f, -4.0050792e-15f, -0.060349844f, 0.9981773f,
    -3.7700746e-15f, 1.1379153e-15f, 1.0f, -3.7700746e-15f, 1.1379153e-15f, 1.0f,
    -4.0050792e-15f, -0.060349844f, 0.9981773f, 4.930221e-15f, 0.95688134f, -0.29047903f,
    -4.0050792e-15f, -0.060349844f, 0.9981773f, -3.7700746e-15f, 1.1379153e-15f, 1.0f,
    4.930221e-15f, 0.95688134f, -0.29047903f, 4.930221e-15f, 0.95688134f, -0.29047903f,
    -4.0050792e-15f, -0.060349844f, 0.9981773f
};

/* their heights; 13 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_offsets, 8)")
static const sg_real headstock_mpc_lookup_offsets[13] = {
    0.66640234f, -1.0f, 1.0f, -0.93782747f, 1.0f, -1.0f, 0.93782747f, -0.66640234f, 1.0585271f,
    -1.0f, -1.2473603f, 1.2473603f, -1.0585271f
};

/* where to, not above: node, or -1 - law; 13 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_below, 8)")
static const int32_t headstock_mpc_lookup_below[13] = {
    1, 3, 5, 7, 9, 11, 12, -9, -4, -5, -8, -5, -7
};

/* where to, above it; 13 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_above, 8)")
static const int32_t headstock_mpc_lookup_above[13] = {
    2, 4, 6, 8, 10, -1, -6, -5, -8, -1, -3, -7, -2
};

/* of the laws, move by move; 9 x 3 */
SG_PRAGMA("DATA_ALIGN(headstock_mpc_lookup_gains, 8)")
static const sg_real headstock_mpc_lookup_gains[27] = {
    1000.0f, -9.094947e-12f, 7.275958e-12f, 1000.0f, -473.8733f, 4.3972417e-12f, 1000.0f,
    -9.057549e-12f, 32.86518f, 1000.0f, -473.8733f, 4.3972417e-12f, 1000.0f, -9.057549e-12f,
    32.86518f, 1000.0f, -484.75745f, 180.02226f, 1000.0f, -484.75745f, 180.02226f, 1000.0f,
    -484.75745f, 180.02226f, 1000.0f, -484.75745f, 180.02226f
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
