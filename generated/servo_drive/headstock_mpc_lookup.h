/* SPDX-License-Identifier: MIT */
/* Made by servogen 0.1.0 from controller.h.jinja; not to be edited. Design 194d8956393bab30. */
/* First move from a search tree: 9 laws, 15 nodes */
#ifndef HEADSTOCK_MPC_LOOKUP_H
#define HEADSTOCK_MPC_LOOKUP_H

#include "headstock_types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    HEADSTOCK_MPC_LOOKUP_PARAMETERS = 8, /* length of theta */
    HEADSTOCK_MPC_LOOKUP_MOVES = 1, /* inputs that are looked up */
    HEADSTOCK_MPC_LOOKUP_EDGES = 0, /* facets of the feasible set */
    HEADSTOCK_MPC_LOOKUP_COORDINATES = 3, /* in which laws and hyperplanes are given */
    HEADSTOCK_MPC_LOOKUP_LAWS = 9, /* distinct laws of the first move */
    HEADSTOCK_MPC_LOOKUP_NODES = 7, /* inner nodes */
    HEADSTOCK_MPC_LOOKUP_TREE_DEPTH = 3, /* most nodes on a way to a leaf */
    HEADSTOCK_MPC_LOOKUP_MIRROR = 2 /* coordinate whose sign is taken off */
};

/* All state; the caller owns it, as many as she likes. Members are private. */
typedef struct {
    headstock_real eta[HEADSTOCK_MPC_LOOKUP_COORDINATES]; /* workspace, no meaning between calls */
    int32_t law; /* of the last move looked up, for whoever debugs */
} headstock_mpc_lookup_t;

typedef struct {
    headstock_real theta[8]; /* in its units [-1e+20 .. 1e+20]: the program's parameter */
} headstock_mpc_lookup_find_in;

typedef struct {
    headstock_real move[1]; /* mA [-1000.0 .. 1000.0]: first inputs of the optimum; zero, or the bound next to it, where the status is not OK */
    int32_t law; /* 1 [-1 .. 8]: which law gave it; -1 for none */
} headstock_mpc_lookup_find_out;

typedef headstock_mpc_lookup_find_in headstock_mpc_lookup_solve_in;
typedef headstock_mpc_lookup_find_out headstock_mpc_lookup_solve_out;

/* Before anything else: clears the state. */
void headstock_mpc_lookup_init(headstock_mpc_lookup_t *self);

/* The first move of the optimum for a parameter. */
sg_status headstock_mpc_lookup_find(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_find_in *in, headstock_mpc_lookup_find_out *out);

/* As find, for a parameter that the caller has bounded: that it is a number and in range is not looked at. */
sg_status headstock_mpc_lookup_solve(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_solve_in *in, headstock_mpc_lookup_solve_out *out);

#ifdef __cplusplus
}
#endif

#endif
