/* Counting of operations at run time, for the host only: never part of a firmware.
 *
 * servogen rewrites emitted C so that each operation passes through one of these macros, which
 * count it and hand on its value. Whether it is an operation on reals or on integers the compiler
 * decides (_Generic), not the reader of the syntax tree: the two counts check each other.
 * Needs gcc (statement expressions). The names SG_N_... are the classes in Python's order. */
#ifndef SG_COUNTING_H
#define SG_COUNTING_H

extern unsigned long long sg_tally[SG_N_CLASSES];
extern unsigned long long sg_turns[SG_N_TURNS + 1];

static inline void sg_hit(int what, int times) { sg_tally[what] += (unsigned long long)times; }

/* The turn with this number, from 0, of a loop up to a named bound: the most of any loop is kept. */
static inline void sg_turn(int bound, int number)
{
    if ((unsigned long long)number >= sg_turns[bound]) {
        sg_turns[bound] = (unsigned long long)number + 1;
    }
}

#define SG_IS_REAL(v) _Generic((v), float: 1, double: 1, default: 0)
#define SG_KIND(v, real, whole) (SG_IS_REAL(v) ? (real) : (whole))
#define SG_PASS(e, real, whole) \
    (__extension__({ __auto_type sg_v = (e); sg_hit(SG_KIND(sg_v, real, whole), 1); sg_v; }))
#define SG_TEST(a, op, b) \
    (__extension__({ __auto_type sg_a = (a); __auto_type sg_b = (b); \
        sg_hit(SG_IS_REAL(sg_a) ? SG_N_CMP : SG_KIND(sg_b, SG_N_CMP, SG_N_INT_CMP), 1); \
        sg_a op sg_b; }))

#define SG_ADD(e) SG_PASS(e, SG_N_ADD, SG_N_INT_ADD)
#define SG_MUL(e) SG_PASS(e, SG_N_MUL, SG_N_INT_MUL)
#define SG_DIV(e) SG_PASS(e, SG_N_DIV, SG_N_INT_DIV)
#define SG_NEG(e) SG_PASS(e, SG_N_NEG, SG_N_INT_ADD)
#define SG_LOAD(e) SG_PASS(e, SG_N_LOAD, SG_N_INT_LOAD)
#define SG_STORE(e) SG_PASS(e, SG_N_STORE, SG_N_INT_STORE)
#define SG_NOT(e) SG_TEST(e, ==, 0)
#define SG_LT(a, b) SG_TEST(a, <, b)
#define SG_LE(a, b) SG_TEST(a, <=, b)
#define SG_GT(a, b) SG_TEST(a, >, b)
#define SG_GE(a, b) SG_TEST(a, >=, b)
#define SG_EQ(a, b) SG_TEST(a, ==, b)
#define SG_NE(a, b) SG_TEST(a, !=, b)
#define SG_TRUTH(e) \
    (__extension__({ __auto_type sg_t = (e); sg_hit(SG_N_CMP, SG_IS_REAL(sg_t)); sg_t != 0; }))
#define SG_IF(e) (sg_hit(SG_N_BRANCH, 1), (e))
#define SG_AND(a, b) (sg_hit(SG_N_BRANCH, 1), (a) && (b))
#define SG_OR(a, b) (sg_hit(SG_N_BRANCH, 1), (a) || (b))
#define SG_SWITCH(n, e) (sg_hit(SG_N_INT_CMP, n), sg_hit(SG_N_BRANCH, n), (e))
#define SG_CALL(e) (sg_hit(SG_N_CALL, 1), (e))
#define SG_COUNT(what, e) (sg_hit(what, 1), (e))
#define SG_WORDS(loads, stores, bytes, e) \
    (sg_hit(SG_N_CALL, 1), sg_hit(SG_N_INT_LOAD, (loads) * (((int)(bytes) + 3) / 4)), \
     sg_hit(SG_N_INT_STORE, (stores) * (((int)(bytes) + 3) / 4)), (e))
#define SG_COPY(reals, others, e) \
    (sg_hit(SG_N_LOAD, reals), sg_hit(SG_N_INT_LOAD, others), \
     sg_hit(SG_N_STORE, reals), sg_hit(SG_N_INT_STORE, others), (e))

#endif
