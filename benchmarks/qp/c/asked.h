/* What a solver's setup asks of malloc, for solvers linked with -Wl,--wrap=malloc and so on. */
#ifndef ASKED_H
#define ASKED_H
#ifdef __cplusplus
extern "C" {
#endif
extern long asked_bytes;
extern int asked_counting;
#ifdef __cplusplus
}
#endif
#endif
