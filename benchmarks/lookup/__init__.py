"""The benchmark of explicit lookups: programs, contenders, promises."""
