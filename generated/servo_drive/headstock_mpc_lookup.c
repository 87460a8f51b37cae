/* SPDX-License-Identifier: MIT */
/*
 * Made by servogen 0.1.0 from lookup_tree.c.jinja; not to be edited.
 * Design 194d8956393bab306f4e51be322f6fe719d57e926f5156d4a75b3bef48eebba1.
 *
 * First move from a search tree: 9 laws, 15 nodes
 *
 * Counted in this C, calls of other files included (servogen wcet): operations on headstock_real, bytes
 * of C objects on the stack. Constant tables of this file: 420 bytes.
 *
 * worst case of one call                      add mul div cmp other load store stack
 * headstock_mpc_lookup_init                     0   0   0   0     0    0     3    20
 * headstock_mpc_lookup_find                    33  36   0  46     4   82    15   140
 *   fixed part                                 27  27   0  43     4   61    15
 *   each of 3 HEADSTOCK_MPC_LOOKUP_TREE_DEPTH   2   3   0   1     0    7     0
 * headstock_mpc_lookup_solve                   33  36   0   6     4   74    15   124
 *   fixed part                                 27  27   0   3     4   53    15
 *   each of 3 HEADSTOCK_MPC_LOOKUP_TREE_DEPTH   2   3   0   1     0    7     0
 */
#include "headstock_mpc_lookup.h"
#include "headstock_scalar.h"
#include "headstock_mpc_lookup_tables.h"

/* The law of the leaf that a point is in. */
static int32_t headstock_mpc_lookup_descend(const sg_real *restrict eta)
{
    int32_t at = 0;
    SG_PRAGMA("MUST_ITERATE(1, 3)")
    for (int level = 0; level < HEADSTOCK_MPC_LOOKUP_TREE_DEPTH; level++) {
        const sg_real height =
            sg_dot(HEADSTOCK_MPC_LOOKUP_COORDINATES, &headstock_mpc_lookup_normals[at * HEADSTOCK_MPC_LOOKUP_COORDINATES], eta);
        at = (height > headstock_mpc_lookup_offsets[at]) ? headstock_mpc_lookup_above[at] : headstock_mpc_lookup_below[at];
        if (at < 0) {
            break;
        }
    }
    /* no leaf is deeper: a walk never ends on a node */
    return sg_bound_count(-1 - at, 0, HEADSTOCK_MPC_LOOKUP_LAWS - 1);
}

/* The law of the leaf that a point is in, and what that law says, not clipped yet. */
static int32_t headstock_mpc_lookup_apply(const sg_real *restrict eta, sg_real *restrict move)
{
    const int32_t law = headstock_mpc_lookup_descend(eta);
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int32_t j = 0; j < HEADSTOCK_MPC_LOOKUP_MOVES; j++) {
        const int32_t row = (law * HEADSTOCK_MPC_LOOKUP_MOVES) + j;
        move[j] = sg_dot(HEADSTOCK_MPC_LOOKUP_COORDINATES, &headstock_mpc_lookup_gains[row * HEADSTOCK_MPC_LOOKUP_COORDINATES], eta) + headstock_mpc_lookup_constants[row];
    }
    return law;
}

/* The first moves for a theta in range; gives back which law they are by. */
static int32_t headstock_mpc_lookup_evaluate(headstock_mpc_lookup_t *self, const sg_real *restrict theta, sg_real *restrict move)
{
    sg_matvec(HEADSTOCK_MPC_LOOKUP_COORDINATES, HEADSTOCK_MPC_LOOKUP_PARAMETERS, headstock_mpc_lookup_matrix, theta, self->eta);
    if (self->eta[HEADSTOCK_MPC_LOOKUP_MIRROR] < (sg_real)0) {
        /* the solution is odd: half of the tree answers for both */
        SG_PRAGMA("MUST_ITERATE(3, 3)")
        for (int i = 0; i < HEADSTOCK_MPC_LOOKUP_COORDINATES; i++) {
            self->eta[i] = -self->eta[i];
        }
        self->law = headstock_mpc_lookup_apply(self->eta, move);
        SG_PRAGMA("MUST_ITERATE(1, 1)")
        for (int j = 0; j < HEADSTOCK_MPC_LOOKUP_MOVES; j++) {
            move[j] = -move[j];
        }
    } else {
        self->law = headstock_mpc_lookup_apply(self->eta, move);
    }
    SG_PRAGMA("MUST_ITERATE(1, 1)")
    for (int j = 0; j < HEADSTOCK_MPC_LOOKUP_MOVES; j++) {
        move[j] = sg_clamp(move[j], headstock_mpc_lookup_low[j], headstock_mpc_lookup_high[j]);
    }
    return self->law;
}

void headstock_mpc_lookup_init(headstock_mpc_lookup_t *self)
{
    sg_fill(HEADSTOCK_MPC_LOOKUP_COORDINATES, (sg_real)0, self->eta);
    self->law = 0;
}

/* What is told where nothing is looked up. */
static void headstock_mpc_lookup_refuse(headstock_mpc_lookup_find_out *out)
{
    out->law = -1;
    sg_copy(HEADSTOCK_MPC_LOOKUP_MOVES, headstock_mpc_lookup_safe, out->move);
}

sg_status headstock_mpc_lookup_solve(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_solve_in *in, headstock_mpc_lookup_solve_out *out)
{
    out->law = headstock_mpc_lookup_evaluate(self, in->theta, out->move);
    return SG_OK;
}

sg_status headstock_mpc_lookup_find(headstock_mpc_lookup_t *self, const headstock_mpc_lookup_find_in *in, headstock_mpc_lookup_find_out *out)
{
    sg_status status = SG_OK;
    /*@ dynamic_split status; */
    status = sg_worse(status, sg_check_array(8, in->theta, -1.0e+20f, 1.0e+20f));
    if (status == SG_OK) {
        status = headstock_mpc_lookup_solve(self, in, out);
    } else {
        headstock_mpc_lookup_refuse(out);
    }
    /*@ merge status; */
    return status;
}
