"""The benchmark of QP back ends: sequences, peers, counts, promises."""
