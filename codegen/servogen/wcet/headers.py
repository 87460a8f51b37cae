"""Minimal standard headers, so that the preprocessed C holds no compiler extensions."""

from __future__ import annotations

_MATH_REAL = ("fabs", "sqrt", "floor", "ceil", "fmin", "fmax")
_TWO = ("fmin", "fmax")


def _math() -> str:
    lines = []
    for name in _MATH_REAL:
        for suffix, kind in (("", "double"), ("f", "float")):
            args = f"{kind} a, {kind} b" if name in _TWO else f"{kind} a"
            lines.append(f"{kind} {name}{suffix}({args});")
    # The type-generic macros of the real header stay calls here; the counter knows them by name.
    lines += [f"int {name}();" for name in ("isfinite", "isnan", "isinf", "signbit")]
    lines += ["#define HUGE_VAL 1e999", "#define INFINITY 1e99f", "#define NAN 0.0f"]
    return "\n".join(lines) + "\n"


HEADERS: dict[str, str] = {
    "math.h": _math(),
    "stdint.h": """typedef signed char int8_t;
typedef unsigned char uint8_t;
typedef short int16_t;
typedef unsigned short uint16_t;
typedef int int32_t;
typedef unsigned int uint32_t;
typedef long long int64_t;
typedef unsigned long long uint64_t;
#define INT32_MAX 2147483647
#define UINT32_MAX 4294967295u
#define INT32_C(x) x
#define UINT32_C(x) x ## u
""",
    # unsigned long is size_t on the host that runs the counted build and 32 bits on the targets.
    "stddef.h": """typedef unsigned long size_t;
typedef long ptrdiff_t;
#define NULL ((void *)0)
""",
    "stdbool.h": """#define bool _Bool
#define true 1
#define false 0
""",
    "float.h": """#define FLT_MAX 3.40282347e+38f
#define FLT_MIN 1.17549435e-38f
#define FLT_EPSILON 1.19209290e-07f
#define DBL_MAX 1.7976931348623157e+308
#define DBL_MIN 2.2250738585072014e-308
#define DBL_EPSILON 2.2204460492503131e-16
""",
    "limits.h": """#define INT_MAX 2147483647
#define INT_MIN (-INT_MAX - 1)
#define UINT_MAX 4294967295u
""",
    "string.h": """void *memset(void *to, int value, unsigned long size);
void *memcpy(void *to, const void *from, unsigned long size);
""",
    "assert.h": "#define assert(x) ((void)0)\n",
}
