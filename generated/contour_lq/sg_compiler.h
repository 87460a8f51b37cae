/* SPDX-License-Identifier: MIT */
/*
 * What one compiler is told that no other needs to know. Everything here is empty or plain C unless
 * a compiler's own macro, or the builder, asks for it: results are the same bits either way.
 *
 * SG_PRAGMA("MUST_ITERATE(20, 20)")     before a loop: least and greatest number of its turns
 * SG_PRAGMA("DATA_ALIGN(object, 8)")    before the definition of an object: pairs load as one
 */
#ifndef SG_COMPILER_H
#define SG_COMPILER_H

#if defined(__TI_COMPILER_VERSION__) && defined(_TMS320C6X)
#define SG_PRAGMA(text) _Pragma(text)
#else
#define SG_PRAGMA(text)
#endif

#endif
